"""A task: the common interface of a trial of a sweep and an evaluation of a search.

A task is plain data, so that it can be sent to processes and machines. Its result depends on the
task alone, and is one record in the file of results.
"""

from __future__ import annotations

import hashlib
import platform
import time
from functools import lru_cache
from importlib import metadata, resources
from pathlib import Path
from typing import Any, Protocol

PACKAGES = ("grasp_strategies", "pneuflex_sim", "softhand_model")
LIBRARIES = ("pybullet", "mujoco-core", "numpy", "numba")
DIGEST_DIGITS = 16  # of a digest, in hexadecimal

Record = dict[str, Any]


class Task(Protocol):
    """Work with a key. A worker builds the settings once for all tasks that share them."""

    @property
    def key(self) -> str:
        """Name of the task, by which its record is found."""

    @property
    def settings(self) -> Any:
        """What a worker has to build for the task; can be compared for equality."""

    @property
    def digest(self) -> str:
        """Hash of all that the result depends on, without the code."""

    def describe(self) -> Record:
        """Description of the task in its record: key, digest and more."""

    def result(self) -> Record:
        """Do the work and return its result as plain data for JSON."""


def run_task(task: Task) -> Record:
    """Do a task's work and return its record as plain data for JSON. If the work raises, the record
    has the field `error` and no result.
    """
    begin, cpu = time.perf_counter(), time.process_time()
    record = task.describe()
    try:
        record |= task.result()
    except Exception as error:  # noqa: BLE001 (other tasks go on, and the record holds the error)
        record["error"] = f"{type(error).__name__}: {error}"
    times = {"wall_time": time.perf_counter() - begin, "cpu_time": time.process_time() - cpu}
    return record | times | {"versions": versions()}


def lost_task(task: Task, losses: int) -> Record:
    """The record of a task whose worker was lost at each of `losses` attempts."""
    return task.describe() | {"error": f"its worker was lost {losses} times"}


@lru_cache(maxsize=1)
def versions() -> Record:
    """Versions of the packages, with a digest of their code and data, and of libraries; the
    machine's architecture.
    """
    found = {name: _version(name) for name in (*PACKAGES, *LIBRARIES)}
    return found | {"code": _code_digest(), "machine": platform.machine()}


def _version(name: str) -> str:
    """Version of a package; empty for an engine that is not installed."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def _code_digest() -> str:
    code = hashlib.sha256()
    for package in PACKAGES:
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.suffix in (".py", ".yaml"):
                code.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return code.hexdigest()[:DIGEST_DIGITS]
