"""Sets in several processes, one thread each."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any

from bench.lab.work import Job, run_job


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
