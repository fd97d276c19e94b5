"""Tasks on the workers of a Dask cluster, in batches of equal settings.

`distributed` is an option of this package (`pip install softhand_trials[dask]`). Dask runs the
batch of a lost worker again on another one. Tasks are sent as pickles: whoever can connect to a
scheduler or a worker can run code there. So the connection is encrypted and authenticated (TLS), or
does not leave this machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from ipaddress import ip_address
from itertools import groupby
from threading import Lock
from typing import Any
from urllib.parse import urlsplit

from softhand_trials.sweep.task import Record, Task, lost_task, run_task

BATCHES = 4  # a worker at least, so that none idles long at the end
LARGEST_BATCH = 16  # tasks; what a lost worker or scheduler can cost
TIME_OUT = 30.0  # [s] for scheduler and first worker
ONE_AT_A_TIME = Lock()  # of the threads of a worker, as they share its scene


def run_batch(tasks: Sequence[Task]) -> list[Record]:
    """Records of tasks, run one after the other."""
    with ONE_AT_A_TIME:
        return [run_task(task) for task in tasks]


def batches(tasks: Sequence[Task], workers: int) -> list[list[Task]]:
    """Batches of consecutive tasks with the same settings, enough of them that every worker gets
    some.
    """
    size = max(1, min(LARGEST_BATCH, len(tasks) // (BATCHES * workers)))
    groups = [list(group) for _, group in groupby(tasks, key=lambda task: task.settings)]
    return [group[k : k + size] for group in groups for k in range(0, len(group), size)]


class Cluster:
    """The workers of a Dask scheduler. A context manager, which connects when there is something to
    run.

    Raises ValueError for an address that `check_address` refuses. `run` raises ValueError without
    `distributed` or certificates, ConnectionError when there are no scheduler and worker, or when
    the scheduler gets lost.
    """

    def __init__(self, scheduler: str) -> None:
        check_address(scheduler)
        self._scheduler = scheduler
        self._connected: Any = None

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_reason: object) -> None:
        if self._connected is not None:
            self._connected.close()

    def run(self, tasks: Sequence[Task]) -> Iterator[Record]:
        """Records of tasks as their batches are done."""
        if not tasks:
            return
        if self._connected is None:
            self._connected = _client(self._scheduler)
        try:
            self._connected.wait_for_workers(1, timeout=TIME_OUT)
            yield from _results(self._connected, tasks)
        except (TimeoutError, OSError) as reason:
            raise ConnectionError(
                f"{self._scheduler}: expected a Dask scheduler with workers: {reason}"
            ) from reason


def check_address(scheduler: str) -> None:
    """Refuse a scheduler that is reached without TLS over a network.

    Raises:
        ValueError: the address is neither `tls://HOST:PORT`, nor `tcp://` with an address of this
            machine.
    """
    address = urlsplit(scheduler)
    if address.scheme == "tls" or (address.scheme == "tcp" and _is_loopback(address.hostname)):
        return
    raise ValueError(
        "scheduler: expected tls://HOST:PORT, or tcp://127.0.0.1:PORT on this machine or through "
        f"an SSH tunnel, got {scheduler}; without TLS, anyone on the network can run code on "
        "scheduler, workers and this machine (docs/use/cluster.md)"
    )


def _is_loopback(host: str | None) -> bool:
    """Of an address, or localhost; other names are not looked up."""
    try:
        return host == "localhost" or ip_address(host or "").is_loopback
    except ValueError:
        return False


def _client(scheduler: str) -> Any:
    try:
        from distributed import Client, Security
    except ImportError as reason:
        raise ValueError(
            "scheduler: expected the package distributed, got an environment without it; "
            "pip install softhand_trials[dask]"
        ) from reason
    security: Any = Security()  # as Dask is configured
    if not scheduler.startswith("tls:"):
        if security.require_encryption:
            raise ValueError(
                f"scheduler: expected tls://, as Dask's configuration demands, got {scheduler}"
            )
    elif not (security.tls_ca_file and security.tls_client_cert):
        raise ValueError(
            f"scheduler: expected ca-file and client certificate in Dask's configuration for "
            f"{scheduler}, got none (docs/use/cluster.md)"
        )
    try:
        return Client(scheduler, timeout=TIME_OUT, security=security, set_as_default=False)
    except (OSError, TimeoutError) as reason:
        raise ConnectionError(f"{scheduler}: expected a Dask scheduler: {reason}") from reason


def _results(client: Any, tasks: Sequence[Task]) -> Iterator[Record]:
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    parts = batches(tasks, len(client.scheduler_info(n_workers=-1)["workers"]))
    running = dict(zip(client.map(run_batch, parts, pure=False), parts, strict=True))
    finished = as_completed(running, loop=client.loop)
    for future in finished:
        batch = running.pop(future)
        if future.status == "finished":
            yield from future.result()
        elif future.status == "cancelled":
            raise ConnectionError("the scheduler was lost; finished results are kept")
        elif not isinstance(future.exception(), KilledWorker):
            future.result()  # raises what went wrong
        elif len(batch) == 1:
            yield lost_task(batch[0], int(future.exception().allowed_failures) + 1)
        else:  # one of them kills its worker
            again = client.map(run_batch, [[task] for task in batch], pure=False)
            running |= {single: [task] for single, task in zip(again, batch, strict=True)}
            finished.update(again)
