"""Run the benchmark of the lab, print its table and write out/bench/bench-lab.json.

Sets are diagnosed in two processes; each finished one is kept in out/bench/bench-lab.jsonl under
the revision of the code, so a second run goes on where the first was stopped.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any

from bench.kept import append, read
from bench.lab import store
from bench.lab.speed import measure_speed
from bench.lab.table import TARGETS, misses_of, notes_of, rows_of, text_of
from bench.lab.work import Job, chosen, jobs_of, run_job

WORKERS = 2


def options(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench.lab", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--rows", nargs="+", default=[], choices=[*TARGETS, "speed"], help="default: all")
    add("--per-case", type=int, default=1, metavar="N", help="seeds a case and noise level")
    add("--only", nargs="+", default=[], metavar="WORD", help="cases whose name holds a word")
    add("--noise", nargs="+", type=float, default=[], help="noise levels over full scale")
    add("--limit-minutes", type=float, default=120.0, help="start no further set after that")
    add("--fresh", action="store_true", help="diagnose again what is there already")
    add("--misses", action="store_true", help="list what was named instead")
    add("--revision", default=None, help="label of the code (default: a digest of the sources)")
    add("--workers", type=int, default=WORKERS)
    return parser.parse_args(arguments)


def finished(jobs: list[Job], workers: int, until: float) -> Iterator[dict[str, Any]]:
    """Records of sets as they are done; none is started after `until` [s, monotonic]."""
    context = multiprocessing.get_context("spawn")
    waiting = iter(jobs)
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        running: set[Future[dict[str, Any]]] = set()
        while True:
            while len(running) < 2 * workers and time.monotonic() < until:
                job = next(waiting, None)
                if job is None:
                    break
                running.add(pool.submit(run_job, job))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            yield from (future.result() for future in done)


def main(arguments: list[str] | None = None) -> int:
    """Diagnose what is missing, print, write."""
    chose = options(arguments)
    revision = chose.revision or store.revision_of_the_code()
    cases = chosen([row for row in chose.rows if row != "speed"], chose.only)
    if chose.rows == ["speed"]:
        cases = []
    jobs = jobs_of(cases, chose.per_case, revision, chose.noise)
    kept = {} if chose.fresh else read(store.LINES)
    open_jobs = [job for job in jobs if job.key not in kept]
    print(f"bench.lab: {len(jobs)} sets, {len(open_jobs)} to do, revision {revision}", flush=True)
    until = time.monotonic() + 60 * chose.limit_minutes
    for number, record in enumerate(finished(open_jobs, chose.workers, until), 1):
        append(record, store.LINES)
        kept[record["key"]] = record
        _progress(number, len(open_jobs), record)
    records = [kept[job.key] for job in jobs if job.key in kept]
    speed = measure_speed() if (not chose.rows and not chose.only) or "speed" in chose.rows else []
    _report(records, speed, revision, len(jobs), chose.misses)
    return 0


def _progress(number: int, total: int, record: dict[str, Any]) -> None:
    if number % 10 == 0 or number == total:
        print(f"bench.lab: {number}/{total} {record['case']}", file=sys.stderr, flush=True)


def _report(
    records: list[dict[str, Any]],
    speed: list[dict[str, Any]],
    revision: str,
    total: int,
    with_misses: bool,
) -> None:
    rows, notes, misses = rows_of(records), notes_of(records), misses_of(records)
    print(text_of(rows))
    notes += [f"{s['name']}: {s['seconds']:.1f} s (target {s['target']:g} s)" for s in speed]
    print("\n".join(notes))
    if len(records) < total:
        print(f"bench.lab: {total - len(records)} sets not done yet; run it again to go on")
    if with_misses:
        print("\n".join(["bench.lab: misses", *misses]))
    store.OUT.mkdir(parents=True, exist_ok=True)
    document = {"revision": revision, "sets": len(records), "rows": rows, "speed": speed}
    document |= {"notes": notes, "misses": misses}
    path = store.OUT / "bench-lab.json"
    path.write_text(json.dumps(document, indent=2) + "\n")
    print(f"bench.lab: written to {path}")


if __name__ == "__main__":
    sys.exit(main())
