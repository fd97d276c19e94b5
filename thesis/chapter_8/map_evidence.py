"""How far the verdicts of a map can be trusted: the same trials in another engine, and some of them
again at a fine step, in each engine.

Shared by the maps of chapters 8 and 9.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from pneuflex_sim.bullet import is_installed
from pneuflex_sim.engines import ENGINES, default_engine
from softhand_model.usual_step import USUAL_STEP
from softhand_trials.sweep import SweepPlan
from softhand_trials.sweep.report import ENGINE_PART, agreements, wilson
from softhand_trials.sweep.run import run_tasks
from softhand_trials.sweep.task import Record
from softhand_trials.sweep.trial_task import TrialTask
from thesis.frame import Finding, Results, option

MAIN = "main"  # name of the sweep that makes a map
FINE = 0.001  # step of the trials that are run again [s]
LEAST_SAME = 0.95  # of their verdicts as at the step of the map
LEAST_AGREED = 0.85  # of the verdicts of two engines
SMALL_EVIDENCE = {"step": 0.005, "fine": 0, "engines": (default_engine(),)}  # of small runs
FINE_DRAW = 1  # keeps this draw apart from others of the seed


def usual_engines() -> tuple[str, ...]:
    """Those that are installed, the default one first."""
    first = default_engine()
    return (first, *(name for name in ENGINES if name != first and is_installed(name)))


@dataclass(frozen=True)
class Evidence:
    """Options that all maps share."""

    step: float = option(USUAL_STEP, "of the physics [s]")
    fine: int = option(4, "random trials of each object, run again at 1 ms in each engine [-]")
    sample: int = option(
        0,
        "random trials of an object in further engines, of push and surface in checks; 0: all [-]",
    )
    seed: int = option(0, "of the jitter, and of the draw of these trials [-]")
    jobs: int = option(2, "processes; 0: in this one [-]")
    engines: tuple[str, ...] = option(
        usual_engines(), "physics engine of the map; others run its trials to compare [-]"
    )


def other_engines(main: SweepPlan, given: Evidence, folder: Path) -> dict[str, list[Record]]:
    """Records of the trials of a map, or of a random sample, by further engine. An engine may
    refuse an object.
    """
    return {
        engine: run_tasks(
            sampled(main.in_engines([engine]), given),
            folder / f"{MAIN}_{engine}",
            given.jobs,
            name=f"{main.name}, {engine}",
        )
        for engine in given.engines[1:]
    }


def sampled(plan: SweepPlan, given: Evidence) -> list[TrialTask]:
    """All trials of a plan, or the random sample that is asked for: the same in all engines."""
    lines = plan.tasks()
    return drawn(lines, given.sample, given.seed) if given.sample else lines


def judged_again(
    main: SweepPlan, by_engine: Mapping[str, Sequence[Record]], given: Evidence, folder: Path
) -> Results:
    """How far the engines agree (`Agreement.record`), by object, and how far random trials end at 1
    ms as they do at the step of the map.

    Args:
        main: the map.
        by_engine: the records of its trials.
        given: engines, number of random trials of an object, seed, processes.
        folder: of the map.
    """
    every = [record for records in by_engine.values() for record in records]
    lines = drawn(sampled(main, given), given.fine, given.seed)
    steps = [
        _compared(engine, by_engine[engine], _fine(lines, engine, folder, given.jobs))
        for engine in (given.engines if lines else ())
    ]
    return {"engines": [found.record() for found in agreements(every)], "steps": steps}


def drawn(trials: Iterable[TrialTask], count: int, seed: int) -> list[TrialTask]:
    """As many random trials of each object, whatever other objects there are; all if there are
    fewer.
    """
    by_object: dict[str, list[TrialTask]] = {}
    for line in trials:
        by_object.setdefault(line.object, []).append(line)
    found = []
    for name, lines in by_object.items():
        draw = np.random.default_rng([seed, FINE_DRAW, zlib.crc32(Path(name).stem.encode())])
        chosen = draw.choice(len(lines), min(count, len(lines)), replace=False)
        found += [lines[k] for k in sorted(chosen.tolist())]
    return found


def _fine(lines: Sequence[TrialTask], engine: str, folder: Path, jobs: int) -> list[Record]:
    fine = [
        replace(line, settings=replace(line.settings, engine=engine, step=FINE)) for line in lines
    ]
    return run_tasks(fine, folder / f"fine_{engine}", jobs, name=f"1 ms, {engine}")


def _compared(engine: str, records: Sequence[Record], fine: Sequence[Record]) -> dict[str, Any]:
    usual = {_trial(record): record for record in records if "error" not in record}
    pairs = {
        record["key"]: (_held(usual[record["key"]]), _held(record))
        for record in fine
        if "error" not in record and record["key"] in usual
    }
    differing = {key: pair for key, pair in pairs.items() if pair[0] != pair[1]}
    return {
        "engine": engine,
        "trials": len(pairs),
        "held": sum(held for held, _ in pairs.values()),
        "held_fine": sum(held for _, held in pairs.values()),
        "differing": list(differing),
    }


def _trial(record: Record) -> str:
    """Key of a trial, the same in all engines."""
    parts = record["key"].split("/")
    return "/".join(part for part in parts if not part.startswith(ENGINE_PART))


def _held(record: Record) -> bool:
    return bool(record["outcome"] == OUTCOME_GRIPPED)


# ---------------------------------------------------------------- findings
def evidence_findings(results: Results, step: float) -> list[Finding]:
    """How far engines agree, by object and in all, and how far the step [s] matters, by engine."""
    rows = [
        Finding(f"engines, {found['name']}", "-", found["text"]) for found in results["engines"]
    ]
    compared = sum(found["trials"] for found in results["engines"])
    if compared:
        same = sum(found["same"] for found in results["engines"])
        words = _share(same, compared, LEAST_AGREED)
        met = same >= LEAST_AGREED * compared
        rows.append(Finding("verdicts that two engines share", "-", words, met))
    for found in results["steps"]:
        count, same = found["trials"], found["trials"] - len(found["differing"])
        words = (
            f"{_share(same, count, LEAST_SAME)}; held {found['held']}, at 1 ms {found['held_fine']}"
        )
        what = f"verdicts as at 1 ms, {found['engine']} at {1e3 * step:g} ms"
        rows.append(Finding(what, "-", words, same >= LEAST_SAME * count))
    return rows


def _share(same: int, count: int, least: float) -> str:
    low, high = (100 * end for end in wilson(same, count))
    return (
        f"{same} of {count}, {100 * same / count:.0f} % ({low:.0f} to {high:.0f}) "
        f"(>= {100 * least:.0f})"
    )


def differing_cells(results: Results) -> dict[str, list[tuple[float, float]]]:
    """Cells (x, y) [m] with a trial on which the engines differ, by the name of a group of trials
    without its plan.
    """
    return {
        found["name"].split("/", 1)[1]: sorted({cell_of(trial) for trial in found["differing"]})
        for found in results["engines"]
    }


def cell_of(trial: str) -> tuple[float, float]:
    """Cell (x, y) [m] of the last two parts of a key, `12,-30/1`.

    >>> cell_of("12,-30/1")
    (0.012, -0.03)
    """
    x, y = (float(value) / 1e3 for value in trial.split("/")[0].split(","))
    return x, y
