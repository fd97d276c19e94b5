"""The force at which a held cylinder slides in RBO Hand 2 (section 7.3.1, Fig. 7.10 b-d)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pneuflex_sim.validation.experiment import Experiment, Finding, Results
from pneuflex_sim.validation.held_cylinder import STEP, Grasp, HeldCylinder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HAND, PLACE = "rbo_hand_2", (0.055, 0.0, 0.115)
PRESSURES = (45e3, 52e3, 60e3, 70e3)  # [Pa] of fingers, thumb and inner palm
OUTER_PALM = 1.5  # pressure of channel d over that of the others: its wall is thicker
DIRECTIONS = {  # [-] in the wrist's frame
    "out of the palm": (1.0, 0.0, 0.0),
    "along the fingers": (0.0, 0.0, 1.0),
    "across the fingers": (0.0, 1.0, 0.0),
}
RATE, LARGEST = 4.0, 16.0  # [N/s], [N]
SLID = 0.010  # [m] by which the cylinder has moved when it counts as slid
FAR = 0.030  # [m] where a push is ended: it has run away, and not just given way with the hand
THESIS = (6.0, 8.0)  # [N]; the pressure is not given


def pushed(held: HeldCylinder, direction: tuple[float, float, float]) -> dict[str, Any]:
    """Force [N] growing in a direction, and how far [m] the cylinder has moved."""
    start, forces, ways = held.place, [], []
    for k in range(round(LARGEST / RATE / STEP)):
        force = RATE * STEP * (k + 1)
        held.load(force * np.array(direction))
        way = float(np.linalg.norm(held.place - start))
        if k % 10 == 0 or way >= FAR:
            forces.append(force)
            ways.append(way)
        if way >= FAR:
            break
    return {"force": forces, "way": ways}


def simulate() -> Results:
    """Pushes in three directions at every pressure, each from the same grasp."""
    grasps = []
    for pressure in PRESSURES:
        channels = (pressure, pressure, pressure, OUTER_PALM * pressure)
        with HeldCylinder(Grasp(HAND, PLACE, channels)) as held:
            saved, pushes = held.save(), {}
            for name, direction in DIRECTIONS.items():
                held.restore(saved)
                pushes[name] = pushed(held, direction)
            held.restore(saved)
            grasps.append({"pressure": pressure, "touching": held.touching(), "pushes": pushes})
    return {"grasps": grasps}


def sliding_force(push: dict[str, Any], slid: float = SLID) -> float:
    """Force [N] that has moved the cylinder by `slid` [m]; infinite when none has.

    >>> sliding_force({"force": [0.0, 4.0, 8.0], "way": [0.0, 0.005, 0.015]})
    6.0
    """
    reached = np.maximum.accumulate(push["way"])
    if reached[-1] < slid:
        return float("inf")
    return float(np.interp(slid, reached, push["force"]))


def report(results: Results) -> list[Finding]:
    """Sliding forces at every pressure; whether the hand can reach the thesis's forces."""
    findings = []
    forces = {name: [] for name in DIRECTIONS}
    for grasp in results["grasps"]:
        found = {name: sliding_force(push) for name, push in grasp["pushes"].items()}
        for name, force in found.items():
            forces[name].append(force)
        words = ", ".join(
            f"{force:.1f} ({_shown(sliding_force(grasp['pushes'][name], FAR))}) N {name}"
            for name, force in found.items()
        )
        findings.append(
            Finding(
                f"moved by {1e3 * SLID:g} ({1e3 * FAR:g}) mm at {grasp['pressure'] / 1e3:g} kPa",
                "-",
                words,
            )
        )
    for name, found in forces.items():
        findings.append(
            Finding(
                f"force {name}, all pressures",
                f"{THESIS[0]:g}-{THESIS[1]:g} N, pressure not given",
                f"{min(found):.1f} to {max(found):.1f} N",
                min(found) < THESIS[1] and max(found) > THESIS[0],
            )
        )
    return findings


def _shown(force: float) -> str:
    return f"{force:.1f}" if np.isfinite(force) else f"above {LARGEST:g}"


def conclude(results: Results) -> str:
    """What came out."""
    means = [
        np.mean([sliding_force(push) for push in grasp["pushes"].values()])
        for grasp in results["grasps"]
    ]
    middle = np.interp(np.mean(THESIS), means, [grasp["pressure"] for grasp in results["grasps"]])
    return (
        f"Of three directions in the mean, {np.mean(THESIS):g} N move the cylinder by "
        f"{1e3 * SLID:g} mm at {middle / 1e3:.0f} kPa; the force grows steeply with the pressure, "
        "which the thesis does not give."
    )


def draw(figure: Figure, results: Results) -> None:
    """Way over force in each direction."""
    panels = figure.subplots(1, len(DIRECTIONS), sharex=True, sharey=True)
    for axes, name in zip(panels, DIRECTIONS, strict=True):
        axes.axvspan(*THESIS, color="0.88")
        for grasp in results["grasps"]:
            push = grasp["pushes"][name]
            label = f"{grasp['pressure'] / 1e3:g} kPa"
            axes.plot(push["force"], 1e3 * np.array(push["way"]), lw=1, label=label)
        axes.axhline(1e3 * SLID, color="0.6", ls=":", lw=1)
        axes.set_title(name, fontsize=9)
        axes.set_xlabel("force [N]")
    panels[0].set(ylabel="way of the cylinder [mm]", xlim=(0, LARGEST), ylim=(0, 1e3 * FAR))
    panels[0].legend(fontsize=8, title="grey: thesis", title_fontsize=8)


EXPERIMENT = Experiment(
    "disturbance",
    "force at which a cylinder slides in RBO Hand 2 (7.3.1, Fig. 7.10)",
    simulate,
    report,
    conclude,
    draw,
    (9.0, 3.6),
)
