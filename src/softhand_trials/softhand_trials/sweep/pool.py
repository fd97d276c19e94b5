"""Tasks on processes of this machine. When a process dies, its task is run again on a new one.

Each process has an executor of its own, since an executor with several processes fails all its
tasks when one of them dies. Processes are spawned, as PyBullet cannot be forked.
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

from softhand_trials.sweep.task import Record, Task, lost_task, run_task

ATTEMPTS = 3  # of a task during which its worker is lost; the task may be the cause


class Groups:
    """Tasks by their settings: a worker stays with one group, as it builds a scene for each."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self._groups = [deque(g) for _, g in groupby(tasks, key=lambda task: task.settings)]
        self._of_worker: dict[int, deque[Task]] = {}

    def next(self, worker: int) -> Task | None:
        """A worker's next task: from its group, else from a group without a worker, else from the
        longest group; None when no task is left.
        """
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
    """Workers on this machine, kept from one list of tasks to the next; a context manager.

    Args:
        jobs: number of processes; 0: run in this process.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs, self._losses = jobs, Counter[str]()
        self._executors: list[ProcessPoolExecutor] = []

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_reason: object) -> None:
        for executor in self._executors:
            executor.shutdown(wait=False, cancel_futures=True)

    def run(self, tasks: Sequence[Task]) -> Iterator[Record]:
        """Records of tasks as they are done; the task of a lost worker is run again."""
        if self._jobs == 0:
            yield from map(run_task, tasks)
            return
        self._groups = Groups(tasks)
        self._running: dict[Future[Record], tuple[int, Task]] = {}
        while len(self._executors) < min(self._jobs, len(tasks)):
            self._executors.append(_executor())
        for worker in range(len(self._executors)):
            self._start_next(worker)
        yield from self._records()

    def _records(self) -> Iterator[Record]:
        while self._running:
            for future in wait(self._running, return_when=FIRST_COMPLETED).done:
                worker, task = self._running.pop(future)
                record = self._outcome(future, worker, task)
                if record is not None:
                    self._start_next(worker)
                    yield record

    def _start_next(self, worker: int) -> None:
        task = self._groups.next(worker)
        if task is not None:
            self._start(worker, task)

    def _start(self, worker: int, task: Task) -> None:
        try:
            future = self._executors[worker].submit(run_task, task)
        except BrokenProcessPool:  # lost while it had nothing to do
            self._replace(worker)
            future = self._executors[worker].submit(run_task, task)
        self._running[future] = (worker, task)

    def _replace(self, worker: int) -> None:
        self._executors[worker].shutdown(wait=False)
        self._executors[worker] = _executor()

    def _outcome(self, future: Future[Record], worker: int, task: Task) -> Record | None:
        """The record of a task, or None when it runs again as its worker was lost."""
        try:
            return future.result()
        except BrokenProcessPool:
            self._replace(worker)
            self._losses[task.key] += 1
            if self._losses[task.key] < ATTEMPTS:
                self._start(worker, task)
                return None
            return lost_task(task, ATTEMPTS)


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
