"""Tip angle over pressure of four wall thicknesses (Figs. 3.11, 3.12, 5.10)."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator, load_actuator
from softhand_model.hand.profile import ConstantProfile
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.frame import Array, Figure, Finding, Job, Report, Results, at_most, option

MODULUS_SCALE = 1.1  # of 67 kPa, as the thesis fitted it (5.2.2)
PRESSURES = (5e3, 10e3, 15e3, 20e3, 30e3, 40e3, 46.3e3)  # [Pa]
LOW = 10e3  # [Pa], where the thesis found its thickest finger too stiff


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    walls: tuple[float, ...] = option(
        (0.0025, 0.0035, 0.0045, 0.0055), "thicknesses, on top and at the sides, ascending [m]"
    )
    segments: int = option(10, "segments of a finger [-]")


def actuator_of(wall: float) -> Actuator:
    """A P10 finger with another wall [m], on top and at the sides."""
    hull = ConstantProfile(wall)
    return replace(load_actuator("P10.finger"), wall=hull, side_wall=hull).with_modulus(
        MODULUS_SCALE
    )


def run(given: Parameters, job: Job) -> Results:
    """Tip angle of every wall at every pressure, and the curvature along it at the last one."""
    walls: Results = {}
    for wall in given.walls:
        job.progress(f"wall of {1e3 * wall:g} mm", len(walls) / len(given.walls))
        walls[f"{1e3 * wall:g}"] = bent(actuator_of(wall), given.segments)
    return {"pressures": list(PRESSURES), "walls": walls}


def bent(actuator: Actuator, segments: int) -> dict[str, Any]:
    """Tip angles [rad] of a finger at PRESSURES, and its curvature [1/m] at the last of them."""
    pressures, simulated = np.array(PRESSURES), []
    with FingerStand(actuator, segments) as stand:
        for pressure in PRESSURES:
            stand.settle(pressure)
            simulated.append(float(stand.bends().sum()))
        curvature = stand.bends() * segments / actuator.length
    return {
        "wall": float(actuator.wall(0.0)),
        "simulated": simulated,
        "exact": actuator.tip_angle(pressures).tolist(),
        "printed": _printed(actuator, pressures).tolist(),
        "curvature": curvature.tolist(),
    }


def _printed(actuator: Actuator, pressures: Array) -> Array:
    """Tip angle by eqs. 5.2 and 5.3, as in the thesis's simulator."""
    x, weight = actuator.quadrature()
    curvature = section.free_curvature_printed(
        pressures[:, None], *actuator.sides(x), actuator.shear_modulus
    )
    return np.sum(weight * curvature, axis=-1)


def _scaled(results: Results) -> dict[str, Array]:
    """Angles of the thinnest wall, scaled to other thicknesses by the design rule 3.32."""
    walls = results["walls"]
    thinnest = walls[min(walls, key=float)]
    angles = np.array(thinnest["simulated"]) * thinnest["wall"]
    return {name: angles / wall["wall"] for name, wall in walls.items()}


def report(results: Results, given: Parameters) -> Report:
    """Each wall at the highest pressure; how well the design rule extrapolates from the thinnest
    wall.
    """
    pressures, walls, findings = results["pressures"], results["walls"], []
    scaled = _scaled(results)
    thinnest, thickest = min(walls, key=float), max(walls, key=float)
    low = pressures.index(LOW)
    for name, wall in walls.items():
        angle, curvature = np.degrees(wall["simulated"][-1]), wall["curvature"]
        rise = 100.0 * (curvature[-1] / curvature[0] - 1.0)
        what = f"{name} mm: tip angle at {pressures[-1] / 1e3:g} kPa"
        ours = f"{angle:.1f} deg; curvature of the last segment {rise:+.0f} % against the first"
        findings.append(Finding(what, "no number; an arc of a circle", ours))
        if name != thinnest:
            rule = 100.0 * (1.0 - np.array(wall["simulated"]) / scaled[name])
            what = f"{name} mm against {thinnest} mm scaled by the rule"
            seen = "stiffer than that at low pressure" if name == "5.5" else "agrees"
            ours = f"bends {_by(-rule[low])} at {LOW / 1e3:g} kPa, {_by(-rule[-1])} at the end"
            findings.append(Finding(what, seen, ours))
    errors = [np.divide(wall["simulated"], wall["exact"]) - 1.0 for wall in walls.values()]
    worst = 100.0 * float(np.abs(errors).max())
    printed = [np.divide(wall["printed"], wall["exact"]) - 1.0 for wall in walls.values()]
    spread = f"{100.0 * np.min(printed):+.1f} to {100.0 * np.max(printed):+.1f} %"
    findings += [
        at_most("tip angle, simulator against the exact integral", "-", worst, 0.1, "%"),
        Finding("tip angle by eq. 5.3 against the exact one", "matches well", spread),
    ]
    more = 100.0 * (np.array(walls[thickest]["simulated"]) / scaled[thickest] - 1.0)
    conclusion = (
        "The simulator has the exact curve. Against the thin finger scaled by the rule, that of "
        f"{thickest} mm bends {_by(more[0])} at {pressures[0] / 1e3:g} kPa and {_by(more[-1])} "
        f"at {pressures[-1] / 1e3:g} kPa. The thesis's bent less at low pressure, "
        "which neither the exact curve nor eq. 5.3 explains."
    )
    return Report(findings, conclusion)


def _by(percent: float) -> str:
    return f"{abs(percent):.0f} % {'more' if percent > 0.0 else 'less'}"


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Angles over pressure as in Fig. 5.10, and curvature along the fingers as in Fig. 3.11."""
    left, right = figure.subplots(1, 2)
    pressures, scaled = np.array(results["pressures"]) / 1e3, _scaled(results)
    for k, (name, wall) in enumerate(results["walls"].items()):
        left.plot(pressures, np.degrees(wall["exact"]), f"C{k}", lw=1)
        left.plot(pressures, np.degrees(wall["simulated"]), f"C{k}o", ms=4, label=f"{name} mm")
        left.plot(pressures, np.degrees(scaled[name]), f"C{k}:", lw=1)
        count = len(wall["curvature"])
        place = (np.arange(count) + 0.5) * 100.0 / count
        right.plot(place, wall["curvature"], f"C{k}o-", ms=3, lw=1)
    left.plot([], [], "k-", lw=1, label="exact")
    left.plot([], [], "k:", lw=1, label="2.5 mm, scaled by the rule")
    left.set(xlabel="pressure [kPa]", ylabel="tip angle [deg]", xlim=(0, None), ylim=(0, None))
    left.legend(fontsize=8)
    right.set(xlabel="place along the finger [%]", ylabel="curvature [1/m]", ylim=(0, None))
    right.set_title(f"at {pressures[-1]:g} kPa", fontsize=9)
