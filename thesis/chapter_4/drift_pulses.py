"""Drift of the estimated air mass against the number of pulses (section 4.4.4).

The thesis: best below 20 to 50 pulses.
"""

from dataclasses import dataclass

import numpy as np

from thesis.chapter_4 import FULL, MG, NOTE, OTHER, STEP, THESIS_LINE
from thesis.chapter_4.boxes import box_of, calibrated
from thesis.chapter_4.rig_run import SMALL_SINE, SineOnBottles, drift, on_bottles
from thesis.frame import Array, Figure, Job, Report, Results, number, option

REACH = (20, 50)  # pulses, of the thesis
FIRST_OF_FIT = 5  # pulses: below, a drift is the noise of the tare
SMALL = SMALL_SINE | {"duration": 6.0, "channels": 2, "boxes": 1, "pulses": 8}


@dataclass(frozen=True)
class Parameters(SineOnBottles):
    """Options of the experiment."""

    channels: int = option(8, "outlets of a box [-]")
    boxes: int = option(3, "boxes, each with a calibration of its own [-]")
    pulses: int = option(120, "pulses to follow [-]")


def run(given: Parameters, job: Job) -> Results:
    """Drift of every channel of every box over its pulses (pulses + 1, channels of all boxes)."""
    courses = []
    for k in range(given.boxes):
        which = given.seed + 1000 * k
        box = box_of(which)
        own = calibrated(box, given.channels, given.points, which, job.progress, given.supplies)
        courses.append(over_pulses(on_bottles(box, own, which).follow(given, job.progress), given))
    count = np.arange(given.pulses + 1.0)
    return {"pulses": count, "drift": np.concatenate(courses, axis=1)}


def over_pulses(run: Results, given: Parameters) -> Array:
    """Drift after each number of pulses (pulses + 1, channels) [kg]; NaN beyond a channel's own."""
    wanted = np.arange(given.pulses + 1.0)
    columns = []
    for values, pulses in zip(drift(run).T, run["pulses"].T, strict=True):
        still = np.isfinite(values)
        # the tare is where it begins, with no pulse and no drift
        made, found = np.append(0.0, pulses[still]), np.append(0.0, values[still])
        columns.append(np.interp(wanted, made, found, right=np.nan))
    return np.array(columns).T


def report(results: Results, given: Parameters) -> Report:
    """Drift after the thesis's numbers of pulses, and the exponent with which it grows."""
    known = np.isfinite(results["drift"]).any(axis=1)  # some channel has made so many pulses
    typical = rms_known(results["drift"][known]) / MG
    count = results["pulses"][known]
    last = int(count[-1])
    after = sorted({n for n in (*REACH, last) if n <= last})
    findings = [number(f"RMS drift after {n} pulses", float(typical[n]), "mg") for n in after]
    if last <= FIRST_OF_FIT:
        raise ValueError(f"duration must be longer: the sine took no more than {last} pulses")
    grown = (count >= FIRST_OF_FIT) & (typical > 0)
    growth = float(np.polyfit(np.log(count[grown]), np.log(typical[grown]), 1)[0])
    within = float(np.argmax(typical > STEP)) if (typical > STEP).any() else float(last)
    findings += [
        number("exponent of its growth with pulses", growth, ""),
        number("pulses before the RMS drift is 2.5 mg", within, "", "use for 20 to 50"),
    ]
    shown = ", ".join(f"{typical[n]:.2f} mg after {n}" for n in after)
    limit = "and more " if within == last else ""
    conclusion = (
        f"RMS drift {shown} pulses; it stays below the smallest step of 2.5 mg for {within:.0f} "
        f"{limit}pulses (thesis: for less than 20 to 50)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Drift of all channels and its RMS over the number of pulses."""
    panel = figure.subplots()
    known = np.isfinite(results["drift"]).any(axis=1)
    count, size = results["pulses"][known], np.abs(results["drift"][known]) / MG
    panel.plot(count, size, color=FULL, lw=0.5, alpha=0.4)
    panel.plot(count, rms_known(size), color=OTHER, lw=2, label="RMS of all channels")
    panel.plot([], [], color=FULL, lw=0.5, label="one channel")
    panel.axhline(STEP, color=THESIS_LINE, ls="--", lw=1.0)
    panel.annotate("thesis: smallest step 2.5 mg", (0, STEP), (4, 3), **NOTE)
    panel.axvspan(*REACH, color=THESIS_LINE, alpha=0.2, lw=0)
    top = max(1.5 * STEP, float(np.nanmax(size)))
    panel.annotate("thesis: use for 20 to 50 pulses", (REACH[0], top), (2, -9), **NOTE)
    panel.set(xlabel="pulses since the tare", ylabel="|drift| [mg]", ylim=(0, top), xlim=(0, None))
    panel.legend(loc="upper right")


def rms_known(values: Array) -> Array:
    """RMS over the channels that are known (pulses,)."""
    return np.asarray(np.sqrt(np.nanmean(values**2, axis=1)))
