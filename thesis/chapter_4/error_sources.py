"""What makes the errors of chapter 4: sources one at a time, and all together (section 4.4.3).

The thesis: the baseline is 7 times worse in deflation, a shared calibration 4 times worse.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from softhand_model.pneumatics import Pneumatics, load_pneumatics
from thesis.chapter_4 import FULL, STEP, THESIS_LINE, pulse_error, six_channels
from thesis.chapter_4.rig_run import SMALL_SINE, SineOnBottles
from thesis.frame import Figure, Job, Report, Results, number, option

SIZE = (9.0, 4.2)
FIGURES = {
    "deflation, baseline / full model": ("", "about 7", 7.0),
    "inflation, baseline / full model": ("", "almost as good", 1.0),
    "mean tracking error, shared / own": ("", "about 4", 4.0),
    "final drift, worst channel": ("mg", "< 2.5, but one", STEP),
}
"""Unit and the thesis's result of each figure, and where the picture has it."""
SMALL = SMALL_SINE | {"channels": 1, "tests": 8, "boxes": 2}


@dataclass(frozen=True)
class Parameters(SineOnBottles):
    """Options of the experiment."""

    channels: int = option(2, "outlets of the box [-]")
    duration: float = option(30.0, "time of the sine [s]")
    boxes: int = option(10, "how many of the boxes, from the first on [-]")
    tests: int = option(50, "pulses per channel that no calibration has seen [-]")


def boxes(seed: int) -> dict[str, Pneumatics]:
    """The ideal box with one error source each, of the size in the Pneumaticbox or of the size in
    its name.
    """
    ideal, real = load_pneumatics("ideal"), load_pneumatics("pneumaticbox")
    valve, alone = ideal.valve, "alone"
    delays = {"opening_delay": real.valve.opening_delay, "closing_delay": real.valve.closing_delay}
    sections: dict[str, dict[str, Any]] = {
        "ideal box": {},
        "Pneumaticbox": {},
        f"valves as alike as the Pneumaticbox's, {alone}": {"valve": replace(valve, **delays)},
        f"chokes as alike as the Pneumaticbox's, {alone}": {"choke": real.choke},
        f"sensors of the Pneumaticbox, {alone}": {
            "channel_sensor": real.channel_sensor,
            "supply_sensor": real.supply_sensor,
        },
        f"heat of the Pneumaticbox, {alone}": {"gas": real.gas},
        f"valve jitter of 2 ms, {alone}": {"valve": replace(valve, delay_jitter=2e-3)},
        f"sensor noise of 200 Pa, {alone}": {
            "channel_sensor": replace(ideal.channel_sensor, noise=200.0)
        },
        f"converter of 10 bits, {alone}": {
            "channel_sensor": replace(ideal.channel_sensor, bits=10.0)
        },
        f"supply that sags 10 times as much, {alone}": {
            "supply": replace(ideal.supply, droop=10 * ideal.supply.droop)
        },
    }
    made = {name: replace(ideal, **changed) for name, changed in sections.items()}
    made["Pneumaticbox"] = real
    return {n: replace(box, box_seed=box.box_seed + seed) for n, box in made.items()}


def run(given: Parameters, job: Job) -> Results:
    """The four figures of every box (boxes, figures), and their names."""
    common = {f.name: getattr(given, f.name) for f in fields(SineOnBottles)}
    sine = six_channels.Parameters(**common)
    pulses = pulse_error.Parameters(given.seed, 2 * given.points, given.tests, given.channels)
    rows, made = [], dict(list(boxes(given.seed).items())[: given.boxes])
    for done, box in enumerate(made.values()):
        job.progress("boxes", done / len(made))
        silent = replace(job, progress=lambda what, share: None)
        errors = pulse_error.report(pulse_error.on_box(box, pulses, silent), pulses)
        tracked = six_channels.report(six_channels.on_box(box, sine, silent), sine)
        rows.append(
            [
                errors["deflation: baseline / full model"],
                errors["inflation: baseline / full model"],
                tracked["mean tracking error, shared / own"],
                tracked["final drift, worst channel, by the sensors"],
            ]
        )
    return {"figures": np.array(rows), "boxes": list(made)}


def report(results: Results, given: Parameters) -> Report:
    """One row per box: deflation, inflation, shared calibration, drift."""
    findings = [
        number(f"{name}: {figure}", float(value), unit, thesis)
        for name, row in zip(results["boxes"], results["figures"], strict=True)
        for (figure, (unit, thesis, _)), value in zip(FIGURES.items(), row, strict=True)
    ]
    first, last = results["figures"][:2]
    conclusion = (
        f"From the ideal box to the Pneumaticbox, baseline over full model falls from "
        f"{first[0]:.1f} to {last[0]:.1f} in deflation (thesis: about 7) and from {first[1]:.1f} "
        f"to {last[1]:.1f} in inflation (almost as good), shared over own calibration from "
        f"{first[2]:.1f} to {last[2]:.1f} (about 4)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """A panel a figure, a bar a box, the thesis's figure as a line."""
    axes = figure.subplots(1, len(FIGURES), sharey=True)
    names = [name.replace(", alone", "") for name in results["boxes"]][::-1]
    for panel, (title, (_, _, thesis)), values in zip(
        axes, FIGURES.items(), results["figures"].T, strict=True
    ):
        panel.barh(names, values[::-1], color=FULL, height=0.6)
        panel.axvline(thesis, color=THESIS_LINE, ls="--", lw=1.2)
        panel.set_xscale("log")
        panel.set_title(title.replace(", ", ",\n"), fontsize=8)
    axes[0].tick_params(axis="y", labelsize=7.5)
