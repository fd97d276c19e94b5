"""Force at which a cylinder slides in RBO Hand 2, and in RBO Hand 1 (7.2, 7.3.1, Fig. 7.10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from thesis.chapter_3_and_5.held_cylinder import STEP, Grasp, HeldCylinder
from thesis.chapter_3_and_5.slip import SlipMeter
from thesis.frame import Figure, Finding, Job, Report, Results, option

SIZE = (9.0, 5.0)
HAND, PLACE = "rbo_hand_2", (0.055, 0.0, 0.115)
HAND_1, PLACE_1, SEGMENTS_1 = "rbo_hand_1", (0.062, 0.0, 0.100), 10
OUTER_PALM = 1.5  # pressure of channel d over that of the others: its wall is thicker
DIRECTIONS = {  # [-] in the wrist's frame
    "out of the palm": (1.0, 0.0, 0.0),
    "along the fingers": (0.0, 0.0, 1.0),
    "across the fingers": (0.0, 1.0, 0.0),
}
LARGEST = 16.0  # [N]
SLID = 0.003  # [m] that the cylinder has slid on what touches it when it counts as slid
OTHERS = (0.001, 0.010)  # [m] for which the force is told beside it
FAR = 0.060  # [m] of its way where a push is ended: it has run away
SAMPLED = 5  # steps from one look at the slip to the next
JUDGED = 60e3  # [Pa], at which the hand carries its payload
THESIS = (6.0, 8.0)  # [N]; the pressure is not given
SMALL = {"pressures": (JUDGED,), "hand_1": (), "rate": 16.0}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    pressures: tuple[float, ...] = option(
        (45e3, 52e3, 60e3, 70e3), "of fingers, thumb and inner palm; 60 kPa among them [Pa]"
    )
    hand_1: tuple[float, ...] = option(
        (150e3, 210e3), "pressures of RBO Hand 1, under its model file [Pa]"
    )
    rate: float = option(4.0, "of the growing force [N/s]")

    def __post_init__(self) -> None:
        if JUDGED not in self.pressures or not self.rate > 0.0:
            raise ValueError(f"pressures must have {JUDGED:g} Pa, rate be above 0, got {self}")


def pushed(
    held: HeldCylinder, direction: tuple[float, float, float], rate: float
) -> dict[str, Any]:
    """Force [N] that grows in a direction, displacement [m] of the cylinder, and how far [m] it has
    slid on the links that touch it.
    """
    start, meter = held.place, SlipMeter(held.simulation)
    found: dict[str, list[float]] = {"force": [], "way": [], "slip": []}
    for k in range(round(LARGEST / rate / STEP)):
        force = rate * STEP * (k + 1)
        held.load(force * np.array(direction))
        if (k + 1) % SAMPLED:
            continue
        found["force"].append(force)
        found["way"].append(float(np.linalg.norm(held.place - start)))
        found["slip"].append(meter.look())
        if found["way"][-1] >= FAR:
            break
    return found


def run(given: Parameters, job: Job) -> Results:
    """Pushes in three directions at every pressure, each from the same grasp."""
    every = [(p, Grasp(HAND, PLACE, (p, p, p, OUTER_PALM * p))) for p in given.pressures]
    every += [(p, Grasp(HAND_1, PLACE_1, (p,), SEGMENTS_1, HAND_1)) for p in given.hand_1]
    grasps: list[dict[str, Any]] = []
    for pressure, grasp in every:
        job.progress(f"{grasp.hand}, {pressure / 1e3:g} kPa", len(grasps) / len(every))
        with HeldCylinder(grasp) as held:
            saved, pushes = held.simulation.save(), {}
            for name, direction in DIRECTIONS.items():
                held.simulation.restore(saved)
                pushes[name] = pushed(held, direction, given.rate)
            held.simulation.restore(saved)
            grasps.append(
                {
                    "hand": grasp.hand,
                    "pressure": pressure,
                    "touching": held.touching(),
                    "pushes": pushes,
                }
            )
    return {"grasps": grasps}


def sliding_force(push: dict[str, Any], slip: float = SLID) -> float:
    """Force [N] at which the cylinder has slid by `slip` [m]; infinite when it has not.

    >>> sliding_force({"force": [0.0, 4.0, 8.0], "slip": [0.0, 0.001, 0.005]})
    6.0
    """
    reached = np.array(push["slip"])
    if reached[-1] < slip:
        return float("inf")
    return float(np.interp(slip, reached, push["force"]))


def report(results: Results, given: Parameters) -> Report:
    """Sliding forces at every pressure. The target is the thesis's force for RBO Hand 2 at the
    payload's pressure.
    """
    findings = []
    for grasp in results["grasps"]:
        pressure, second = grasp["pressure"], grasp["hand"] == HAND
        judged = second and pressure == JUDGED
        printed = f"{THESIS[0]:g}-{THESIS[1]:g} N" if judged else "-"
        for name, push in grasp["pushes"].items():
            force, way = sliding_force(push), np.interp(SLID, push["slip"], push["way"])
            others = ", ".join(
                f"{1e3 * other:g} mm at {_shown(sliding_force(push, other))}" for other in OTHERS
            )
            slid = f"{_shown(force)}, displaced by {1e3 * way:.0f} mm"
            met = bool(THESIS[0] <= force <= THESIS[1]) if judged else None
            hand = f"RBO Hand {2 if second else 1} at {pressure / 1e3:g} kPa"
            what = f"{hand}{', ' if judged else ': '}{name}"
            findings.append(Finding(what, printed, f"{slid} ({others})", met))
    return Report(findings, conclude(results))


def _shown(force: float) -> str:
    return f"{force:.1f} N" if np.isfinite(force) else f"more than {LARGEST:g} N"


def conclude(results: Results) -> str:
    """The conclusion of the report."""
    second = [grasp for grasp in results["grasps"] if grasp["hand"] == HAND]
    judged = next(grasp for grasp in second if grasp["pressure"] == JUDGED)
    forces = [sliding_force(push) for push in judged["pushes"].values()]
    means = [
        np.mean([min(sliding_force(push), LARGEST) for push in grasp["pushes"].values()])
        for grasp in second
    ]
    words = ", ".join(
        f"{mean:.1f} N at {grasp['pressure'] / 1e3:g} kPa"
        for mean, grasp in zip(means, second, strict=True)
    )
    return (
        f"At {JUDGED / 1e3:g} kPa, with which the hand carries its payload, the cylinder slides at "
        f"{_shown(min(forces))} to {_shown(max(forces))}; in the thesis, above {THESIS[0]:g} to "
        f"{THESIS[1]:g} N. "
        f"The force grows steeply with the pressure, which the thesis does not give: {words}, in "
        "the mean of the directions."
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Slip (above) and displacement (below) over force in each direction."""
    panels = figure.subplots(2, len(DIRECTIONS), sharex=True, sharey="row")
    for (upper, lower), name in zip(panels.T, DIRECTIONS, strict=True):
        for axes, key in ((upper, "slip"), (lower, "way")):
            axes.axvspan(*THESIS, color="0.88")
            for grasp in results["grasps"]:
                push, first = grasp["pushes"][name], grasp["hand"] == HAND_1
                label = f"{'Hand 1, ' if first else ''}{grasp['pressure'] / 1e3:g} kPa"
                line = ":" if first else "-"
                axes.plot(push["force"], 1e3 * np.array(push[key]), line, lw=1, label=label)
        upper.axhline(1e3 * SLID, color="0.6", ls=":", lw=1)
        upper.set_title(name, fontsize=9)
        lower.set_xlabel("force [N]")
    panels[0, 0].set(ylabel="slid on the hand [mm]", xlim=(0, LARGEST), ylim=(0, 10))
    panels[1, 0].set(ylabel="way [mm]", ylim=(0, 1e3 * FAR))
    panels[0, 0].legend(fontsize=8, title="grey: thesis", title_fontsize=8)
