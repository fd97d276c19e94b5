"""Fig. 4.8: six channels that track a sine, each by its own calibration and all by one."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pneumaticbox_driver.calibration.file import check_calibration
from thesis.chapter_4.bench_run import (
    Sine,
    drift,
    final_drift,
    of,
    on_bottles,
    pulses_in_sine,
    tracking_error,
    under,
)
from thesis.chapter_4.boxes import OUTLETS, SUPPLIES, box_of, calibrated
from thesis.chapter_4.report import (
    CHANNELS,
    MG,
    THESIS_LINE,
    Metric,
    Progress,
    Report,
    Series,
    option,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCE = "six channels track a sine, with own calibrations and with one shared by all"
THESIS = "Fig. 4.8, final error below 2.5 mg on all but one; shared about 4 times worse"
SIZE = (8.5, 4.0)
BOUND = 2.5  # [mg]


@dataclass(frozen=True)
class Settings(Sine):
    """Options of the experiment."""

    points: int = option(100, "calibration pulses per channel, both directions together [-]")
    channels: int = option(6, "outlets of the box [-]")
    supplies: tuple[float, ...] = option(SUPPLIES, "supplies of the calibration [Pa gauge]")


def simulate(settings: Settings, seed: int, progress: Progress) -> Series:
    """Calibrate a box, then let it track the sine twice: own calibrations, the first for all."""
    box = box_of(seed)
    own = calibrated(box, settings.channels, settings.points, seed, progress, settings.supplies)
    shared = [own[0]] * settings.channels
    runs = [on_bottles(box, using, seed).follow(settings, progress) for using in (own, shared)]
    names = OUTLETS[: settings.channels]
    warned = [len(check_calibration(names, using)) for using in (own, shared)]
    counts = {"warnings": np.array(warned, dtype=float)}
    return {**under("own", runs[0]), **under("shared", runs[1]), **counts}


def report(series: Series, settings: Settings) -> Report:
    """Final drift with both, and how much worse the shared calibration tracks."""
    own, shared = of("own", series), of("shared", series)
    finals = {truth: np.abs(final_drift(own, truth)) / MG for truth in ("measured", "truth")}
    means = [float(np.abs(tracking_error(run, settings)).mean()) / MG for run in (own, shared)]
    within = int((finals["measured"] < BOUND).sum())
    worst = float(finals["measured"].max())
    warns = series["warnings"][1] > series["warnings"][0]
    metrics = (
        Metric("final drift, worst channel, by the sensors", worst, "mg", "< 2.5, but one"),
        Metric("final drift, worst channel, true", float(finals["truth"].max()), "mg"),
        Metric("channels within 2.5 mg", within, "", "all but one"),
        Metric(
            "final drift, shared calibration, worst channel",
            float(np.abs(final_drift(shared, "measured")).max()) / MG,
            "mg",
        ),
        Metric("mean tracking error, own calibrations", means[0], "mg"),
        Metric("mean tracking error, shared calibration", means[1], "mg"),
        Metric("mean tracking error, shared / own", means[1] / means[0], "", "about 4"),
        Metric("the driver warns of a shared calibration", float(warns), "", "calibrate each"),
        Metric("pulses per channel, median", float(np.median(pulses_in_sine(own, settings))), ""),
    )
    verdict = (
        f"after {settings.duration:g} s {within} of {settings.channels} channels are within 2.5 mg "
        f"(thesis: all but one), the worst at {worst:.2f} mg; one calibration for all tracks "
        f"{means[1] / means[0]:.1f} times worse (thesis: about 4)"
    )
    return Report(metrics, verdict)


def draw(figure: "Figure", series: Series, result: Report) -> None:
    """Drift of every channel over time, with own and with shared calibrations."""
    axes = figure.subplots(1, 2, sharex=True)
    titles = {"own": "own calibrations", "shared": "one calibration for all channels"}
    for panel, (name, title) in zip(axes, titles.items(), strict=True):
        run = of(name, series)
        course = drift(run, "measured") / MG
        for channel, column in enumerate(course.T):
            known = np.isfinite(column)
            colour = CHANNELS[channel % len(CHANNELS)]
            panel.plot(
                run["time"][known], column[known], color=colour, label=f"channel {channel + 1}"
            )
        for sign in (-1, 1):
            panel.axhline(sign * BOUND, color=THESIS_LINE, lw=1.0, ls="--")
        spot = {"xy": (0.02, BOUND), "xycoords": ("axes fraction", "data")}
        panel.annotate(
            "thesis: 2.5 mg", xytext=(0, 3), textcoords="offset points", color="#555555", **spot
        )
        panel.set(title=title, xlabel="time [s]", ylabel="measured less estimated mass [mg]")
    low, high = axes[0].get_ylim()
    axes[0].set_ylim(min(low, -1.8 * BOUND), max(high, 1.2 * BOUND))
    axes[0].legend(ncols=3, loc="lower left")
