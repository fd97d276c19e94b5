"""Force of a P10 finger's blocked tip over pressure (Fig. 5.11).

The tip is held where it is in the straight finger. There the finger stands out beside its tip, and
a flat block would be touched elsewhere: the static chain has its tip alone held, and the simulator
is compared with it on a block some way off, which the tip alone touches.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pneuflex_sim.hand.collision import BOXES, HULL_PIECES
from softhand_model.hand.actuator import Actuator, load_actuator
from thesis.chapter_3_and_5.planar import exact_springs, planar_finger
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger, chain_of, line_of
from thesis.frame import Figure, Finding, Job, Report, Results, at_most, option

SIZE = (6.0, 4.0)

PRESSURES = (10e3, 15e3, 20e3, 30e3, 40e3, 50e3)  # [Pa]
SMALL = {"segments": 5}
BLOCK_BOTTOM = 0.07  # [m]
FINEST = 50  # segments


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    # from this gap on the tip alone touches, at every pressure
    gap: float = option(0.015, "from the straight finger to the simulator's block [m]")
    segments: int = option(10, "segments in the simulator [-]")


def run(given: Parameters, job: Job) -> Results:
    """Force at every pressure: tip held without a gap, by linear springs and by springs that
    stiffen; simulator on its block, and the chain there.
    """
    actuator = load_actuator("P10.finger")
    gap, segments = given.gap, given.segments
    simulated, touched = _simulated(actuator, BOXES, given)
    job.progress("collision pieces", 0.5)
    return {
        "pressures": list(PRESSURES),
        "gap": gap,
        "simulated": simulated,
        "with_pieces": _simulated(actuator, HULL_PIECES, given)[0],
        "touched_at": touched,
        "chain": [  # blocked where the tip is: Bullet keeps contacts 0.01 mm apart
            blocked_finger(actuator, segments, pressure, place[0]).tip_force
            for pressure, place in zip(PRESSURES, touched, strict=True)
        ],
        "fine_chain": [blocked_finger(actuator, FINEST, p, gap).tip_force for p in PRESSURES[-3:]],
        "held": [blocked_finger(actuator, segments, p, 0.0).tip_force for p in PRESSURES],
        "bulge": [bulge(actuator, segments, p) for p in PRESSURES],
        "section_moments": [
            blocked_finger(
                actuator, segments, p, 0.0, exact_springs(actuator, segments, p)
            ).tip_force
            for p in PRESSURES
        ],
    }


def bulge(actuator: Actuator, segments: int, pressure: float) -> float:
    """How far [m] a finger whose tip is held without a gap stands out beside it."""
    angles = blocked_finger(actuator, segments, pressure, 0.0).angles
    return float(line_of(planar_finger(chain_of(actuator, segments).segments), angles)[:, 0].max())


def _simulated(
    actuator: Actuator, collision: str, given: Parameters
) -> tuple[list[float], list[list[float]]]:
    """Forces [N] on the block, and the places (2,) [m] of their centres, at every pressure."""
    touches = []
    with FingerStand(actuator, given.segments, collision=collision) as stand:
        block = stand.block(given.gap, BLOCK_BOTTOM)
        for pressure in PRESSURES:
            stand.settle(pressure)
            touches.append(stand.touch(block))
    return [touch.force for touch in touches], [touch.place.tolist() for touch in touches]


def _slopes(results: Results, key: str) -> tuple[float, float]:
    """Newtons per kilopascal between 15 and 20, and between 40 and 50 kPa."""
    force = np.interp([15e3, 20e3, 40e3, 50e3], results["pressures"], results[key])
    return float(force[1] - force[0]) / 5.0, float(force[3] - force[2]) / 10.0


def report(results: Results, given: Parameters) -> Report:
    """The simulator against the chains; how force grows with pressure."""
    pressures, simulated = results["pressures"], np.array(results["simulated"])
    chain = 100.0 * np.abs(simulated / results["chain"] - 1.0).max()
    fine = 100.0 * np.abs(simulated[-3:] / results["fine_chain"] - 1.0).max()
    linear, bent = _slopes(results, "held"), _slopes(results, "section_moments")
    pieces = 100.0 * (results["with_pieces"] / simulated - 1.0)
    printed = "printed as a curve without numbers; matches the finger"
    growth = "nonlinear as the finger's, with linear springs"
    away = f"simulator, block {1e3 * results['gap']:g} mm off"
    stands_out = 1e3 * np.interp([20e3, 50e3], pressures, results["bulge"])
    findings = [
        Finding("force at 20, 30, 50 kPa, tip held", printed, _forces(pressures, results["held"])),
        Finding("growth, 15-20 and 40-50 kPa", growth, _growth(linear)),
        Finding("the same with the moments of section 3.4.3", "-", _growth(bent)),
        Finding(
            "the finger stands out beside its tip at 20 and 50 kPa",
            "-",
            f"{stands_out[0]:.1f} and {stands_out[1]:.1f} mm",
        ),
        Finding(f"force at 20, 30, 50 kPa, {away}", "-", _forces(pressures, simulated)),
        Finding(
            "collision pieces along the outline, against boxes",
            "-",
            f"force {pieces.min():+.1f} to {pieces.max():+.1f} %",
        ),
        at_most(f"{away}, against the same static chain", "-", chain, 0.1, "%"),
        at_most(f"{given.segments} segments against {FINEST}, from 30 kPa", "-", fine, 1.0, "%"),
    ]
    conclusion = (
        f"Linear springs make the force grow {linear[1] / linear[0]:.1f} times as fast at high "
        "pressure as at low, because the free curvature does; the moments of the section itself "
        f"would make it grow {bent[1] / bent[0]:.1f} times as fast."
    )
    return Report(findings, conclusion)


def _forces(pressures: list[float], force: ArrayLike) -> str:
    return ", ".join(f"{np.interp(p, pressures, force):.2f}" for p in (20e3, 30e3, 50e3)) + " N"


def _growth(slope: tuple[float, float]) -> str:
    return f"{slope[0]:.3f} and {slope[1]:.3f} N/kPa: {slope[1] / slope[0]:.2f} times"


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Force over pressure."""
    axes = figure.subplots()
    pressures = np.array(results["pressures"]) / 1e3
    gap = f"{1e3 * results['gap']:g} mm off"
    axes.plot(pressures, results["held"], "C0", label="tip held, linear springs")
    axes.plot(pressures, results["section_moments"], "C1--", label="tip held, moments of 3.4.3")
    axes.plot(pressures, results["chain"], "0.5", lw=1, label=f"static chain, block {gap}")
    axes.plot(pressures, results["simulated"], "o", color="0.5", ms=5, label="simulator there")
    axes.set(xlabel="pressure [kPa]", ylabel="force of the blocked tip [N]", xlim=(0, None))
    axes.set_ylim(0, None)
    axes.legend(fontsize=8)
