"""One channel, calibrated with 1,600 points, tracks a sine for a minute (Fig. 4.9).

The thesis: 122 pulses in 60 s without excessive drift.
"""

from dataclasses import dataclass

import numpy as np

from thesis.chapter_4 import FULL, MG, NOTE, OTHER, SEED, TARGET, THESIS_LINE, rms
from thesis.chapter_4.boxes import box_of, calibrated
from thesis.chapter_4.rig_run import (
    SMALL_SINE,
    Sine,
    drift,
    final_drift,
    on_bottles,
    pulses_in_sine,
    tracking_error,
)
from thesis.frame import Figure, Job, Report, Results, number, option

SIZE = (8.0, 4.8)
SMALL = SMALL_SINE | {"supplies": (260e3, 320e3)}


@dataclass(frozen=True)
class Parameters(Sine):
    """Options of the experiment."""

    seed: int = option(0, SEED)
    points: int = option(1600, "calibration pulses, both directions together [-]")
    supplies: tuple[float, ...] = option(
        (260e3, 280e3, 300e3, 320e3), "supplies of the calibration [Pa gauge]"
    )


def run(given: Parameters, job: Job) -> Results:
    """Calibrate one channel and let it track the sine."""
    box = box_of(given.seed)
    own = calibrated(box, 1, given.points, given.seed, job.progress, given.supplies)
    return on_bottles(box, own, given.seed).follow(given, job.progress)


def report(results: Results, given: Parameters) -> Report:
    """Pulses, final drift and tracking error."""
    pulses = float(pulses_in_sine(results, given)[0])
    measured, true = (
        abs(float(final_drift(results, truth)[0])) / MG for truth in ("measured", "truth")
    )
    error = float(rms(tracking_error(results, given))) / MG
    findings = (
        number("pulses in the sine", pulses, "", "122"),
        number("final drift, by the sensors", measured, "mg", "not excessive; steps of 2.5"),
        number("final drift, true", true, "mg"),
        number("RMS tracking error", error, "mg"),
    )
    conclusion = (
        f"{pulses:.0f} pulses in {given.duration:g} s (thesis: 122) leave a drift of "
        f"{measured:.2f} mg (thesis: no excessive drift; smallest step 2.5 mg)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Target, estimate and ground truth over time, and the drift below them."""
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    time, still = results["time"], np.isfinite(results["measured"][:, 0])
    top.plot(time, results["target"] / MG, color=TARGET, lw=0.9, label="target")
    top.plot(time, results["estimate"][:, 0] / MG, color=FULL, label="estimate")
    measured = results["measured"][still, 0] / MG
    top.plot(time[still], measured, ".", ms=1.5, color=OTHER, label="ground truth between pulses")
    span = np.ptp(results["target"]) / MG
    low, high = results["target"].min() / MG, results["target"].max() / MG
    start = time[still][0]
    top.set(ylabel="air mass [mg]", ylim=(low - 0.3 * span, high + 0.1 * span))
    top.set_xlim(start - 1.0, None)
    top.legend(loc="lower center", ncols=3)
    course = drift(results, "measured")[still, 0] / MG
    bottom.plot(time[still], course, ".", ms=2.5, color=OTHER)
    for sign in (-1, 1):
        bottom.axhline(sign * 2.5, color=THESIS_LINE, lw=1.0, ls="--")
    bottom.annotate("thesis: smallest step 2.5 mg", (start, 2.5), (2, -9), **NOTE)
    bottom.set(xlabel="time [s]", ylabel="drift [mg]")
