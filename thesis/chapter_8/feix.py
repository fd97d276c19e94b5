"""The 33 grasps of the Feix taxonomy with RBO Hand 2 (8.2.2, Figs 8.9, 8.10).

Air masses, filling order and place of the object are found by CMA-ES, where the thesis found them
by trial and error. Grasp types, starting points, judge and cost are those of
`thesis.chapter_8.dexterity`. The best pattern of each type is stored and judged in jittered trials
that the search did not see; a type counts when all of them succeed. A person's verdict goes into
verdicts.csv and is reported separately.

A search has 300 evaluations. It first pulls the object, at steps of 5 ms; the best grasps are then
shaken at steps of 2 ms, in pairs of opposite draws, by successive halving. Winners are judged at 2
ms with new draws. Budget, seeds and judge were fixed before any search; the settings of the search
were chosen on type 14 alone (seed 3014). docs/thesis/feix.md has the results, and why these steps
are used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from softhand_trials.search import SearchProblem, search_with, try_again
from softhand_trials.sweep.results import Results as Lines
from softhand_trials.sweep.run import Workers, finish, start_workers
from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_search import pattern_of, start_values, variables
from thesis.chapter_8.dexterity.feix_trials import HandSettings, PatternTrial, fresh_trials
from thesis.chapter_8.dexterity.grasping import UNTURNED
from thesis.chapter_8.dexterity.patterns import (
    Pattern,
    Patterns,
    StoredGrasp,
    Times,
    load_patterns,
    write_patterns,
)
from thesis.chapter_8.dexterity.posture import FOUR, HAND
from thesis.chapter_8.dexterity.strategy_file import write_strategies
from thesis.chapter_8.feix_report import AGAIN, ALL, FINER, HALF, SLIPPERY, told
from thesis.chapter_8.feix_sheet import SIZE, draw, human_verdicts, write_verdicts
from thesis.frame import Job, Report, Results, option

__all__ = ["SIZE", "draw"]

CASES = (FOUR, UNTURNED)  # hands that are searched; all but the first are controls
CHECKS = (AGAIN, HALF, SLIPPERY, FINER)  # the stored patterns, run from their file
NO_FRICTION = 1e-6  # factor on that of all pairs
OBJECTIVE = "thesis.chapter_8.dexterity.feix_search:grasp"
PATTERNS, STRATEGIES = "patterns.yaml", "strategies"
SMALL = {
    "types": (9,),
    "cases": (FOUR,),
    "checks": (SLIPPERY,),
    "evaluations": 4,
    "generation": 4,
    "tried": (1,),
    "trials": 1,
    "judged_step": 0.004,
    "segments": 5,
    "jobs": 0,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    types: tuple[int, ...] = option(ALL, "by their numbers [-]")
    cases: tuple[str, ...] = option((FOUR, UNTURNED), f"hands that are searched, of {CASES} [-]")
    checks: tuple[str, ...] = option(CHECKS, "runs of the stored patterns [-]")
    evaluations: int = option(260, "of a search, its budget [-]")
    tried: tuple[int, ...] = option(
        (18, 6, 3, 3, 2, 2, 2, 2), "candidates that each draw of jitter is tried on, and shaken [-]"
    )
    generation: int = option(10, "evaluations a generation [-]")
    trials: int = option(3, "jittered runs that judge a winner [-]")
    step: float = option(0.005, "of the physics in the searches [s]")
    judged_step: float = option(0.002, "where the best are shaken and winners are judged [s]")
    finer_step: float = option(0.001, "of another verdict on the stored patterns [s]")
    segments: int = option(6, "an actuator [-]")
    seed: int = option(3000, "of searches and tries [-]")
    trial_seed: int = option(5000, "of the trials that judge, and of the checks [-]")
    jobs: int = option(2, "processes [-]")
    patterns: str = option("", "file of winners with four channels; empty: they are searched [-]")

    def __post_init__(self) -> None:
        known = {"types": ALL, "cases": CASES, "checks": CHECKS}
        for name, usual in known.items():
            if unknown := set(getattr(self, name)) - set(usual):
                raise ValueError(f"{name}: expected some of {usual}, got {sorted(unknown)}")
        if FOUR not in self.cases:
            raise ValueError(f"cases: expected {FOUR} among them, got {self.cases}")

    def continued(self, folder: Path) -> Parameters:
        """These parameters with the types that already have winners in the folder: a run adds to
        them.
        """
        path = folder / PATTERNS
        there = load_patterns(path).grasps if path.exists() else ()
        return replace(self, types=tuple(sorted({*there, *self.types})))


def problem(given: Parameters, case: str, number: int) -> SearchProblem:
    """The search for one type with one hand."""
    return SearchProblem(
        f"{case}_{number}",
        OBJECTIVE,
        variables(number),
        given.evaluations,
        given.generation,
        "cma",
        seed=given.seed + number,
        start=start_values(number),
        settings={
            "type": number,
            "hand": case,
            "step": given.step,
            "segments": given.segments,
        },
        allow_any=True,
    )


# ---------------------------------------------------------------- run
def run(given: Parameters, job: Job) -> Results:
    """Searches, trials of the winners, checks of the stored patterns, and a person's verdicts."""
    found: dict[str, dict[str, Any]] = {case: {} for case in given.cases}
    with start_workers(given.jobs) as workers:
        for number in given.types:
            for case in given.cases:
                job.progress(f"{case}, type {number}", _share(found, given))
                found[case][str(number)] = _one_type(workers, given, job.folder, case, number)
            _store(given, found[FOUR], job.folder / PATTERNS)
        patterns = load_patterns(job.folder / PATTERNS)
        write_strategies(patterns, job.folder / STRATEGIES)
        checks = {name: _check(workers, given, patterns, name, job) for name in given.checks}
    joints, objects = _postures(found[FOUR])
    write_verdicts(job.folder, found[FOUR])
    return {
        "cases": {case: {n: _told(one) for n, one in own.items()} for case, own in found.items()},
        "checks": checks,
        "human": human_verdicts(job.folder),
        "joints": joints,
        "objects": objects,
    }


def _share(found: Mapping[str, Any], given: Parameters) -> float:
    return sum(map(len, found.values())) / (len(given.types) * len(given.cases) + 1)


def _one_type(
    workers: Workers, given: Parameters, folder: Path, case: str, number: int
) -> dict[str, Any]:
    """The winner of a type, from the file or of a search, and its trials."""
    if given.patterns and case == FOUR:
        winner = _read(Path(given.patterns), number)
    else:
        winner = _searched(workers, given, folder, case, number)
    settings, pattern = _settings(given, case, number), winner["pattern"]
    own = fresh_trials(case, number, pattern, Times(), settings, given.trial_seed, given.trials)
    place = _trials(folder, case, number, winner["evaluation"])
    return {**winner, "trials": _judged(workers, own, place)}


def _read(path: Path, number: int) -> dict[str, Any]:
    """A winner as it is stored."""
    grasps = load_patterns(path).grasps
    if number not in grasps:
        raise ValueError(f"{path}: expected a grasp of type {number}, got {sorted(grasps)}")
    own = {key: getattr(grasps[number], key) for key in ("pattern", "seed", "evaluation", "cost")}
    return {**own, "evaluations": 0, "failed": 0, "cpu_time": 0.0}


def _searched(
    workers: Workers, given: Parameters, folder: Path, case: str, number: int
) -> dict[str, Any]:
    """The winner of a search."""
    search, place = problem(given, case, number), folder / "searches" / case / str(number)
    result = search_with(workers, search, place)
    draws = [(search.seed, (1 + k // 2) * (-1) ** k) for k in range(len(given.tried))]
    named = {str(draw[1]): draw for draw in draws}  # not those of the trials
    shaken = search.with_settings(step=given.judged_step)
    tried = try_again(workers, shaken, result, named, given.tried, place / "tried")
    winner = tried[0]
    times = [record["cpu_time"] for record in result.records]
    times += [record["cpu_time"] for one in tried for record in one.records]
    return {
        "pattern": pattern_of(number, winner.record["values"]),
        "seed": search.seed,
        "evaluation": winner.record["key"],
        "cost": winner.worst,
        "evaluations": len(times),
        "failed": result.failed,
        "cpu_time": sum(times),
    }


def _trials(folder: Path, name: str, number: int, evaluation: str) -> Path:
    """Path of the trials of a winner; with a larger budget the winner may be another one."""
    return folder / "trials" / name / str(number) / evaluation.rpartition("/")[2]


def _settings(given: Parameters, case: str, number: int) -> HandSettings:
    return HandSettings(grasp_types()[number].object, case, given.judged_step, given.segments)


def _judged(workers: Workers, trials: Sequence[PatternTrial], folder: Path) -> list[dict[str, Any]]:
    """Records of trials; those that exist are not run again."""
    with Lines(folder, trials) as results:
        return finish(workers, trials, results)


def _store(given: Parameters, found: Mapping[str, Any], path: Path) -> None:
    """Write the winners as patterns."""
    kept = load_patterns(path).grasps if path.exists() else {}
    grasps = {**kept, **{int(number): _stored(one) for number, one in found.items()}}
    ordered = dict(sorted(grasps.items()))
    write_patterns(Patterns(HAND, given.judged_step, given.segments, Times(), ordered), path)


def _stored(one: Mapping[str, Any]) -> StoredGrasp:
    keys = ("held", "by_thirds", "at_rest", "typed", "held_reason", "typed_reason")
    keys += ("markers", "object")
    trials = one["trials"]
    return StoredGrasp(
        one["pattern"],
        one["seed"],
        one["evaluation"],
        one["cost"],
        sum(trial.get("held", False) for trial in trials),
        sum(trial.get("typed", False) for trial in trials),
        float(trials[0].get("robust", 0.0)),
        tuple({key: trial[key] for key in keys if key in trial} for trial in trials),
    )


def _check(
    workers: Workers, given: Parameters, patterns: Patterns, name: str, job: Job
) -> dict[str, Any]:
    """Runs of the patterns as they are stored in their file, by type."""
    job.progress(name, 0.99)
    found = {}
    for number in given.types:
        stored, settings = patterns.grasps[number], _settings(given, FOUR, number)
        trials = fresh_trials(
            name,
            number,
            stored.pattern,
            patterns.times,
            replace(settings, step=given.finer_step) if name == FINER else settings,
            given.trial_seed,
            1 if name == AGAIN else given.trials,
            strength=0.5 if name == HALF else 1.0,
            friction_scale=NO_FRICTION if name == SLIPPERY else 1.0,
        )
        if name != AGAIN:
            trials = [replace(trial, robust=False) for trial in trials]
        records = _judged(workers, trials, _trials(job.folder, name, number, stored.evaluation))
        found[str(number)] = [_told_trial(record) for record in records]
    return found


def _told_trial(record: Mapping[str, Any]) -> dict[str, Any]:
    """A trial without what draws and names it."""
    left_out = ("joints", "versions", "digest", "draw", "strength")
    return {key: value for key, value in record.items() if key not in left_out}


def _told(one: Mapping[str, Any]) -> dict[str, Any]:
    pattern: Pattern = one["pattern"]
    own = {key: value for key, value in one.items() if key not in ("pattern", "trials")}
    masses = {"pre": dict(pattern.pre), "final": dict(pattern.final)}
    order = {"palm_first": pattern.palm_first}
    return {**own, **masses, **order, "trials": [_told_trial(t) for t in one["trials"]]}


def _postures(found: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Joint orientations (types, n, 4) of the first trial of each type, and pose (types, 7) of the
    object; NaN where a trial has none.
    """
    firsts = [one["trials"][0] for one in found.values()]
    shape = next((np.shape(trial["joints"]) for trial in firsts if "joints" in trial), (1, 4))
    joints = [trial.get("joints", np.full(shape, np.nan)) for trial in firsts]
    poses = [trial.get("object", [[np.nan] * 3, [np.nan] * 4]) for trial in firsts]
    return np.array(joints), np.array([[*place, *turn] for place, turn in poses])


# ---------------------------------------------------------------- report
def report(results: Results, given: Parameters) -> Report:
    """A row per type, then the criteria, which are judged once all types were run."""
    return told(results, given.types)
