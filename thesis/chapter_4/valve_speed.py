"""Fast valves of 1-4 ms against pilot valves of 20-40 ms, same chokes (section 4.4.4).

The thesis: fast valves would gain an order of magnitude.
"""

from dataclasses import dataclass, replace

import numpy as np

from pneumaticbox_driver.calibration.recording import PulseRanges
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import FULL, MG, OTHER, rms
from thesis.chapter_4.boxes import box_of, calibrated, inlet_flows, smallest_steps
from thesis.chapter_4.dead_volume import draw_steps
from thesis.chapter_4.rig_run import (
    SMALL_SINE,
    SineOnBottles,
    final_drift,
    of,
    on_bottles,
    pulses_in_sine,
    tracking_error,
    under,
)
from thesis.frame import Figure, Job, Report, Results, number

NAMES = ("slow", "fast", "foilless")
TITLES = {"slow": "20-40 ms", "fast": "1-4 ms", "foilless": "1-4 ms, no\ndead volume"}
COLOURS = (OTHER, FULL)
DELAYS = {"slow": (0.020, 0.040), "fast": (0.001, 0.004), "foilless": (0.001, 0.004)}  # [s]
SHORTEST = {"slow": (0.045, 0.06), "fast": (0.006, 0.008), "foilless": (0.006, 0.008)}
LEAST_DEAD_VOLUME = 1e-10  # as if there were none [m3]
SMALL = SMALL_SINE | {"channels": 1}


@dataclass(frozen=True)
class Parameters(SineOnBottles):
    """Options of the experiment."""


def run(given: Parameters, job: Job) -> Results:
    """Smallest steps of all; how slow and fast valves track the sine by their own calibrations."""
    results: Results = {}
    for name in NAMES:
        box = with_valves(box_of(given.seed), name)
        results[f"{name}_steps"] = smallest_steps(
            box, given.channels, SHORTEST[name][0], given.seed
        )
        results[f"{name}_flow"] = inlet_flows(box, given.channels, given.seed)
    for name in NAMES[:2]:
        box, plan = with_valves(box_of(given.seed), name), PulseRanges(shortest=SHORTEST[name][0])
        own = calibrated(
            box, given.channels, given.points, given.seed, job.progress, given.supplies, plan
        )
        run = on_bottles(box, own, given.seed, SHORTEST[name]).follow(given, job.progress)
        results |= under(name, run)
    return results


def with_valves(box: Pneumatics, name: str) -> Pneumatics:
    """The box with slow or fast valves, or with fast ones and hardly any dead volume."""
    valve = replace(box.valve, opening_delay=DELAYS[name], closing_delay=DELAYS[name])
    choke = box.choke
    if name == "foilless":
        choke = replace(choke, dead_volume=LEAST_DEAD_VOLUME)
    return replace(box, valve=valve, choke=choke)


def report(results: Results, given: Parameters) -> Report:
    """Smallest steps, step over flow, errors of control."""
    step = {name: float(results[f"{name}_steps"].mean()) / MG for name in NAMES}
    inflation = {name: float(results[f"{name}_steps"][0].mean()) for name in NAMES}
    product = {k: 1e3 * inflation[k] / float(results[f"{k}_flow"].mean()) for k in NAMES}
    findings = []
    for name in NAMES:
        title = TITLES[name].replace("\n", " ")
        findings += [
            number(f"{title}: smallest pulse, mean of both directions", step[name], "mg"),
            number(f"{title}: smallest inflation over flow", product[name], "ms"),
        ]
    runs = {name: of(name, results) for name in NAMES[:2]}
    errors = {k: float(rms(tracking_error(run, given, "estimate"))) / MG for k, run in runs.items()}
    for name, run in runs.items():
        count = float(np.median(pulses_in_sine(run, given)))
        drift = float(rms(final_drift(run))) / MG
        findings += [
            number(f"{TITLES[name]}: RMS error of control, drift apart", errors[name], "mg"),
            number(f"{TITLES[name]}: pulses in the sine", count, ""),
            number(f"{TITLES[name]}: final drift, RMS of channels", drift, "mg"),
        ]
    gains = [step["slow"] / step["fast"], step["slow"] / step["foilless"]]
    findings += [
        number("smallest pulse, slow / fast", gains[0], "", "about 10"),
        number("smallest pulse, slow / fast without dead volume", gains[1], "", "about 10"),
        number("error of control, slow / fast", errors["slow"] / errors["fast"], ""),
    ]
    conclusion = (
        f"Valves of 1-4 ms move {gains[0]:.1f} times smaller steps behind the same chokes, and "
        f"{gains[1]:.1f} times without the dead volume (thesis: an order of magnitude); the "
        f"error of control goes from {errors['slow']:.2f} to {errors['fast']:.2f} mg."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Smallest steps, and the error of control of the first channel over time."""
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.4))
    draw_steps(left, results, NAMES, TITLES)
    left.legend(loc="upper right")
    for name, colour in zip(NAMES[:2], COLOURS, strict=True):
        run = of(name, results)
        error = (run["estimate"][:, 0] - run["target"]) / MG
        right.plot(run["time"], error, color=colour, lw=0.8, label=TITLES[name])
    right.set(
        xlabel="time [s]",
        ylabel="estimate less target, channel 1 [mg]",
        ylim=(-2, 2),
        xlim=(5, None),
    )
    right.legend(loc="lower left", ncols=2)
