"""The sets of the benchmark and the diagnosis of one of them."""

from __future__ import annotations

import multiprocessing
import signal
import tempfile
import threading
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from bench.hidden.case import Case, visible
from bench.hidden.cases import all_cases
from bench.hidden.reserved import is_reserved
from bench.lab import learn
from bench.lab.adapter import diagnosis_of
from bench.lab.learn import Hidden
from bench.lab.planning import answers
from bench.lab.store import key_of

SMALLER, FEWEST = 8, 3  # part of the sets, and at least so many a row
KEPT = (
    "verdict",
    "verdict_mended",
    "effects",
    "tied",
    "calibration",
    "noise_floor",
    "noise_floor_parts",
    "rmse_before",
    "rmse_after",
    "unexplained",
    "helps",
    "confidence",
    "guess",
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


def chosen(rows: list[str], only: list[str], development: bool = False) -> list[Case | Hidden]:
    """Cases of some rows (all if none), whose name holds one of the words (all if none).

    development: without those that are kept for blind runs.
    """
    return [
        case
        for case in [*all_cases(), *learn.CASES]
        if (not rows or case.row in rows)
        and (not only or any(word in case.name for word in only))
        and not (development and is_reserved(case.name))
    ]


def jobs_of(
    cases: Sequence[Case | Hidden],
    per_case: int,
    revision: str,
    noises: list[float],
    first_seed: int = 0,
) -> list[Job]:
    """Sets in an order that serves all rows alike when it is cut short."""
    made = [
        (
            number,
            (7 * place + 11 * level) % 97,
            Job(case.name, first_seed + number, noise, revision),
        )
        for place, case in enumerate(cases)
        for level, noise in enumerate(case.noises)
        if not noises or noise in noises
        for number in range(per_case)
    ]
    return [job for _, _, job in sorted(made, key=lambda entry: entry[:2])]


def smaller(jobs: list[Job], seed: int) -> list[Job]:
    """A few sets of every row, drawn by a seed, in the same order."""
    rows = {case.name: case.row for case in [*all_cases(), *learn.CASES]}
    of_row: dict[str, list[Job]] = defaultdict(list)
    for job in jobs:
        of_row[rows[job.case]].append(job)
    random = Random(seed)
    kept = {
        job.key
        for mine in of_row.values()
        for job in random.sample(mine, min(len(mine), max(FEWEST, len(mine) // SMALLER)))
    }
    return [job for job in jobs if job.key in kept]


def finished(jobs: list[Job], workers: int, until: float) -> Iterator[dict[str, Any]]:
    """Records of sets as they are done; none is started after `until` [s, monotonic], or after a
    SIGTERM.
    """
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    context = multiprocessing.get_context("spawn")
    waiting = iter(jobs)
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        running: set[Future[dict[str, Any]]] = set()
        while True:
            while len(running) < 2 * workers and time.monotonic() < until and not ended.is_set():
                job = next(waiting, None)
                if job is None:
                    break
                running.add(pool.submit(run_job, job))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            yield from (future.result() for future in done)


def run_job(job: Job) -> dict[str, Any]:
    """Make the set, diagnose it, and put together what scoring needs."""
    for hidden in learn.CASES:
        if hidden.name == job.case:
            return {"key": job.key} | _learned(hidden, job)
    case = next(case for case in all_cases() if case.name == job.case)
    record: dict[str, Any] = {
        "key": job.key,
        "case": case.name,
        "row": case.row,
        "ratio": case.ratio,
        "experiment": case.experiment,
        "seed": job.seed,
        "noise": job.noise,
        "revision": job.revision,
        "expected": {
            "verdict": case.expected.verdict,
            "names": [sorted(names) for names in case.expected.names],
            "tied": sorted(case.expected.tied),
            "besides": sorted(case.expected.besides),
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


def _learned(hidden: Hidden, job: Job) -> dict[str, Any]:
    """What `learn` makes of a set; it has no single verdict."""
    made = _timed(lambda: learn.record_of(hidden, job.seed))
    about = {"row": hidden.row, "experiment": hidden.experiment, "seed": job.seed}
    return {"case": hidden.name, **about, "noise": job.noise, "visible": True} | made


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
