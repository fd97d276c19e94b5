"""Does compliance add contacts? Hands of soft and of stiff rubber that hold alike hard (8.1)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Self

import numpy as np

from pneuflex_sim.world import Diverged
from softhand_trials.sweep import run_tasks
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.success_map import finished
from softhand_trials.sweep.task import DIGEST_DIGITS
from thesis.chapter_8.closing_hand import Closing, ClosingHand, Draw, Held
from thesis.chapter_8.object_map import ALL
from thesis.frame import Array, Figure, Finding, Job, Report, Results, option

SIZE = (9.5, 3.8)
OBJECTS = tuple(name for name in ALL if name != "tissue")  # a spring cannot hold a sheet
CLOSINGS = {
    "rbo_hand_2": Closing("rbo_hand_2", None, (60e3, 60e3, 60e3, 90e3), (0.0225, 0.0, 0.115)),
    "rbo_hand_1": Closing("rbo_hand_1", "rbo_hand_1", (210e3,), (0.0295, 0.0, 0.100)),
}
SOFT, SAME, STIFF = "soft", "same", "stiff"  # arms; the second is the negative control
BOOTSTRAPS, BOOTSTRAP_SEED, ENDS = 10_000, 0, (2.5, 97.5)  # ends of the interval in percent
MOST_SAME = 1.0  # links that the control may differ by in the mean
MEASURES = {"links": 1.0, "parts": 1.0, "redundancy": 1.0, "area": 1e4, "margin": 1.0}
UNITS = {"area": " cm2"}
WORDS = {
    "links": "links that touch",
    "parts": "fingers, thumb, palm and plate that touch",
    "redundancy": "redundancy of the forces",
    "area": "area of the skin's patches",
    "margin": "margin of force closure",
}
JUDGED = ("links", "redundancy")  # the thesis: more contacts, more redundancy
COLOURS = {SOFT: "C2", SAME: "C7", STIFF: "C3"}
SMALL = {"hands": ("rbo_hand_2",), "objects": ("cylinder", "tape_dispenser"), "trials": 1}
SMALL |= {"segments": 5, "jobs": 0}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    hands: tuple[str, ...] = option(tuple(CLOSINGS), "names of hands [-]")
    objects: tuple[str, ...] = option(OBJECTS, "names of objects [-]")
    trials: int = option(3, "an object and a hand, each with all arms [-]")
    stiffness: float = option(20.0, "modulus of the stiff rubber over that of the soft [-]")
    segments: int = option(10, "of each actuator [-]")
    seed: int = option(0, "of the first trial; the protocol was made on seed 900 [-]")
    jobs: int = option(2, "processes; 0: this one [-]")

    def continued(self, folder: Path) -> Self:
        """These parameters with the hands that already have trials in the folder."""
        there = [name for name in CLOSINGS if read_results(folder / name)]
        return replace(self, hands=tuple(dict.fromkeys([*there, *self.hands])))

    def __post_init__(self) -> None:
        for field, known in (("hands", CLOSINGS), ("objects", OBJECTS)):
            if unknown := sorted(set(getattr(self, field)) - set(known)):
                expected = f"some of {', '.join(known)}"
                raise ValueError(f"{field}: expected {expected}, got {', '.join(unknown)}")
        if self.trials < 1:
            raise ValueError(f"trials: expected 1 or more, got {self.trials}")


@dataclass(frozen=True)
class Trial:
    """A hand, an object and a seed, tried with every arm: a `Task`."""

    hand: str
    object: str
    seed: int
    stiffness: float
    segments: int

    @property
    def key(self) -> str:
        """Its name."""
        return f"{self.hand}/{self.object}/{self.seed}"

    @property
    def settings(self) -> str:
        """Nothing is built that two trials share."""
        return self.key

    @property
    def digest(self) -> str:
        """Hash of its fields."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:DIGEST_DIGITS]

    def describe(self) -> dict[str, Any]:
        """What its record says of it."""
        return {"key": self.key, "digest": self.digest} | asdict(self)

    def result(self) -> dict[str, Any]:
        """What its arms hold."""
        return {"arms": compared(self)}


def run(given: Parameters, job: Job) -> Results:
    """All trials, each with the soft hand first, whose force the other arms close with; those with
    results in the job's folder are not run again.
    """
    seeds, found = range(given.seed, given.seed + given.trials), []
    for number, hand in enumerate(given.hands):
        job.progress(hand, number / len(given.hands))
        trials = [
            Trial(hand, name, seed, given.stiffness, given.segments)
            for seed, name in product(seeds, given.objects)
        ]
        records = run_tasks(trials, job.folder / hand, given.jobs, name=hand)
        found += [
            {name: record[name] for name in ("hand", "object", "seed", "arms")}
            for record in finished(records)
        ]
    return {"trials": found}


def compared(trial: Trial) -> dict[str, Any]:
    """What each arm holds (`Held`), or the error of one that diverged; where that is the soft one,
    the others have no force to close with.
    """
    draw = Draw.of(trial.seed, OBJECTS.index(trial.object))
    found: dict[str, Any] = {}
    force: float | None = None
    for arm, stiffness in ((SOFT, 1.0), (SAME, 1.0), (STIFF, trial.stiffness)):
        hand = ClosingHand(CLOSINGS[trial.hand], trial.object, draw, stiffness, trial.segments)
        try:
            held = hand.hold(force)
        except Diverged as error:
            found[arm] = {"error": str(error)}
        else:
            found[arm] = asdict(held)
            force = held.force if arm == SOFT else force
        finally:
            hand.close()
        if not force:
            break
    return found


# ---------------------------------------------------------------- differences
def value(held: dict[str, Any], measure: str) -> float:
    """A measure of a hold [the unit of `UNITS`]; 0 of what was lost."""
    return 0.0 if Held(**held).lost else MEASURES[measure] * held[measure]


def pairs(trials: Sequence[dict[str, Any]], other: str, kept: bool = False) -> list[dict[str, Any]]:
    """Trials in which neither the soft hand nor the other arm diverged; only those in which both
    hold the object, if `kept`.
    """
    return [
        trial
        for trial in trials
        if all("force" in trial["arms"].get(arm, {}) for arm in (SOFT, other))
        and not (kept and any(Held(**trial["arms"][arm]).lost for arm in (SOFT, other)))
    ]


def differences(trials: Sequence[dict[str, Any]], other: str, measure: str) -> dict[str, Array]:
    """Soft less other arm of each pair, by object."""
    found: dict[str, list[float]] = {}
    for trial in trials:
        soft, rest = (value(trial["arms"][arm], measure) for arm in (SOFT, other))
        found.setdefault(trial["object"], []).append(soft - rest)
    return {name: np.array(each) for name, each in found.items()}


def interval(by_object: dict[str, Array]) -> tuple[float, float, float]:
    """Mean over objects of the mean over their trials, and the ends of its 95 % interval by
    bootstrap: objects are drawn anew, and trials of each of them.

    >>> interval({"ball": np.array([1.0, 1.0]), "cup": np.array([3.0, 3.0])})
    (2.0, 1.0, 3.0)
    """
    rng, groups = np.random.default_rng(BOOTSTRAP_SEED), list(by_object.values())
    drawn = np.empty((BOOTSTRAPS, len(groups)))
    for row in drawn:
        for k, which in enumerate(rng.integers(len(groups), size=len(groups))):
            group = groups[which]
            row[k] = group[rng.integers(len(group), size=len(group))].mean()
    low, high = np.percentile(drawn.mean(axis=1), ENDS)
    return float(np.mean([group.mean() for group in groups])), float(low), float(high)


# ---------------------------------------------------------------- report
def report(results: Results, given: Parameters) -> Report:
    """A row a hand and measure: what the soft hand has more than the stiff one that presses alike
    hard. The thesis argues for it and states no number.
    """
    findings: list[Finding] = []
    words = []
    for hand in given.hands:
        trials = [trial for trial in results["trials"] if trial["hand"] == hand]
        spoken = hand.replace("rbo_hand_", "RBO Hand ")
        if not pairs(trials, STIFF) or not pairs(trials, SAME):
            findings.append(Finding(f"{spoken}: pairs", "-", "none: all diverged", False))
            continue
        findings += [_more(spoken, trials, measure) for measure in MEASURES]
        findings += [_both_held(spoken, trials), _same(spoken, trials)]
        findings += [_state(spoken, trials, arm) for arm in COLOURS]
        mean, low, high = interval(differences(pairs(trials, STIFF), STIFF, "links"))
        words.append(f"{spoken} {mean:+.1f} links ({low:+.1f} to {high:+.1f})")
    ends = "; ".join(words) or "no pairs"
    return Report(findings, f"Soft less {given.stiffness:g} times stiffer rubber: {ends}.")


def _told(by_object: dict[str, Array], measure: str) -> tuple[str, float]:
    """Mean with interval as text, and the lower end."""
    digits = 2 if measure in ("area", "margin") else 1
    found = interval(by_object)
    mean, low, high = (f"{end:+.{digits}f}" for end in found)
    return f"{mean}{UNITS.get(measure, '')} ({low} to {high})", found[1]


def _more(spoken: str, trials: Sequence[dict[str, Any]], measure: str) -> Finding:
    chosen = pairs(trials, STIFF)
    text, low = _told(differences(chosen, STIFF, measure), measure)
    soft, stiff = (
        np.mean([value(trial["arms"][arm], measure) for trial in chosen]) for arm in (SOFT, STIFF)
    )
    digits = 2 if measure in ("area", "margin") else 1
    ours = f"{soft:.{digits}f} against {stiff:.{digits}f}: {text}, {len(chosen)} pairs"
    if measure not in JUDGED:
        return Finding(f"{spoken}: {WORDS[measure]}", "-", ours)
    return Finding(f"{spoken}: {WORDS[measure]}", "more", f"{ours} (low end > 0)", low > 0.0)


def _both_held(spoken: str, trials: Sequence[dict[str, Any]]) -> Finding:
    chosen = pairs(trials, STIFF, kept=True)
    text = _told(differences(chosen, STIFF, "links"), "links")[0] if chosen else "-"
    what = f"{spoken}: links, pairs in which both hold the object"
    return Finding(what, "-", f"{text}, {len(chosen)} pairs")


def _same(spoken: str, trials: Sequence[dict[str, Any]]) -> Finding:
    by_object = differences(pairs(trials, SAME), SAME, "links")
    mean, text = interval(by_object)[0], _told(by_object, "links")[0]
    what = f"{spoken}: negative control, soft rubber closed by its force: links"
    return Finding(what, "-", f"{text} (mean within {MOST_SAME:g})", abs(mean) <= MOST_SAME)


def _state(spoken: str, trials: Sequence[dict[str, Any]], arm: str) -> Finding:
    """How an arm pressed, yielded and held."""
    held = [trial["arms"][arm] for trial in trials if "force" in trial["arms"].get(arm, {})]
    lost = sum(Held(**each).lost for each in held)
    closed = sum(value(each, "margin") > 0.0 for each in held)
    force, yielding, air = (
        np.median([each[name] for each in held]) for name in ("force", "yielding", "air")
    )
    ours = (
        f"{len(held) - lost} of {len(trials)} held, {closed} force-closed, "
        f"{len(trials) - len(held)} diverged; median force {force:.1f} N, air x {air:.2f}, joints "
        f"yield by {np.degrees(yielding):.2f} deg"
    )
    return Finding(f"{spoken}, {arm}", "-", ours)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Links in contact by object and arm: trials as points, means as bars."""
    hands = list(dict.fromkeys(trial["hand"] for trial in results["trials"]))
    panels = figure.subplots(1, len(hands), sharey=True, squeeze=False)[0]
    labels = {SOFT: "soft", SAME: "soft, closed by force", STIFF: "stiff, closed by force"}
    for panel, hand in zip(panels, hands, strict=True):
        trials = [trial for trial in results["trials"] if trial["hand"] == hand]
        names = list(dict.fromkeys(trial["object"] for trial in trials))
        for k, (arm, colour) in enumerate(COLOURS.items()):
            for x, name in enumerate(names):
                found = [
                    value(trial["arms"][arm], "links")
                    for trial in trials
                    if trial["object"] == name and "force" in trial["arms"].get(arm, {})
                ]
                place = x + 0.27 * (k - 1)
                label = labels[arm] if x == 0 else None
                panel.bar(
                    place, np.mean(found or [0.0]), 0.25, color=colour, alpha=0.5, label=label
                )
                panel.plot([place] * len(found), found, ".", color=colour, ms=3)
        panel.set_xticks(range(len(names)), [name.replace("_", " ") for name in names])
        panel.tick_params(axis="x", labelrotation=45, labelsize=7)
        panel.set_title(hand.replace("rbo_hand_", "RBO Hand "), fontsize=9)
    panels[0].set_ylabel("links that touch [-]")
    panels[0].legend(fontsize=7)
