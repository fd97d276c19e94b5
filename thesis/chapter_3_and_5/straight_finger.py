"""Finger of linear stiffness that stays straight with its tip blocked (Fig. 3.13)."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softhand_model.hand.actuator import Actuator, load_actuator
from softhand_model.hand.profile import ConstantProfile, TaperedProfile
from thesis.chapter_3_and_5.planar import exact_springs
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger
from thesis.frame import Figure, Finding, Job, Report, Results, at_most, option

LENGTH, HEIGHT = 0.09, 0.02  # [m]
NEARLY_ROUND = 60e3  # [Pa] that bend the free finger to 357 deg; static chain only
SEGMENTS = 10
BLOCK_BOTTOMS = {"tapered": 0.085, "even": 0.07}  # [m], so that the tip alone meets the block
SIDE = TaperedProfile(HEIGHT, LENGTH, 1.0, 3)
"""Height, width and a quarter of the circumference, which fall as (1 - x/L)**(1/3)."""
SMALL = {"pressures": (10e3,)}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    pressures: tuple[float, ...] = option((10e3, 20e3, 30e3, 40e3), "pressures, ascending [Pa]")


def tapered() -> Actuator:
    """The actuator of section 3.5.2: its stiffness, and the moment that keeps it straight, fall
    linearly towards the tip.
    """
    around = TaperedProfile(4.0 * HEIGHT, LENGTH, 1.0, 3)
    return _shaped(SIDE, around)


def even() -> Actuator:
    """The same with one section from base to tip, for comparison."""
    return _shaped(ConstantProfile(HEIGHT), ConstantProfile(4.0 * HEIGHT))


def _shaped(side: Any, around: Any) -> Actuator:
    finger = load_actuator("P10.finger")
    return replace(finger, length=LENGTH, height=side, width=side, circumference=around)


def run(given: Parameters, job: Job) -> Results:
    """Shapes and joint angles of both fingers at every pressure, with their tips held in place."""
    fingers: Results = {"tapered": [], "even": []}
    for k, pressure in enumerate(given.pressures):
        job.progress(f"{pressure / 1e3:g} kPa", k / len(given.pressures))
        for actuator, shape in ((tapered(), "tapered"), (even(), "even")):
            fingers[shape].append(_blocked(actuator, shape, pressure))
    pressures = [*given.pressures, NEARLY_ROUND]
    return {
        "pressures": list(given.pressures),
        "bends_by_section_moments": [_by_section_moments(pressure) for pressure in pressures],
        "length": LENGTH,
        **fingers,
    }


def _blocked(actuator: Actuator, shape: str, pressure: float) -> dict[str, Any]:
    with FingerStand(actuator, SEGMENTS) as stand:
        block = stand.block(0.0, BLOCK_BOTTOMS[shape])
        stand.settle(pressure)
        touch = stand.touch(block)
        line, bends = stand.line()[:, [0, 2]], stand.bends()
    return {
        "force": touch.force,
        "touched_at": touch.place.tolist(),
        "line": line.tolist(),
        "bends": bends.tolist(),
        "free_angle": float(actuator.tip_angle(pressure)),
        "static_force": blocked_finger(actuator, SEGMENTS, pressure, 0.0).tip_force,
    }


def _by_section_moments(pressure: float) -> list[float]:
    """Joint angles [rad] of the static chain whose joints carry the moments of section 3.4.3."""
    springs = exact_springs(tapered(), SEGMENTS, pressure)
    return blocked_finger(tapered(), SEGMENTS, pressure, 0.0, springs).angles.tolist()


def bow(finger: dict[str, Any]) -> float:
    """Largest distance [m] of the line from the straight finger."""
    return float(np.abs(np.array(finger["line"])[:, 0]).max())


def report(results: Results, given: Parameters) -> Report:
    """How far the fingers deviate from the straight line."""
    length, pressures, findings = results["length"], results["pressures"], []
    pairs = zip(pressures, results["tapered"], results["even"], strict=True)
    for pressure, finger, even_one in pairs:
        what = f"{pressure / 1e3:g} kPa (free: {np.degrees(finger['free_angle']):.0f} deg)"
        ours = f"off the line by {1e3 * bow(finger):.2f} mm, an even section by"
        seen = "straight; the last 10 to 15 mm bend slightly forward"
        findings.append(Finding(what, seen, f"{ours} {1e3 * bow(even_one):.1f} mm"))
    lowest = results["tapered"][0]
    low = 100.0 * bow(lowest) / length
    moment = lowest["force"] * lowest["touched_at"][1] / (lowest["static_force"] * length)
    angle = float(np.degrees(np.abs(results["bends_by_section_moments"]).max()))
    whats = (
        f"off the line at {pressures[0] / 1e3:g} kPa, of the length",
        "largest joint angle with the moments of 3.4.3, to 60 kPa",
        "moment about the base at the lowest pressure, against the static chain",
    )
    findings += [
        at_most(whats[0], "straight", low, 1.0, "%"),
        at_most(whats[1], "straight", angle, 1e-3, "deg"),
        at_most(whats[2], "-", 100.0 * abs(moment - 1.0), 1.0, "%"),
    ]
    worst, other = (1e3 * bow(results[key][-1]) for key in ("tapered", "even"))
    conclusion = (
        "With the moments of section 3.4.3 the finger stays exactly straight. With linear springs "
        f"it does at low pressure; at {pressures[-1] / 1e3:g} kPa it leaves the line by "
        f"{worst:.1f} mm (an even section: {other:.1f} mm), because the free curvature then "
        "depends on the height, which the springs do not know."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Lines of both fingers at all pressures."""
    panels = figure.subplots(1, 2, sharey=True, sharex=True)
    for axes, key, title in zip(
        panels, ("tapered", "even"), ("(1 - x/L)^(1/3)", "even section"), strict=True
    ):
        for pressure, finger in zip(results["pressures"], results[key], strict=True):
            x, z = 1e3 * np.array(finger["line"]).T
            axes.plot(z, x, "o-", ms=3, lw=1, label=f"{pressure / 1e3:g} kPa")
        axes.set_title(f"circumference: {title}", fontsize=9)
        axes.set_xlabel("along the finger [mm]")
    panels[0].set_ylabel("off the straight line [mm]")
    panels[0].legend(fontsize=8)
