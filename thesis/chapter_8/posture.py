"""Posture against actuation of grasps, the empty hand as control (8.2.3, 8.2.4, Figs 8.14, 8.15).

Takes the stored grasps of the Feix experiment that were held in all of their trials. Each is made
again in two jittered trials, with its object and with the same air in an empty hand; the places of
markers on the tips are averaged over the two (8.2.3). What is said of them is `posture_variance`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.dexterity.feix import FINGERS, THUMB, grasp_types
from grasp_strategies.dexterity.feix_search import starts
from grasp_strategies.dexterity.grasping import Draw, drawn, grasping
from grasp_strategies.dexterity.patterns import FILE, Pattern, Patterns, Times
from grasp_strategies.dexterity.posture import FOUR
from grasp_strategies.dexterity.replay import stored_grasps
from grasp_strategies.sweep.line import DIGITS, Record
from grasp_strategies.sweep.run import run_lines
from pneuflex_sim.world import Diverged
from thesis.chapter_8.human_postures import human_postures
from thesis.chapter_8.posture_variance import (
    INTERACTION,
    LINEAR,
    Estimate,
    GraspPostures,
    components_to,
    correlations,
    participation_ratio,
    residual_variance,
)
from thesis.frame import Array, Figure, Finding, Job, Report, Results, number, option

SIZE = (12.0, 5.6)
MARKERS = (THUMB, *FINGERS)
TRIALS = 2  # of each grasp, averaged (8.2.3)
HELD, EMPTY = "held", "empty"
SMALL = {
    "patterns": str(Path(__file__).with_name("posture_small.yaml")),
    "fewest": 2,
    "resamples": 200,
    "jobs": 0,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    patterns: str = option("", "file of stored grasps; empty: the shipped one [-]")
    human: str = option("", "folder of people's postures, a CSV file each; empty: none [-]")
    most: int = option(33, "grasps that are taken, the first of those that were held [-]")
    fewest: int = option(20, "grasps that are needed [-]")
    resamples: int = option(2000, "of the bootstrap over grasps [-]")
    seed: int = option(4000, "of trials and bootstrap; the search and its trials have others [-]")
    jobs: int = option(2, "processes [-]")


@dataclass(frozen=True)
class PosedTrial:
    """A stored grasp made once, with its object or without: a pure function of this.

    Args:
        number: of the type.
        trial: from 0 on.
        object_there: whether the hand gets the object.
        pattern: what is done, in these times.
        draw: how the trial differs from it.
        step, segments: of the simulation [s], an actuator.
    """

    number: int
    trial: int
    object_there: bool
    pattern: Pattern
    times: Times
    draw: Draw
    step: float
    segments: int

    @property
    def key(self) -> str:
        """Such as `3/held/1`."""
        return f"{self.number}/{HELD if self.object_there else EMPTY}/{self.trial + 1}"

    @property
    def settings(self) -> tuple[Any, ...]:
        """With what the simulation is built."""
        modulus = self.draw.modulus_scale
        return (self.pattern.object, FOUR, self.step, self.segments, modulus)

    @property
    def digest(self) -> str:
        """Hash of all that is given."""
        text = json.dumps(asdict(self), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]

    def describe(self) -> Record:
        """Key, digest and draw."""
        return {"key": self.key, "digest": self.digest, "draw": asdict(self.draw)}

    def result(self) -> Record:
        """Places of the `markers` [m] by finger in the wrist frame, and why it does not count in
        `lost`, empty when it does.
        """
        try:
            hand = grasping(*self.settings)
            lost = ""
            if not self.object_there:
                hand.pose_only(self.pattern, self.times)
            elif hand.grasp(self.pattern, self.times, self.draw).dropped:
                lost = "the hand lost the object"
            return {"markers": hand.markers(), "lost": lost}
        except Diverged as reason:
            grasping.cache_clear()
            return {"markers": {}, "lost": str(reason)}


def trials(given: Parameters, patterns: Patterns, numbers: Sequence[int]) -> list[PosedTrial]:
    """All that is run; with and without object a trial has the same draw."""
    return [
        PosedTrial(
            number,
            trial,
            there,
            patterns.grasps[number].pattern,
            patterns.times,
            drawn((given.seed, number, trial)),
            patterns.step,
            patterns.segments,
        )
        for number in numbers
        for trial in range(TRIALS)
        for there in (True, False)
    ]


def held_types(patterns: Patterns) -> tuple[int, ...]:
    """Types whose object was held in every trial of the Feix experiment."""
    return tuple(
        number
        for number, stored in sorted(patterns.grasps.items())
        if stored.trials and stored.held == len(stored.trials)
    )


# ---------------------------------------------------------------- run
def run(given: Parameters, job: Job) -> Results:
    """Actuation (n, 4) of the grasps as shares of what the channels hold at their limits, places of
    the markers (2, n, 15) [m] with object and without, in two trials; their types, what was left
    out and why, and people's residual variances.

    Raises ValueError when fewer grasps were held than are needed.
    """
    patterns = stored_grasps(Path(given.patterns) if given.patterns else FILE)
    numbers = held_types(patterns)[: given.most]
    _refuse_few(len(numbers), given, f"of {len(patterns.grasps)} stored ones were held")
    people = human_postures(Path(given.human)) if given.human else {}
    job.progress(f"{len(numbers)} grasps, with and without object", 0.0)
    lines = trials(given, patterns, numbers)
    records = {
        record["key"]: record for record in run_lines(lines, job.folder / "trials", given.jobs)
    }
    left_out = _left_out(patterns, numbers, lines, records)
    kept = [number for number in numbers if str(number) not in left_out]
    _refuse_few(len(kept), given, "were held again in both trials")
    return {
        "types": kept,
        "left_out": left_out,
        "actuation": np.array([_inflation(number, patterns) for number in kept]),
        **{name: _places(records, kept, name) for name in (HELD, EMPTY)},
        "human": {name: residual_variance(own).tolist() for name, own in people.items()},
        "resamples": given.resamples,
        "seed": given.seed,
    }


def _refuse_few(count: int, given: Parameters, what: str) -> None:
    if count < given.fewest:
        raise ValueError(
            f"posture: expected {given.fewest} grasps or more that were held, got {count}: "
            f"so many {what}"
        )


def _left_out(
    patterns: Patterns,
    numbers: Sequence[int],
    lines: Sequence[PosedTrial],
    records: Mapping[str, Record],
) -> dict[str, str]:
    """Why types do not count."""
    found = {str(n): "not held" for n in patterns.grasps if n not in held_types(patterns)}
    found |= {str(n): "not taken" for n in held_types(patterns) if n not in numbers}
    for line in lines:
        record = records[line.key]
        if reason := record.get("error") or record["lost"]:
            found[str(line.number)] = reason
    return found


def _inflation(number: int, patterns: Patterns) -> list[float]:
    """Final air mass of each channel as a share of what it holds at its limit."""
    most, final = starts()[number].most, patterns.grasps[number].pattern.final
    return [final[channel] / most[channel] for channel in most]


def _places(records: Mapping[str, Record], numbers: Sequence[int], name: str) -> Array:
    return np.array(
        [
            [
                np.ravel([records[f"{n}/{name}/{trial + 1}"]["markers"][m] for m in MARKERS])
                for n in numbers
            ]
            for trial in range(TRIALS)
        ]
    )


# ---------------------------------------------------------------- report
def postures(results: Results) -> GraspPostures:
    """The analysis of what was run."""
    return GraspPostures(
        results["actuation"],
        results[HELD],
        results[EMPTY],
        int(results["resamples"]),
        int(results["seed"]),
    )


def report(results: Results, given: Parameters) -> Report:
    """Dimensions of postures and actuation, and what of the difference is interaction."""
    found = postures(results)
    mean = {name: getattr(found, name).mean(axis=0) for name in (HELD, EMPTY)}
    counted = {name: components_to(points) for name, points in mean.items()}
    ratios = {name: participation_ratio(points) for name, points in mean.items()}
    findings = [
        _grasps(results),
        Finding(
            "principal components to 95 % of the variance",
            "a picture",
            f"{counted[HELD]} of postures, {counted[EMPTY]} in the empty hand, "
            f"{components_to(found.actuation)} of actuation",
        ),
        Finding(
            "participation ratio",
            "-",
            f"{ratios[HELD]:.2f} of postures, {ratios[EMPTY]:.2f} in the empty hand, "
            f"{participation_ratio(found.actuation):.2f} of actuation",
        ),
        _beyond(found),
        _empty(found),
        _excess(found),
        _unpredicted(found),
        _noise(found),
        _correlated(found),
        *(_human(name, curve) for name, curve in results["human"].items()),
    ]
    return Report(findings, _conclusion(found))


def _conclusion(found: GraspPostures) -> str:
    if found.kind == LINEAR:
        return "Postures span no more dimensions than their actuation, but for noise."
    if found.kind == INTERACTION:
        return (
            "Postures span more dimensions than their actuation, and more than those of the empty "
            "hand: the object adds to them."
        )
    return (
        "Postures span more dimensions than their actuation, but so do those of the empty hand: "
        "that the object adds to them is not shown."
    )


def _grasps(results: Results) -> Finding:
    left_out = "; ".join(
        f"{number} ({grasp_types()[int(number)].name}): {reason}"
        for number, reason in sorted(results["left_out"].items(), key=lambda item: int(item[0]))
    )
    types = ", ".join(map(str, results["types"]))
    ours = f"{len(results['types'])}: types {types}; left out: {left_out or 'none'}"
    return Finding("grasps", "31, without 5 and 19", ours, None, len(results["types"]))


def _interval(found: Estimate) -> str:
    return (
        f"{100 * found.value:.2g} % of the variance "
        f"(95 %: {100 * found.low:.2g} to {100 * found.high:.2g})"
    )


def _beyond(found: GraspPostures) -> Finding:
    share = found.beyond[HELD]
    ours = (
        f"{_interval(share)}, {1e3 * found.beyond_length(HELD):.1f} mm; without the noise floor, "
        f"{100 * found.floor(HELD)[found.channels]:.2g} %; above it: p = {share.p:.2g} (< 0.05)"
    )
    what = f"postures beyond {found.channels} components"
    return Finding(what, "more than actuation", ours, share.shown, 100 * share.value, "%")


def _empty(found: GraspPostures) -> Finding:
    share = found.beyond[EMPTY]
    ours = f"{_interval(share)}, {1e3 * found.beyond_length(EMPTY):.1f} mm"
    return Finding("the same in the empty hand", "-", ours, None, 100 * share.value, "%")


def _excess(found: GraspPostures) -> Finding:
    excess = found.excess
    told = f"{_interval(excess)}, paired bootstrap p = {excess.p:.2g} (< 0.05)"
    ours = told if excess.shown else f"not shown: {told}"
    what = "with object more than in the empty hand"
    return Finding(what, "said, no control", ours, excess.shown, 100 * excess.value, "%")


def _unpredicted(found: GraspPostures) -> Finding:
    shares, excess = found.unpredicted, found.unpredicted_excess
    ours = (
        f"{100 * shares[HELD]:.0f} % of the variance, {100 * shares[EMPTY]:.0f} % in the empty "
        f"hand; more with object: p = {excess.p:.2g}"
    )
    what = "not predicted from the four channels (cross-validated Gaussian process)"
    return Finding(what, "-", ours, None, 100 * shares[HELD], "%")


def _noise(found: GraspPostures) -> Finding:
    rms = {
        name: 1e3 * float(np.sqrt(np.mean((trials[0] - trials[1]) ** 2) / 2.0))
        for name, trials in ((HELD, found.held), (EMPTY, found.empty))
    }
    ours = f"{rms[HELD]:.2f} mm with object, {rms[EMPTY]:.2f} mm without"
    what = "noise of a trial, rms of a coordinate"
    return Finding(what, "0.05 mm of the cameras", ours, None, rms[HELD], "mm")


def _correlated(found: GraspPostures) -> Finding:
    r = correlations(found.actuation)
    first, second = max(
        zip(*np.triu_indices(found.channels, 1), strict=True), key=lambda pair: abs(r[pair])
    )
    what = f"largest correlation of two channels, {'abcd'[first]} and {'abcd'[second]}"
    return number(what, float(r[first, second]), "", "no obvious ones")


def _human(name: str, curve: Sequence[float]) -> Finding:
    beyond = 100 * curve[min(4, len(curve) - 1)]
    to = int(np.argmax(np.array(curve) <= 0.05))
    ours = f"{to} components to 95 %, {beyond:.2g} % beyond four"
    return Finding(f"people: {name}", "like the hand", ours, None, beyond, "%")


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """Residual variances over components; the channels against each other."""
    found = postures(results)
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1.0))
    _draw_residuals(left.subplots(), found, results["human"])
    _draw_channels(right, found.actuation, results["types"])


def _draw_residuals(panel: Any, found: GraspPostures, human: Mapping[str, Sequence[float]]) -> None:
    looks = {HELD: ("tab:blue", "o", "with object"), EMPTY: ("tab:orange", "s", "empty hand")}
    for name, curve in human.items():
        panel.plot(100 * np.array(curve), "-", color="0.7", linewidth=0.8, label=f"people: {name}")
    for name, (color, marker, label) in looks.items():
        curve, low, high = (100 * part for part in found.curve(name))
        panel.plot(curve, marker=marker, color=color, label=f"posture, {label}")
        panel.fill_between(
            range(len(curve)), np.maximum(low, 1e-9), high, color=color, alpha=0.2, linewidth=0
        )
        panel.plot(100 * found.floor(name), ":", color=color, label=f"noise, {label}")
    panel.plot(100 * found.actuation_curve(), "k--", marker="^", label="actuation")
    panel.axvline(found.channels, color="0.8", linewidth=0.8, zorder=0)
    panel.set(yscale="log", xlim=(0, found.held.shape[-1] - 1), ylim=(1e-3, 130))
    panel.set(xlabel="principal components", ylabel="variance that is left [%]")
    panel.set_title(f"{len(found.actuation)} grasps (Fig. 8.14)", fontsize=10)
    panel.legend(fontsize=8)


def _draw_channels(figure: Any, actuation: Array, types: Sequence[int]) -> None:
    count = actuation.shape[1]
    panels, r = figure.subplots(count, count, sharex=True), correlations(actuation)
    figure.suptitle("inflation of the channels, shares of their limits (Fig. 8.15)", fontsize=10)
    for row in range(count):
        for column in range(count):
            panel = panels[row, column]
            panel.set(xticks=(0, 0.5, 1), xlim=(-0.05, 1.05))
            if row == column:
                panel.hist(actuation[:, row], bins=np.linspace(0, 1, 11), color="0.6")
                panel.set_yticks([])
            elif row > column:
                panel.plot(actuation[:, column], actuation[:, row], "ko", markersize=4, alpha=0.4)
                panel.set(yticks=(0, 0.5, 1), ylim=(-0.05, 1.05))
            else:
                panel.text(0.5, 0.5, f"r = {r[row, column]:.2f}", ha="center", va="center")
                panel.set(yticks=[], ylim=(0, 1))
            if column > 0:
                panel.set_yticklabels([])
            if column == 0:
                panel.set_ylabel("abcd"[row])
            if row == count - 1:
                panel.set_xlabel("abcd"[column])
