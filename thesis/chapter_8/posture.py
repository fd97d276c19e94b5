"""Posture against actuation of grasps, the empty hand as control (8.2.3, 8.2.4, Figs 8.14, 8.15).

Uses the stored grasps of the Feix experiment that were held in all trials. Each is repeated in two
jittered trials, with its object and with the same air in an empty hand; the places of markers on
the tips are averaged over the two (8.2.3). `posture_variance` has the analysis.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.world import Diverged
from softhand_trials.sweep.run import run_tasks
from softhand_trials.sweep.task import DIGEST_DIGITS, Record
from thesis.chapter_8.dexterity.feix import FINGERS, THUMB
from thesis.chapter_8.dexterity.feix_search import starts
from thesis.chapter_8.dexterity.grasping import Draw, drawn, grasping
from thesis.chapter_8.dexterity.patterns import FILE, Pattern, Patterns, Times, load_patterns
from thesis.chapter_8.dexterity.posture import FOUR
from thesis.chapter_8.human_postures import human_postures
from thesis.chapter_8.posture_report import EMPTY, HELD, SIZE, draw, told
from thesis.chapter_8.posture_variance import residual_variance
from thesis.frame import Array, Job, Report, Results, option

__all__ = ["SIZE", "draw"]

MARKERS = (THUMB, *FINGERS)
TRIALS = 2  # of each grasp, averaged (8.2.3)
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
    """A stored grasp executed once, with or without its object; the result depends on these fields
    alone.

    Args:
        number: of the type.
        trial: from 0 on.
        object_there: whether the hand gets the object.
        pattern: the grasp, with its times.
        draw: variation of the trial.
        step, segments: of the simulation [s], per actuator.
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
        return hashlib.sha256(text.encode()).hexdigest()[:DIGEST_DIGITS]

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
    """Actuation and postures of the held grasps.

    Returns actuation (n, 4) as shares of the channels' content at their limits, places of the
    markers (2, n, 15) [m] with object and without in two trials, the types, which types were left
    out and why, and the residual variances of people.

    Raises ValueError when fewer grasps were held than are needed.
    """
    patterns = load_patterns(Path(given.patterns) if given.patterns else FILE)
    numbers = held_types(patterns)[: given.most]
    _refuse_few(len(numbers), given, f"of {len(patterns.grasps)} stored ones were held")
    people = human_postures(Path(given.human)) if given.human else {}
    job.progress(f"{len(numbers)} grasps, with and without object", 0.0)
    lines = trials(given, patterns, numbers)
    records = {
        record["key"]: record for record in run_tasks(lines, job.folder / "trials", given.jobs)
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
    """Why types are left out."""
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
def report(results: Results, given: Parameters) -> Report:
    """Dimensions of postures and actuation, and the part of the difference that is due to
    interaction.
    """
    return told(results)
