"""Dead volume of a choke foil, 0.15 cm3, against external chokes, 1.2 cm3 (section 4.3).

The thesis: the dead volume, too, limits the smallest mass that a pulse can move.
"""

from dataclasses import dataclass, replace

import numpy as np

from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics, load_pneumatics
from thesis.chapter_4 import FULL, MG, NOTE, OTHER, THESIS_LINE, rms
from thesis.chapter_4.boxes import WORKING, box_of, calibrated, smallest_steps
from thesis.chapter_4.rig_run import (
    SMALL_SINE,
    SineOnBottles,
    final_drift,
    of,
    on_bottles,
    tracking_error,
    under,
)
from thesis.frame import Axes, Figure, Job, Report, Results, number, option

SMALLEST_PULSE = 0.045  # of the box [s]
NAMES = ("foil", "external")
TITLES = {"foil": "choke foil", "external": "external choke"}
SMALL = SMALL_SINE | {"channels": 1}


@dataclass(frozen=True)
class Parameters(SineOnBottles):
    """Options of the experiment."""

    foil: float = option(0.15e-6, "dead volume of a choke foil [m3]")
    external: float = option(1.2e-6, "dead volume of an external choke [m3]")


def run(given: Parameters, job: Job) -> Results:
    """Smallest steps of both, and how each tracks the sine by a calibration of its own."""
    results: Results = {}
    for name in NAMES:
        box = _with_dead_volume(box_of(given.seed), getattr(given, name))
        steps = smallest_steps(box, given.channels, SMALLEST_PULSE, given.seed)
        own = calibrated(
            box, given.channels, given.points, given.seed, job.progress, given.supplies
        )
        run = on_bottles(box, own, given.seed).follow(given, job.progress)
        results |= {f"{name}_steps": steps, **under(name, run)}
    return results


def _with_dead_volume(box: Pneumatics, volume: float) -> Pneumatics:
    return replace(box, choke=replace(box.choke, dead_volume=volume))


def added_air(given: Parameters) -> float:
    """Mass that the larger dead volume adds to each inflation, by the gas law [kg].

    The dead volume is at supply pressure when the valve closes, and its air then expands into the
    channel.
    """
    drop = load_pneumatics("pneumaticbox").supply.pressure - WORKING
    return float(air_mass(drop, given.external - given.foil))


def report(results: Results, given: Parameters) -> Report:
    """Smallest steps, tracking error and drift with both."""
    up = {name: float(results[f"{name}_steps"][0].mean()) / MG for name in NAMES}
    down = {name: float(results[f"{name}_steps"][1].mean()) / MG for name in NAMES}
    runs = {name: of(name, results) for name in NAMES}
    errors = {k: float(rms(tracking_error(run, given))) / MG for k, run in runs.items()}
    drifts = {k: float(np.abs(final_drift(run)).max()) / MG for k, run in runs.items()}
    findings = [number("added air of an inflation, gas law", added_air(given) / MG, "mg")]
    findings += [number("added air of an inflation, measured", up["external"] - up["foil"], "mg")]
    for name, title in TITLES.items():
        findings += [
            number(f"{title}: smallest inflation", up[name], "mg"),
            number(f"{title}: smallest deflation", down[name], "mg"),
            number(f"{title}: RMS tracking error", errors[name], "mg"),
            number(f"{title}: final drift, worst channel", drifts[name], "mg"),
        ]
    conclusion = (
        f"External chokes make the smallest inflation {up['external']:.2f} mg instead of "
        f"{up['foil']:.2f} mg, and the tracking error {errors['external']:.2f} mg instead of "
        f"{errors['foil']:.2f} mg (thesis: foil chosen to keep the dead volume small)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Smallest steps per channel, and the tracking error of the first channel over time."""
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.6))
    draw_steps(left, results, NAMES, TITLES)
    law = report["choke foil: smallest inflation"] + report["added air of an inflation, gas law"]
    left.axhline(law, color=THESIS_LINE, ls="--", lw=1.0)
    left.annotate("choke foil + gas law", (-0.45, law), (0, -11), **NOTE)
    left.set_ylim(0, 1.35 * law)
    for name, colour in zip(NAMES, (FULL, OTHER), strict=True):
        run = of(name, results)
        error = (run["truth"][:, 0] - run["target"]) / MG
        right.plot(run["time"], error, color=colour, lw=0.9, label=TITLES[name])
    right.set(xlabel="time [s]", ylabel="tracking error of channel 1 [mg]", ylim=(-8, 8))
    right.set_xlim(5, None)
    right.legend(loc="lower right", ncols=2)


def draw_steps(
    panel: Axes, results: Results, names: tuple[str, ...], titles: dict[str, str]
) -> None:
    """Bars of the smallest inflation and deflation, points of the channels."""
    for place, name in enumerate(names):
        for side, (row, colour) in enumerate(
            zip(results[f"{name}_steps"], (FULL, OTHER), strict=True)
        ):
            x = place + 0.4 * side - 0.2
            label = ("inflation", "deflation")[side] if place == 0 else None
            panel.bar(x, row.mean() / MG, 0.36, color=colour, alpha=0.75, label=label)
            panel.plot(np.full(len(row), x), row / MG, ".", color="#222222", ms=4)
    panel.set_xticks(range(len(names)), [titles[name] for name in names])
    panel.set(ylabel="smallest pulse [mg]", xlim=(-0.5, len(names) - 0.5))
    panel.legend(loc="upper left")
