"""Fig. 4.9: one well calibrated channel over a minute and many pulses."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from thesis.chapter_4.bench_run import (
    Sine,
    drift,
    final_drift,
    on_bottles,
    pulses_in_sine,
    tracking_error,
)
from thesis.chapter_4.boxes import box_of, calibrated
from thesis.chapter_4.report import (
    FULL,
    MG,
    OTHER,
    TARGET,
    THESIS_LINE,
    Metric,
    Progress,
    Report,
    Series,
    option,
    rms,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCE = "one channel, calibrated with 1,600 points, tracks a sine for a minute"
THESIS = "Fig. 4.9, 122 pulses in 60 s without excessive drift"
SIZE = (8.0, 4.8)


@dataclass(frozen=True)
class Settings(Sine):
    """Options of the experiment."""

    points: int = option(1600, "calibration pulses, both directions together [-]")
    supplies: tuple[float, ...] = option(
        (260e3, 280e3, 300e3, 320e3), "supplies of the calibration [Pa gauge]"
    )


def simulate(settings: Settings, seed: int, progress: Progress) -> Series:
    """Calibrate one channel and let it track the sine."""
    box = box_of(seed)
    own = calibrated(box, 1, settings.points, seed, progress, settings.supplies)
    return on_bottles(box, own, seed).follow(settings, progress)


def report(series: Series, settings: Settings) -> Report:
    """Pulses, final drift and tracking error."""
    pulses = float(pulses_in_sine(series, settings)[0])
    measured, true = (
        abs(float(final_drift(series, truth)[0])) / MG for truth in ("measured", "truth")
    )
    error = float(rms(tracking_error(series, settings))) / MG
    metrics = (
        Metric("pulses in the sine", pulses, "", "122"),
        Metric("final drift, by the sensors", measured, "mg", "not excessive; steps of 2.5"),
        Metric("final drift, true", true, "mg"),
        Metric("RMS tracking error", error, "mg"),
    )
    verdict = (
        f"{pulses:.0f} pulses in {settings.duration:g} s (thesis: 122) leave a drift of "
        f"{measured:.2f} mg (thesis: no excessive drift; smallest step 2.5 mg)"
    )
    return Report(metrics, verdict)


def draw(figure: "Figure", series: Series, result: Report) -> None:
    """Target, estimate and ground truth over time, and the drift below them."""
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    time, still = series["time"], np.isfinite(series["measured"][:, 0])
    top.plot(time, series["target"] / MG, color=TARGET, lw=0.9, label="target")
    top.plot(time, series["estimate"][:, 0] / MG, color=FULL, label="estimate")
    measured = series["measured"][still, 0] / MG
    top.plot(time[still], measured, ".", ms=1.5, color=OTHER, label="ground truth between pulses")
    span = np.ptp(series["target"]) / MG
    low, high = series["target"].min() / MG, series["target"].max() / MG
    start = time[still][0]
    top.set(ylabel="air mass [mg]", ylim=(low - 0.3 * span, high + 0.1 * span))
    top.set_xlim(start - 1.0, None)
    top.legend(loc="lower center", ncols=3)
    course = drift(series, "measured")[still, 0] / MG
    bottom.plot(time[still], course, ".", ms=2.5, color=OTHER)
    for sign in (-1, 1):
        bottom.axhline(sign * 2.5, color=THESIS_LINE, lw=1.0, ls="--")
    bottom.annotate(
        "thesis: smallest step 2.5 mg",
        (start, 2.5),
        (2, -9),
        textcoords="offset points",
        color="#555555",
    )
    bottom.set(xlabel="time [s]", ylabel="drift [mg]")
