"""Lines on processes of this machine; a process that gets lost costs the line it was at, once.

Each process has an executor of its own: where one serves all, a lost process takes all their work
along. They are spawned, as PyBullet does not bear a fork.
"""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import groupby
from multiprocessing import get_context, parent_process
from threading import Thread

from grasp_strategies.sweep.line import Line, Record, lost_line, run_line

MOST_LOSSES = 3  # of one line; it may be what kills its worker


class Groups:
    """Lines by their settings: a worker stays with a group, as it builds a scene for each."""

    def __init__(self, lines: Sequence[Line]) -> None:
        self._groups = [deque(g) for _, g in groupby(lines, key=lambda line: line.settings)]
        self._of_worker: dict[int, deque[Line]] = {}

    def next(self, worker: int) -> Line | None:
        """The next line of a worker's group, of one that nobody has, or of the longest one."""
        group = self._of_worker.get(worker)
        if not group:
            left = [group for group in self._groups if group]
            if not left:
                return None
            taken = [id(group) for group in self._of_worker.values()]
            free = [group for group in left if id(group) not in taken]
            group = self._of_worker[worker] = free[0] if free else max(left, key=len)
        return group.popleft()


class Processes:
    """Workers on this machine, kept from one list of lines to the next; a context.

    Args:
        jobs: processes at a time; 0: lines are run in this one.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs, self._losses = jobs, Counter[str]()
        self._executors: list[ProcessPoolExecutor] = []

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_reason: object) -> None:
        for executor in self._executors:
            executor.shutdown(wait=False, cancel_futures=True)

    def run(self, lines: Sequence[Line]) -> Iterator[Record]:
        """Records of lines as they are done; the line of a lost worker is run again."""
        if self._jobs == 0:
            yield from map(run_line, lines)
            return
        self._groups = Groups(lines)
        self._running: dict[Future[Record], tuple[int, Line]] = {}
        while len(self._executors) < min(self._jobs, len(lines)):
            self._executors.append(_executor())
        for worker in range(len(self._executors)):
            self._start_next(worker)
        yield from self._records()

    def _records(self) -> Iterator[Record]:
        while self._running:
            for future in wait(self._running, return_when=FIRST_COMPLETED).done:
                worker, line = self._running.pop(future)
                record = self._outcome(future, worker, line)
                if record is not None:
                    self._start_next(worker)
                    yield record

    def _start_next(self, worker: int) -> None:
        line = self._groups.next(worker)
        if line is not None:
            self._start(worker, line)

    def _start(self, worker: int, line: Line) -> None:
        try:
            future = self._executors[worker].submit(run_line, line)
        except BrokenProcessPool:  # lost while it had nothing to do
            self._replace(worker)
            future = self._executors[worker].submit(run_line, line)
        self._running[future] = (worker, line)

    def _replace(self, worker: int) -> None:
        self._executors[worker].shutdown(wait=False)
        self._executors[worker] = _executor()

    def _outcome(self, future: Future[Record], worker: int, line: Line) -> Record | None:
        """The record of a line, or None when it runs again as its worker was lost."""
        try:
            return future.result()
        except BrokenProcessPool:
            self._replace(worker)
            self._losses[line.key] += 1
            if self._losses[line.key] < MOST_LOSSES:
                self._start(worker, line)
                return None
            return lost_line(line, MOST_LOSSES)


def _executor() -> ProcessPoolExecutor:
    for library in ("OMP", "OPENBLAS", "MKL"):  # one thread a worker, before it loads numpy
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_end_with_parent)


def _end_with_parent() -> None:
    """Without it, a worker whose sweep was killed would wait for work for ever."""
    Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
