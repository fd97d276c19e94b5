"""Lines on the workers of a Dask cluster, in batches of equal settings.

`distributed` is an option of this package (`pip install grasp_strategies[dask]`). Dask runs the
batch of a lost worker again on another one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from threading import Lock
from typing import Any

from grasp_strategies.sweep.line import Line, Record, lost_line, run_line

BATCHES = 4  # a worker at least, so that none idles long at the end
LARGEST_BATCH = 16  # lines; what a lost worker or scheduler can cost
TIME_OUT = 30.0  # [s] for scheduler and first worker
ONE_AT_A_TIME = Lock()  # of the threads of a worker, as they share its scene


def run_batch(lines: Sequence[Line]) -> list[Record]:
    """Records of lines, run one after the other."""
    with ONE_AT_A_TIME:
        return [run_line(line) for line in lines]


def batches(lines: Sequence[Line], workers: int) -> list[list[Line]]:
    """Lines of the same settings that follow each other, so many that every worker gets some."""
    size = max(1, min(LARGEST_BATCH, len(lines) // (BATCHES * workers)))
    groups = [list(group) for _, group in groupby(lines, key=lambda line: line.settings)]
    return [group[k : k + size] for group in groups for k in range(0, len(group), size)]


class Cluster:
    """The workers of a scheduler; a context, which connects when there is something to run.

    `run` raises ValueError without `distributed`, ConnectionError when there are no scheduler and
    worker, or when the scheduler gets lost.
    """

    def __init__(self, scheduler: str) -> None:
        self._scheduler = scheduler
        self._connected: Any = None

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_reason: object) -> None:
        if self._connected is not None:
            self._connected.close()

    def run(self, lines: Sequence[Line]) -> Iterator[Record]:
        """Records of lines as their batches are done."""
        if not lines:
            return
        if self._connected is None:
            self._connected = _client(self._scheduler)
        try:
            self._connected.wait_for_workers(1, timeout=TIME_OUT)
            yield from _results(self._connected, lines)
        except (TimeoutError, OSError) as reason:
            raise ConnectionError(
                f"{self._scheduler}: expected a Dask scheduler with workers: {reason}"
            ) from reason


def _client(scheduler: str) -> Any:
    try:
        from distributed import Client
    except ImportError as reason:
        raise ValueError(
            "scheduler: expected the package distributed, got an environment without it; "
            "pip install grasp_strategies[dask]"
        ) from reason
    try:
        return Client(scheduler, timeout=TIME_OUT, set_as_default=False)
    except (OSError, TimeoutError) as reason:
        raise ConnectionError(f"{scheduler}: expected a Dask scheduler: {reason}") from reason


def _results(client: Any, lines: Sequence[Line]) -> Iterator[Record]:
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    parts = batches(lines, len(client.scheduler_info(n_workers=-1)["workers"]))
    running = dict(zip(client.map(run_batch, parts, pure=False), parts, strict=True))
    finished = as_completed(running, loop=client.loop)
    for future in finished:
        batch = running.pop(future)
        if future.status == "finished":
            yield from future.result()
        elif future.status == "cancelled":
            raise ConnectionError("the scheduler was lost; what is done is kept")
        elif not isinstance(future.exception(), KilledWorker):
            future.result()  # raises what went wrong
        elif len(batch) == 1:
            yield lost_line(batch[0], int(future.exception().allowed_failures) + 1)
        else:  # one of them kills its worker
            again = client.map(run_batch, [[line] for line in batch], pure=False)
            running |= {single: [line] for single, line in zip(again, batch, strict=True)}
            finished.update(again)
