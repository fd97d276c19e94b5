"""Run the blind benchmark of the lab, print its table and write out/bench/bench-lab.json.

Every run draws a seed that no threshold has seen, and prints it; `--seed N` does the same sets
again. Sets are diagnosed in two processes; each finished one is kept in out/bench/bench-lab.jsonl
under the revision of the code, so a run that was stopped goes on. `--development` takes the seeds
that thresholds were set with: for finding out, not for results.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

from bench.kept import append, read
from bench.lab import store
from bench.lab.notes import misses_of, notes_of
from bench.lab.real import measure_real, summary
from bench.lab.speed import measure_speed
from bench.lab.speed import text_of as speed_text
from bench.lab.table import ROWS, rows_of, text_of
from bench.lab.work import Job, chosen, finished, jobs_of, smaller

WORKERS = 2
OTHERS = ("speed", "real")  # rows that are of no hidden effect
SELECTING = ("rows", "only", "noise", "per_case", "small")
WARNING = "development seeds: thresholds were set with them, these figures are no results"


def options(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="bench.lab", description=__doc__.splitlines()[0])
    add = parser.add_argument
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--seed", type=int, metavar="N", help="of a run to do again, from 1")
    which.add_argument("--development", action="store_true", help="seeds used while developing")
    add("--small", action="store_true", help="an eighth of the sets of every row")
    add("--rows", nargs="+", default=[], choices=[*ROWS, *OTHERS], help="default: all")
    add("--per-case", type=int, default=1, metavar="N", help="sets a case and noise level")
    add("--only", nargs="+", default=[], metavar="WORD", help="cases whose name holds a word")
    add("--noise", nargs="+", type=float, default=[], help="noise levels over full scale")
    add("--limit-minutes", type=float, default=240.0, help="start no further set after that")
    add("--misses", action="store_true", help="list what was named instead")
    add("--revision", default=None, help="label of the code (default: a digest of the sources)")
    add("--workers", type=int, default=WORKERS)
    found = parser.parse_args(arguments)
    if found.seed is not None and found.seed < 1:
        parser.error(f"--seed {found.seed}: expected 1 or more")
    return found


def main(arguments: list[str] | None = None) -> int:
    """Diagnose what is missing, print, write."""
    chose = options(arguments)
    revision = chose.revision or store.revision_of_the_code()
    selection = {name: getattr(chose, name) for name in SELECTING}
    seed = _seed(chose, selection | {"revision": revision})
    jobs = _jobs(chose, seed, revision)
    kept = read(store.LINES)
    open_jobs = [job for job in jobs if job.key not in kept]
    print(f"bench.lab: seed {seed}, {len(jobs)} sets, {len(open_jobs)} to do, revision {revision}")
    until = time.monotonic() + 60 * chose.limit_minutes
    for number, record in enumerate(finished(open_jobs, chose.workers, until), 1):
        append(record, store.LINES)
        kept[record["key"]] = record
        _progress(number, len(open_jobs), record)
    records = [kept[job.key] for job in jobs if job.key in kept]
    every = not (chose.rows or chose.only)
    speed = measure_speed() if "speed" in chose.rows or every else []
    real = measure_real([]) if "real" in chose.rows or every else None
    head = {"seed": seed, "revision": revision, "selection": selection, "planned": len(jobs)}
    _report(head, records, speed, real, chose.misses)
    if len(records) == len(jobs) and chose.seed is None and not chose.development:
        store.finish()
    return 0


def _seed(chose: argparse.Namespace, selected: dict[str, Any]) -> int:
    if chose.development:
        return store.DEVELOPMENT
    return chose.seed or store.seed_of_run(selected)


def _jobs(chose: argparse.Namespace, seed: int, revision: str) -> list[Job]:
    rows = [row for row in chose.rows if row not in OTHERS]
    cases = [] if chose.rows and not rows else chosen(rows, chose.only, chose.development)
    jobs = jobs_of(cases, chose.per_case, revision, chose.noise, store.first_seed(seed))
    return smaller(jobs, seed) if chose.small else jobs


def _progress(number: int, total: int, record: dict[str, Any]) -> None:
    if number % 10 == 0 or number == total:
        print(f"bench.lab: {number}/{total} {record['case']}", file=sys.stderr, flush=True)


def _report(
    head: dict[str, Any],
    records: list[dict[str, Any]],
    speed: list[dict[str, Any]],
    real: list[dict[str, Any]] | None,
    with_misses: bool,
) -> None:
    blind = head["seed"] != store.DEVELOPMENT
    rows, notes, misses = rows_of(records), notes_of(records), misses_of(records)
    notes += map(speed_text, speed)
    notes += [] if real is None else summary(real)
    notes += [] if blind else [WARNING]
    print("\n".join([text_of(rows), *notes]))
    if len(records) < head["planned"]:
        missing = head["planned"] - len(records)
        print(f"bench.lab: {missing} sets not done yet; run it again to go on")
    if with_misses:
        print("\n".join(["bench.lab: misses", *misses]))
    document = {**head, "sets": len(records), "rows": rows, "speed": speed, "real": real}
    document |= {"notes": notes, "misses": misses}
    store.OUT.mkdir(parents=True, exist_ok=True)
    path = store.OUT / ("bench-lab.json" if blind else "bench-lab-development.json")
    path.write_text(json.dumps(document, indent=2) + "\n")
    print(f"bench.lab: written to {path}")


if __name__ == "__main__":
    sys.exit(main())
