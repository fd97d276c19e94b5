"""One piece of work whose result is a line: what a sweep's trials and a search's evaluations share.

A line is plain data, so that processes and machines can be handed it, and its result a pure
function of it.
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
LIBRARIES = ("pybullet", "numpy", "numba")
DIGITS = 16  # of a digest, in hexadecimal

Record = dict[str, Any]


class Line(Protocol):
    """Work with a key; a worker builds what lines of equal settings share once."""

    @property
    def key(self) -> str:
        """Name of the line in the results."""

    @property
    def settings(self) -> Any:
        """What is built for it, comparable."""

    @property
    def digest(self) -> str:
        """Hash of all that the result depends on but the code."""

    def describe(self) -> Record:
        """What the line of the result says of the work: key, digest and more."""

    def result(self) -> Record:
        """Do the work; plain data for JSON."""


def run_line(line: Line) -> Record:
    """Do a line's work; its result as plain data for JSON. Work that raises is a record with the
    `error` and without a result.
    """
    begin, cpu = time.perf_counter(), time.process_time()
    record = line.describe()
    try:
        record |= line.result()
    except Exception as error:  # noqa: BLE001 (the others go on, and the line says what it was)
        record["error"] = f"{type(error).__name__}: {error}"
    times = {"wall_time": time.perf_counter() - begin, "cpu_time": time.process_time() - cpu}
    return record | times | {"versions": versions()}


def lost_line(line: Line, losses: int) -> Record:
    """The record of a line whose worker got lost each time."""
    return line.describe() | {"error": f"its worker was lost {losses} times"}


@lru_cache(maxsize=1)
def versions() -> Record:
    """What runs here: packages with a digest of their code and data, libraries, the machine's
    architecture.
    """
    found = {name: metadata.version(name) for name in (*PACKAGES, *LIBRARIES)}
    return found | {"code": _code_digest(), "machine": platform.machine()}


def _code_digest() -> str:
    code = hashlib.sha256()
    for package in PACKAGES:
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.suffix in (".py", ".yaml"):
                code.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return code.hexdigest()[:DIGITS]
