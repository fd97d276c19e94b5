"""Run the benchmark of the pneumatic box, print its table, write out/bench/bench-pneumatics.json.

Each seed is another box with calibrations of its own. Two processes share what does not measure
time; the rest comes after them, alone. Exit status 1 if something could not be measured; a target
that is missed shows in the table only.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import traceback
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from bench.pneumatics.figures import ALONE, GROUPS, PARALLEL
from bench.pneumatics.measure import Size, measure
from bench.pneumatics.table import rows_of, text_of

OUT = Path("out/bench")
WORKERS = 2
Job = tuple[str, int]


def options(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="bench.pneumatics", description="Measure the pneumatic box."
    )
    add = parser.add_argument
    add("--seeds", type=int, default=5, metavar="N", help="boxes, numbered from 0 (default: 5)")
    add("--rows", nargs="+", default=list(GROUPS), choices=list(GROUPS), help="default: all")
    add("--workers", type=int, default=WORKERS, help=f"processes (default: {WORKERS})")
    add("--small", action="store_true", help="few pulses and short sines, to try it out")
    return parser.parse_args(arguments)


def results(
    jobs: Sequence[Job], size: Size, workers: int
) -> Iterator[tuple[Job, list[float] | None]]:
    """Jobs as they are done, with None for one that failed."""
    shared = [job for job in jobs if job[0] in PARALLEL]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        running = {pool.submit(measure, *job, size): job for job in shared}
        for future in as_completed(running):
            error = future.exception()
            if error is not None:
                traceback.print_exception(error)
            yield running[future], None if error else future.result()
    for job in [job for job in jobs if job[0] in ALONE]:
        try:
            yield job, measure(*job, size)
        except Exception:  # noqa: BLE001 (one broken figure must not hide the others)
            traceback.print_exc()
            yield job, None


def main(arguments: list[str] | None = None) -> int:
    """Measure, print, write."""
    chose = options(arguments)
    size = Size(tests=60, channels=2, duration=6.0, watched=2.0, runs=1) if chose.small else Size()
    jobs = [(group, seed) for seed in range(chose.seeds) for group in chose.rows]
    values, failed = {}, []
    for number, (job, found) in enumerate(results(jobs, size, chose.workers), 1):
        print(f"bench.pneumatics: {number}/{len(jobs)} {job[0]}, seed {job[1]}", file=sys.stderr)
        if found is None:
            failed.append(job)
        else:
            values[job] = found
    rows = rows_of(chose.rows, values)
    print(text_of(rows))
    OUT.mkdir(parents=True, exist_ok=True)
    path = OUT / "bench-pneumatics.json"
    document = {"seeds": chose.seeds, "small": chose.small, "rows": rows, "failed": failed}
    path.write_text(json.dumps(document, indent=2) + "\n")
    print(f"bench.pneumatics: written to {path}")
    for group, seed in failed:
        print(f"bench.pneumatics: {group}, seed {seed} could not be measured", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
