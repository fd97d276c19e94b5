"""Section 4.4.4: faster valves allow a smaller step at the same speed, or more speed."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pneumaticbox_driver.calibration.recording import PulseRanges
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4.bench_run import (
    Sine,
    control_error,
    final_drift,
    of,
    on_bottles,
    pulses_in_sine,
    under,
)
from thesis.chapter_4.boxes import SUPPLIES, box_of, calibrated, inlet_flows, smallest_steps
from thesis.chapter_4.dead_volume import draw_steps
from thesis.chapter_4.report import FULL, MG, OTHER, Metric, Progress, Report, Series, option, rms

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SENTENCE = "fast valves of 1-4 ms against pilot valves of 20-40 ms, behind the same chokes"
THESIS = "section 4.4.4, an order of magnitude is to be gained"
NAMES = ("slow", "fast", "foilless")
TITLES = {
    "slow": "20-40 ms",
    "fast": "1-4 ms",
    "foilless": "1-4 ms, no\ndead volume",
}
COLOURS = (OTHER, FULL)
DELAYS = {"slow": (0.020, 0.040), "fast": (0.001, 0.004), "foilless": (0.001, 0.004)}  # [s]
SHORTEST = {"slow": (0.045, 0.06), "fast": (0.006, 0.008), "foilless": (0.006, 0.008)}
LEAST_DEAD_VOLUME = 1e-10  # as if there were none [m3]


@dataclass(frozen=True)
class Settings(Sine):
    """Options of the experiment."""

    points: int = option(100, "calibration pulses per channel, both directions together [-]")
    channels: int = option(4, "outlets of the box [-]")


def simulate(settings: Settings, seed: int, progress: Progress) -> Series:
    """Smallest steps of all; how slow and fast valves track the sine by their own calibrations."""
    series: Series = {}
    for name in NAMES:
        box = with_valves(box_of(seed), name)
        series[f"{name}_steps"] = smallest_steps(box, settings.channels, SHORTEST[name][0], seed)
        series[f"{name}_flow"] = inlet_flows(box, settings.channels, seed)
    for name in NAMES[:2]:
        box, plan = with_valves(box_of(seed), name), PulseRanges(shortest=SHORTEST[name][0])
        own = calibrated(box, settings.channels, settings.points, seed, progress, SUPPLIES, plan)
        run = on_bottles(box, own, seed, SHORTEST[name]).follow(settings, progress)
        series |= under(name, run)
    return series


def with_valves(box: Pneumatics, name: str) -> Pneumatics:
    """The box with slow or fast valves, or with fast ones and hardly any dead volume."""
    valve = replace(box.valve, opening_delay=DELAYS[name], closing_delay=DELAYS[name])
    choke = box.choke
    if name == "foilless":
        choke = replace(choke, dead_volume=LEAST_DEAD_VOLUME)
    return replace(box, valve=valve, choke=choke)


def report(series: Series, settings: Settings) -> Report:
    """Smallest steps, step over flow, errors of control."""
    step = {name: float(series[f"{name}_steps"].mean()) / MG for name in NAMES}
    inflation = {name: float(series[f"{name}_steps"][0].mean()) for name in NAMES}
    product = {k: 1e3 * inflation[k] / float(series[f"{k}_flow"].mean()) for k in NAMES}
    metrics = []
    for name in NAMES:
        title = TITLES[name].replace("\n", " ")
        metrics += [
            Metric(f"{title}: smallest pulse, mean of both directions", step[name], "mg"),
            Metric(f"{title}: smallest inflation over flow", product[name], "ms"),
        ]
    runs = {name: of(name, series) for name in NAMES[:2]}
    errors = {k: float(rms(control_error(run, settings))) / MG for k, run in runs.items()}
    for name, run in runs.items():
        count = float(np.median(pulses_in_sine(run, settings)))
        drift = float(rms(final_drift(run))) / MG
        metrics += [
            Metric(f"{TITLES[name]}: RMS error of control, drift apart", errors[name], "mg"),
            Metric(f"{TITLES[name]}: pulses in the sine", count, ""),
            Metric(f"{TITLES[name]}: final drift, RMS of channels", drift, "mg"),
        ]
    gains = [step["slow"] / step["fast"], step["slow"] / step["foilless"]]
    metrics += [
        Metric("smallest pulse, slow / fast", gains[0], "", "about 10"),
        Metric("smallest pulse, slow / fast without dead volume", gains[1], "", "about 10"),
        Metric("error of control, slow / fast", errors["slow"] / errors["fast"], ""),
    ]
    verdict = (
        f"valves of 1-4 ms move {gains[0]:.1f} times smaller steps behind the same chokes, and "
        f"{gains[1]:.1f} times without the dead volume (thesis: an order of magnitude); the "
        f"error of control goes from {errors['slow']:.2f} to {errors['fast']:.2f} mg"
    )
    return Report(tuple(metrics), verdict)


def draw(figure: "Figure", series: Series, result: Report) -> None:
    """Smallest steps, and the error of control of the first channel over time."""
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.4))
    draw_steps(left, series, NAMES, TITLES)
    left.legend(loc="upper right")
    for name, colour in zip(NAMES[:2], COLOURS, strict=True):
        run = of(name, series)
        error = (run["estimate"][:, 0] - run["target"]) / MG
        right.plot(run["time"], error, color=colour, lw=0.8, label=TITLES[name])
    right.set(
        xlabel="time [s]",
        ylabel="estimate less target, channel 1 [mg]",
        ylim=(-2, 2),
        xlim=(5, None),
    )
    right.legend(loc="lower left", ncols=2)
