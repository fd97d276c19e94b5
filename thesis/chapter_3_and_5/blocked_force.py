"""Force of a P10 finger's blocked tip over pressure (Fig. 5.11)."""

from dataclasses import dataclass

import numpy as np

from pneuflex_sim.hand.collision import BOXES, PIECES
from softhand_model.equilibrium.planar import exact_springs
from softhand_model.hand.actuator import Actuator, load_actuator
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger
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
    gap: float = option(0.015, "from the straight finger to the block [m]")
    segments: int = option(10, "segments in the simulator [-]")


def run(given: Parameters, job: Job) -> Results:
    """Force at every pressure: simulator, static chains, and a chain of springs that stiffen."""
    actuator = load_actuator("P10.finger")
    gap, segments = given.gap, given.segments
    simulated, touched = _simulated(actuator, BOXES, given)
    job.progress("collision pieces", 0.5)
    return {
        "pressures": list(PRESSURES),
        "gap": gap,
        "simulated": simulated,
        "with_pieces": _simulated(actuator, PIECES, given)[0],
        "touched_at": touched,
        "chain": [  # blocked where the tip is: Bullet keeps contacts 0.01 mm apart
            blocked_finger(actuator, segments, pressure, place[0]).tip_force
            for pressure, place in zip(PRESSURES, touched, strict=True)
        ],
        "fine_chain": [blocked_finger(actuator, FINEST, p, gap).tip_force for p in PRESSURES[-3:]],
        "section_moments": [
            blocked_finger(
                actuator, segments, p, gap, exact_springs(actuator, segments, p)
            ).tip_force
            for p in PRESSURES
        ],
    }


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
    linear, bent = _slopes(results, "simulated"), _slopes(results, "section_moments")
    pieces = 100.0 * (results["with_pieces"] / simulated - 1.0)
    forces = ", ".join(f"{np.interp(p, pressures, simulated):.2f}" for p in (20e3, 30e3, 50e3))
    printed = "printed as a curve without numbers; matches the finger"
    growth = "nonlinear as the finger's, with linear springs"
    moments, outline = (
        "the same with the moments of section 3.4.3",
        "collision pieces along the outline, against boxes",
    )
    findings = [
        Finding("force at 20, 30, 50 kPa", printed, f"{forces} N"),
        Finding("growth, 15-20 and 40-50 kPa", growth, _growth(linear)),
        Finding(moments, "-", _growth(bent)),
        Finding(outline, "-", f"force {pieces.min():+.1f} to {pieces.max():+.1f} %"),
        at_most("simulator against the same static chain", "-", chain, 0.1, "%"),
        at_most(f"{given.segments} segments against {FINEST}, from 30 kPa", "-", fine, 1.0, "%"),
    ]
    conclusion = (
        f"Linear springs make the force grow {linear[1] / linear[0]:.1f} times as fast at high "
        "pressure as at low, because the free curvature does; the moments of the section itself "
        f"would make it grow {bent[1] / bent[0]:.1f} times as fast."
    )
    return Report(findings, conclusion)


def _growth(slope: tuple[float, float]) -> str:
    return f"{slope[0]:.3f} and {slope[1]:.3f} N/kPa: {slope[1] / slope[0]:.2f} times"


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Force over pressure."""
    axes = figure.subplots()
    pressures = np.array(results["pressures"]) / 1e3
    axes.plot(pressures, results["chain"], "C0", lw=1, label="static chain, linear springs")
    axes.plot(pressures, results["simulated"], "C0o", ms=5, label="simulator, 10 segments")
    axes.plot(pressures, results["section_moments"], "C1--", label="static chain, moments of 3.4.3")
    axes.set(xlabel="pressure [kPa]", ylabel="force of the blocked tip [N]", xlim=(0, None))
    axes.set_ylim(0, None)
    axes.legend(fontsize=8)
