"""A sine of air mass while the supply varies by a quarter, and while it does not (Fig. 4.7).

The thesis: a supply that varies by 25 % has no discernible effect.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import FULL, MG, OTHER, SUPPLY, TARGET, rms
from thesis.chapter_4.boxes import box_of, calibrated
from thesis.chapter_4.rig_run import (
    SMALL_SINE,
    SineOnBottles,
    final_drift,
    of,
    on_bottles,
    tracking_error,
    under,
)
from thesis.frame import Figure, Job, Report, Results, number, option

SIZE = (8.0, 5.6)
NEXT_NOISE = 1000  # from the seed of one run to that of the next
SMALL = SMALL_SINE | {"channels": 2, "turns": 1.0, "runs": 2}


@dataclass(frozen=True)
class Parameters(SineOnBottles):
    """Options of the experiment."""

    points: int = option(400, "calibration pulses per channel, both directions together [-]")
    channels: int = option(8, "outlets of the box, all on the same sine [-]")
    supply: float = option(290e3, "mean supply pressure [Pa gauge]")
    variation: float = option(0.25, "from the lowest to the highest supply, of the mean [-]")
    runs: int = option(3, "runs under each supply, with noise of their own [-]")
    turns: float = option(4.0, "how often the supply goes down and up during the sine [-]")


def run(given: Parameters, job: Job) -> Results:
    """Calibrate a box; track the sine under a constant supply, and under one that varies."""
    return on_box(box_of(given.seed), given, job)


def on_box(box: Pneumatics, given: Parameters, job: Job) -> Results:
    """The same with a box of other constants."""
    own = calibrated(box, given.channels, given.points, given.seed, job.progress, given.supplies)
    supplies = {"constant": lambda time: given.supply, "varied": varied(given)}
    runs: Results = {}
    for run in range(given.runs):
        for name, supply in supplies.items():
            rig = on_bottles(box, own, given.seed + run * NEXT_NOISE)
            runs |= under(f"{name}_{run}", rig.follow(given, job.progress, supply))
    return runs


def varied(given: Parameters) -> Callable[[float], float]:
    """Gauge supply [Pa] over time [s], piecewise linear: a regulator that is turned by hand."""
    half, turn = 0.5 * given.variation, given.duration / given.turns

    def supply(time: float) -> float:
        phase = max(time - given.fill, 0.0) / turn % 1.0
        triangle = 4 * abs((phase + 0.25) % 1.0 - 0.5) - 1.0
        return given.supply * (1 + half * triangle)

    return supply


def report(results: Results, given: Parameters) -> Report:
    """Tracking errors and drift with and without the variation.

    The drift of a single run depends on the noise and is as large as the rest of the error. So the
    errors of all runs are given, with their spread.
    """
    names = ("constant", "varied")
    runs = {n: [of(f"{n}_{k}", results) for k in range(given.runs)] for n in names}
    single = {n: [float(rms(tracking_error(r, given))) / MG for r in runs[n]] for n in names}
    errors = {name: float(rms(np.array(values))) for name, values in single.items()}
    drifts = {n: float(rms(np.array([final_drift(r) for r in runs[n]]))) / MG for n in names}
    first = runs["varied"][0]
    gauge = first["supply"][first["time"] > given.fill] - AMBIENT_PRESSURE
    spread = 100 * float(np.ptp(gauge) / gauge.mean())
    change = 100 * (errors["varied"] / errors["constant"] - 1)
    scatter = 100 * max(float(np.ptp(values)) / errors[name] for name, values in single.items())
    findings = (
        number("variation of the supply, read by its sensor", spread, "%", "about 25"),
        number("RMS tracking error, constant supply", errors["constant"], "mg"),
        number("RMS tracking error, varied supply", errors["varied"], "mg"),
        number("change of the tracking error", change, "%", "no discernible effect"),
        number("between runs under the same supply, most", scatter, "%"),
        number("final drift, constant supply, RMS of channels", drifts["constant"], "mg"),
        number("final drift, varied supply, RMS of channels", drifts["varied"], "mg"),
    )
    conclusion = (
        f"A supply that varies by {spread:.0f} % changes the tracking error by {change:+.1f} %, "
        f"{errors['constant']:.2f} to {errors['varied']:.2f} mg in {given.runs} runs each; runs "
        f"under the same supply differ by up to {scatter:.0f} % (thesis: no discernible effect)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Supply, mass of the first channel and its tracking error over time, in the first runs."""
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=(1, 2, 1))
    runs = {name: of(f"{name}_0", results) for name in ("constant", "varied")}
    far = 5.0  # [mg]; beyond it lies the filling
    top.plot(runs["varied"]["time"], runs["varied"]["supply"] / 1e3, color=SUPPLY)
    top.set(ylabel="supply\n[kPa abs.]")
    middle.plot(runs["varied"]["time"], runs["varied"]["target"] / MG, color=TARGET, label="target")
    colours = {"constant": FULL, "varied": OTHER}
    for name, run in runs.items():
        style = {"color": colours[name], "ls": "--" if name == "constant" else "-", "lw": 1.0}
        middle.plot(run["time"], run["truth"][:, 0] / MG, label=f"{name} supply", **style)
        error = (run["truth"][:, 0] - run["target"]) / MG
        bottom.plot(run["time"], error, **style)
        far = max(far, 1.1 * float(np.abs(error[len(error) // 2 :]).max()))
    middle.set(ylabel="air mass [mg]")
    middle.legend(loc="lower right", ncols=3)
    bottom.axhline(0, color=TARGET, lw=0.6)
    bottom.set(xlabel="time [s]", ylabel="error [mg]", ylim=(-far, far))
