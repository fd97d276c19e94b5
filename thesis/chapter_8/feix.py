"""The 33 grasps of the Feix taxonomy with RBO Hand 2 (8.2.2, Figs 8.9, 8.10).

Air masses, filling order and place of the object are found by CMA-ES, where the thesis found them
by trial and error. Grasp types, starting points, judge and cost are those of
`thesis.chapter_8.dexterity`. The best pattern of each type is stored and judged in jittered trials
that the search did not see; a type counts when all of them succeed. A person's verdict goes into
verdicts.csv and is reported separately.

All is simulated at the same step. Where a grasp is known from an earlier run (`known`), CMA-ES goes
on around it, and each evaluation shakes the object with two opposite draws of jitter. Where none is
known, as for the controls, it starts from hand-written values and pulls the object, which takes a
fifth of the time. The best grasps are shaken with more draws, by successive halving. A known grasp
is shaken with the same draws, and stays unless another one is held by the right parts with more of
them, or with as many (and at least one) at a lower mean cost. Winners are judged with new draws.
Budget, seeds and judge were fixed before each search. docs/thesis/feix.md has the results.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from softhand_trials.search import SearchProblem, SearchResult, Tried, search_with, try_again
from softhand_trials.search.again import IN_ERROR
from softhand_trials.search.objective import COST
from softhand_trials.sweep.results import Results as Lines
from softhand_trials.sweep.run import Workers, finish, start_workers
from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_search import (
    pattern_of,
    start_values,
    values_of,
    variables,
)
from thesis.chapter_8.dexterity.feix_trials import HandSettings, PatternTrial, fresh_trials
from thesis.chapter_8.dexterity.grasping import UNTURNED
from thesis.chapter_8.dexterity.patterns import (
    FILE as KNOWN,
)
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
from thesis.chapter_8.feix_report import AGAIN, ALL, FINER, HALF, SLIPPERY, STICKY, told
from thesis.chapter_8.feix_sheet import SIZE, draw, human_verdicts, write_verdicts
from thesis.frame import Job, Report, Results, option

__all__ = ["SIZE", "draw"]

CASES = (FOUR, UNTURNED)  # hands that are searched; all but the first are controls
CHECKS = (AGAIN, HALF, SLIPPERY, FINER, STICKY)  # the stored patterns, run from their file
FRICTION = {SLIPPERY: 1e-6, STICKY: 2.0}  # factors on that of all pairs
ENOUGH = 10.0  # cost [mm] with which a search around a known grasp ends: half of the judge's limits
SPREAD = 0.08  # of CMA-ES around a known grasp, as a share of each range; by hand, before the run
OBJECTIVE = "thesis.chapter_8.dexterity.feix_search:grasp"
PATTERNS, STRATEGIES, SHIPPED = "patterns.yaml", "strategies", "shipped"
SMALL = {
    "types": (9,),
    "cases": (FOUR,),
    "checks": (SLIPPERY,),
    "evaluations": 4,
    "known": "",
    "generation": 4,
    "tried": (1,),
    "trials": 1,
    "step": 0.004,
    "segments": 5,
    "jobs": 0,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    types: tuple[int, ...] = option(ALL, "by their numbers [-]")
    cases: tuple[str, ...] = option((FOUR, UNTURNED), f"hands that are searched, of {CASES} [-]")
    checks: tuple[str, ...] = option(
        CHECKS[:-1], "runs of the stored patterns; none are allowed [-]"
    )
    known: str = option(
        SHIPPED, f"file of grasps that are searched around, or {SHIPPED}; empty: none [-]"
    )
    evaluations: int = option(260, "of a search without a known grasp, its budget [-]")
    around: int = option(31, "of a search around a known grasp [-]")
    tried: tuple[int, ...] = option(
        (18, 6, 3, 3, 2, 2, 2, 2), "candidates that each draw of jitter is tried on, and shaken [-]"
    )
    generation: int = option(10, "evaluations a generation [-]")
    trials: int = option(3, "jittered runs that judge a winner [-]")
    step: float = option(0.002, "of the physics in searches and trials [s]")
    finer_step: float = option(0.001, "of another verdict on the stored patterns [s]")
    segments: int = option(6, "an actuator [-]")
    seed: int = option(3000, "of searches and tries [-]")
    trial_seed: int = option(7000, "of the trials that judge, and of the checks [-]")
    jobs: int = option(2, "processes [-]")
    patterns: str = option("", "file of winners with four channels; empty: they are searched [-]")

    def __post_init__(self) -> None:
        known = {"types": ALL, "cases": CASES, "checks": CHECKS}
        for name, usual in known.items():
            if unknown := set(getattr(self, name)) - set(usual):
                raise ValueError(f"{name}: expected some of {usual}, got {sorted(unknown)}")
        if not self.types:
            raise ValueError("types: expected one or more, got none")
        if FOUR not in self.cases:
            raise ValueError(f"cases: expected {FOUR} among them, got {self.cases}")

    def continued(self, folder: Path) -> Parameters:
        """These parameters with the types that already have winners in the folder: a run adds to
        them.
        """
        path = folder / PATTERNS
        there = load_patterns(path).grasps if path.exists() else ()
        return replace(self, types=tuple(sorted({*there, *self.types})))


def problem(
    given: Parameters, case: str, number: int, known: Pattern | None = None
) -> SearchProblem:
    """The search for one type with one hand, around a known grasp if there is one."""
    seed = given.seed + number
    search = SearchProblem(
        f"{case}_{number}",
        OBJECTIVE,
        variables(number),
        given.evaluations,
        given.generation,
        "cma",
        seed=seed,
        start=start_values(number),
        settings={
            "type": number,
            "hand": case,
            "step": given.step,
            "segments": given.segments,
        },
        allow_any=True,
    )
    if known is None:
        return search
    around = replace(
        search,
        start=values_of(number, known),
        spread=SPREAD,
        evaluations=given.around,
        enough=ENOUGH,
    )
    return around.with_settings(draws=[[seed, 1], [seed, -1]])


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
    path = KNOWN if given.known == SHIPPED else Path(given.known)
    stored = load_patterns(path).grasps if given.known and case == FOUR else {}
    known = stored[number].pattern if number in stored else None
    search, place = problem(given, case, number, known), folder / "searches" / case / str(number)
    result = search_with(workers, search, place)
    if "error" in result.records[0]:
        known = None  # what cannot be simulated is not kept
    used = len(search.settings.get("draws", ()))
    draws = [(search.seed, (1 + k // 2) * (-1) ** k) for k in range(used, used + len(given.tried))]
    named = {str(draw[1]): draw for draw in draws}  # not those of the trials
    others = SearchResult(result.records[0 if known is None else 1 :])
    tried: list[Tried] = []
    if known is None or others.failed < len(others.records):
        tried = try_again(workers, search, others, named, given.tried, place / "tried")
    if known is not None:
        before, often = SearchResult(result.records[:1]), [1] * len(given.tried)
        tried += try_again(workers, search, before, named, often, place / "known_tried")
    winner = tried[0] if known is None else better(tried[0], tried[-1])
    times = [record["cpu_time"] for record in result.records]
    times += [record["cpu_time"] for one in tried for record in one.records]
    own: dict[str, Any] = {
        "pattern": pattern_of(number, winner.record["values"]),
        "seed": search.seed,
        "evaluation": winner.record["key"],
        "cost": winner.worst,
    }
    if known is not None and winner is tried[-1]:
        own = {key: getattr(stored[number], key) for key in own}
    return {
        **own,
        "evaluations": len(times),
        "failed": result.failed,
        "cpu_time": sum(times),
    }


def better(found: Tried, known: Tried) -> Tried:
    """The one that is held by the right parts with more draws, then that of the lower mean cost;
    the known one if there are no such draws.
    """
    counts, means = [], []
    for one in (found, known):
        records = [record for record in one.records if "error" not in record]
        counts.append(sum(not (r["typed"] or r["held_reason"] or r["dropped"]) for r in records))
        costs = [record.get(COST, IN_ERROR) for record in one.records]
        means.append(sum(costs) / max(1, len(costs)))
    more = (counts[0], -means[0]) > (counts[1], -means[1])
    return found if counts[0] and more else known


def _trials(folder: Path, name: str, number: int, evaluation: str) -> Path:
    """Path of the trials of a winner; with a larger budget the winner may be another one."""
    return folder / "trials" / name / str(number) / evaluation.rpartition("/")[2]


def _settings(given: Parameters, case: str, number: int) -> HandSettings:
    return HandSettings(grasp_types()[number].object, case, given.step, given.segments)


def _judged(workers: Workers, trials: Sequence[PatternTrial], folder: Path) -> list[dict[str, Any]]:
    """Records of trials; those that exist are not run again."""
    with Lines(folder, trials) as results:
        return finish(workers, trials, results)


def _store(given: Parameters, found: Mapping[str, Any], path: Path) -> None:
    """Write the winners as patterns."""
    kept = load_patterns(path).grasps if path.exists() else {}
    grasps = {**kept, **{int(number): _stored(one) for number, one in found.items()}}
    ordered = dict(sorted(grasps.items()))
    write_patterns(Patterns(HAND, given.step, given.segments, Times(), ordered), path)


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
            friction_scale=FRICTION.get(name, 1.0),
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
