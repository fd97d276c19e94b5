"""The sets of the benchmark and the diagnosis of one of them."""

from __future__ import annotations

import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.hidden.case import Case, visible
from bench.hidden.cases import all_cases
from bench.lab.adapter import diagnosis_of
from bench.lab.planning import answers
from bench.lab.store import key_of

KEPT = (
    "verdict",
    "effects",
    "tied",
    "calibration",
    "noise_floor",
    "noise_floor_parts",
    "rmse_before",
    "rmse_after",
    "unexplained",
    "evidence",
)


@dataclass(frozen=True)
class Job:
    """One set: a case by name, seed and noise over full scale."""

    case: str
    seed: int
    noise: float
    revision: str

    @property
    def key(self) -> str:
        """Its name in the store."""
        return key_of(self.case, self.seed, self.noise, self.revision)


def chosen(rows: list[str], only: list[str]) -> list[Case]:
    """Cases of some rows (all if none), whose name holds one of the words (all if none)."""
    return [
        case
        for case in all_cases()
        if (not rows or case.row in rows) and (not only or any(word in case.name for word in only))
    ]


def jobs_of(cases: list[Case], per_case: int, revision: str, noises: list[float]) -> list[Job]:
    """Sets in an order that serves all rows alike when it is cut short."""
    made = [
        (seed, (7 * place + 11 * level) % 97, Job(case.name, seed, noise, revision))
        for place, case in enumerate(cases)
        for level, noise in enumerate(case.noises)
        if not noises or noise in noises
        for seed in range(per_case)
    ]
    return [job for _, _, job in sorted(made, key=lambda entry: entry[:2])]


def run_job(job: Job) -> dict[str, Any]:
    """Make the set, diagnose it, and put together what scoring needs."""
    case = next(case for case in all_cases() if case.name == job.case)
    record: dict[str, Any] = {
        "key": job.key,
        "case": case.name,
        "row": case.row,
        "experiment": case.experiment,
        "seed": job.seed,
        "noise": job.noise,
        "revision": job.revision,
        "expected": {
            "verdict": case.expected.verdict,
            "names": [sorted(names) for names in case.expected.names],
            "tied": sorted(case.expected.tied),
        },
    }
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
        truth = case.make(Path(folder), job.seed, job.noise)
        record |= {"truth": truth, "visible": not case.hidden or visible(truth)}
        if record["visible"] and case.row == "plan":
            record |= _timed(lambda: answers(case, Path(folder), job.seed, job.noise))
        elif record["visible"]:
            record |= _timed(lambda: {"answer": _kept(diagnosis_of(Path(folder), job.seed))})
    return record


def _kept(answer: dict[str, Any]) -> dict[str, Any]:
    return {name: answer.get(name) for name in KEPT}


def _timed(work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What the lab says and the seconds it took, or how it failed."""
    started = time.perf_counter()
    try:
        said = work()
    except Exception as reason:  # noqa: BLE001 (a set on which the lab fails is a miss)
        return {"error": repr(reason), "traceback": traceback.format_exc()}
    return said | {"seconds": round(time.perf_counter() - started, 2)}
