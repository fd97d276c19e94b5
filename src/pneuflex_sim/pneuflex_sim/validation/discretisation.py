"""How many segments a finger needs: its tip blocked, 3 to 50 segments (section 5.2.1, Fig. 5.8).

A PyBullet body reports at most 30 spherical joints, so 50 segments are the static discrete chain of
`softhand_model.statics`, which the simulator is compared with at all the other numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pneuflex_sim.validation.experiment import Experiment, Finding, Results
from pneuflex_sim.validation.stand import FingerStand
from pneuflex_sim.validation.static_finger import blocked_finger, chain_of, line_of
from softhand_model.actuator import load_actuator
from softhand_model.statics import planar_finger

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ACTUATOR = "P10.finger"
SEGMENTS = (3, 5, 10, 20)  # in the simulator
FINEST = 50  # as a static chain
JUDGED = 10  # segments that are held to a target
PRESSURE, GAP = 40e3, 0.015  # [Pa, m]
BLOCK_BOTTOM = 0.07  # [m]


def simulate() -> Results:
    """Fingers that press on a block (force, tip, line of the passive layer), and free ones."""
    length = load_actuator(ACTUATOR).length
    fingers = {str(count): {"static": _static(count)} for count in (*SEGMENTS, FINEST)}
    for count in SEGMENTS:
        fingers[str(count)]["simulated"] = _simulated(count)
    return {"pressure": PRESSURE, "gap": GAP, "length": length, "fingers": fingers}


def _simulated(segments: int) -> dict[str, Any]:
    with FingerStand(load_actuator(ACTUATOR), segments) as stand:
        stand.settle(PRESSURE)
        free_tip = stand.line()[-1, [0, 2]]
        stand.settle(0.0)
        block = stand.block(GAP, BLOCK_BOTTOM)
        stand.settle(PRESSURE)
        touch = stand.touch(block)
        return {
            "force": touch.force,
            "touched_at": touch.place.tolist(),
            "tip_angle": float(stand.bends().sum()),
            "line": stand.line()[:, [0, 2]].tolist(),
            "free_tip": free_tip.tolist(),
        }


def _static(segments: int) -> dict[str, Any]:
    actuator = load_actuator(ACTUATOR)
    found = blocked_finger(actuator, segments, PRESSURE, GAP)
    model = chain_of(actuator, segments)
    finger = planar_finger(model.segments)
    line = line_of(finger, found.angles)
    free_line = line_of(finger, model.rest_rotation([PRESSURE])[:, 1])
    return {
        "force": found.tip_force,
        "tip_angle": float(found.angles.sum()),
        "line": line.tolist(),
        "free_tip": free_line[-1].tolist(),
    }


def report(results: Results) -> list[Finding]:
    """Each number of segments against 50, and the simulator against the static chain."""
    fingers, length = results["fingers"], results["length"]
    finest = fingers[str(FINEST)]["static"]
    findings = []
    for count in SEGMENTS:
        finger = fingers[str(count)]["simulated"]
        force = 100.0 * abs(finger["force"] / finest["force"] - 1.0)
        tip = 100.0 * _distance(finger["line"][-1], finest["line"][-1]) / length
        shape = 100.0 * _largest_gap(finger["line"], finest["line"]) / length
        free = 100.0 * _distance(finger["free_tip"], finest["free_tip"]) / length
        turn = np.degrees(finger["tip_angle"] - finest["tip_angle"])
        findings.append(
            Finding(
                f"{count} against 50 segments",
                "deviates at the tip" if count == 3 else "same shape but at the tip",
                f"blocked: tip {tip:.2g}, shape {shape:.2g} % of the length, force {force:.2g} %, "
                f"tip angle {turn:+.2g} deg; free: tip {free:.2g} % of the length"
                + (" (all but the angle <= 1 %)" if count == JUDGED else ""),
                max(tip, shape, force, free) <= 1.0 if count == JUDGED else None,
            )
        )
    errors = [
        100.0 * abs(pair["simulated"]["force"] / pair["static"]["force"] - 1.0)
        for pair in (fingers[str(count)] for count in SEGMENTS)
    ]
    what = "force, simulator against the same static chain"
    return [*findings, Finding.at_most(what, "-", max(errors), 0.1, "%")]


def _distance(one: list[float], other: list[float]) -> float:
    return float(np.hypot(*np.subtract(one, other)))


def _largest_gap(coarse: list[list[float]], fine: list[list[float]]) -> float:
    """Largest distance [m] between two lines at equal shares of their length."""
    share = np.linspace(0.0, 1.0, 201)
    return float(np.linalg.norm(_at(coarse, share) - _at(fine, share), axis=1).max())


def _at(line: list[list[float]], share: np.ndarray) -> np.ndarray:
    places = np.array(line)
    gone = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    return np.stack([np.interp(share, gone / gone[-1], column) for column in places.T], axis=1)


def conclude(results: Results) -> str:
    """What came out."""
    fingers, length = results["fingers"], results["length"]
    finest = fingers[str(FINEST)]["static"]["line"]
    gaps = {
        count: _largest_gap(fingers[str(count)]["simulated"]["line"], finest) / length
        for count in SEGMENTS
    }
    words = ", ".join(f"{count}: {100 * gap:.2g} %" for count, gap in gaps.items())
    return f"Largest distance to the shape of 50 segments, of the length: {words}."


def draw(figure: Figure, results: Results) -> None:
    """The shapes over one another, and their distance to that of 50 segments."""
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.6))
    fingers, length = results["fingers"], results["length"]
    finest, share = fingers[str(FINEST)]["static"]["line"], np.linspace(0.0, 1.0, 201)
    x, z = 1e3 * np.array(finest).T
    left.plot(x, z, "k", lw=3, alpha=0.3)
    for color, count in enumerate(SEGMENTS):
        line = fingers[str(count)]["simulated"]["line"]
        x, z = 1e3 * np.array(line).T
        left.plot(x, z, f"C{color}o-", ms=3, lw=1)
        gap = np.linalg.norm(_at(line, share) - _at(finest, share), axis=1)
        right.plot(100.0 * share, 100.0 * gap / length, f"C{color}", label=f"{count} segments")
    left.axvspan(1e3 * results["gap"], 1e3 * results["gap"] + 6, 0.75, 1.0, color="0.8")
    left.set_title("grey: 50 segments", fontsize=9)
    left.set(xlabel="x [mm]", ylabel="z [mm]", aspect="equal")
    right.set(
        xlabel="place along the finger [%]",
        ylabel="distance to the shape of 50 segments [% of length]",
    )
    right.axhline(1.0, color="0.6", ls=":", lw=1)
    right.legend(fontsize=8)


EXPERIMENT = Experiment(
    "discretisation",
    "P10 finger of 3 to 50 segments with its tip blocked (Fig. 5.8)",
    simulate,
    report,
    conclude,
    draw,
)
