"""One mutant in a process of its own: the tests of its module, until one of them fails.

The process is forked from one that has imported the libraries already, and takes the mutated source
in place of that of the file when the module is imported; no file is changed.
"""

from __future__ import annotations

import gc
import importlib
import multiprocessing
import os
import resource
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

import pytest

from bench.mutants.modules import Row

ROOT = Path(__file__).parents[2]
LIBRARIES = (
    "hypothesis",
    "numba",
    "scipy.fft",
    "scipy.integrate",
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.spatial.transform",
    "scipy.stats",
    "yaml",
)
# what costs more than the tests of one module: rewritten assertions, a last sweep of the memory
LEFT_OUT = ("cacheprovider", "unraisableexception", "threadexception")
OPTIONS = (
    "-x",
    "-q",
    "--assert=plain",
    *(part for name in LEFT_OUT for part in ("-p", f"no:{name}")),
)
WALL_SECONDS = 900  # a mutant that waits for nothing ends too


def load_libraries() -> None:
    """Import what all tests need, before the processes part."""
    for name in LIBRARIES:
        importlib.import_module(name)
    gc.freeze()


def passes(row: Row, source: str | None, seconds: int) -> tuple[bool, float]:
    """Whether the tests of a row pass, and the processor time [s] that took.

    Args:
        row: of the module.
        source: that stands for the module's own, None for that as it is.
        seconds: of processor time after which tests count as failed [s].
    """
    before = _processor_time()
    process = multiprocessing.get_context("fork").Process(target=_test, args=(row, source, seconds))
    process.start()
    process.join(WALL_SECONDS)
    if process.is_alive():
        process.kill()
        process.join()
    return process.exitcode == 0, _processor_time() - before


def _processor_time() -> float:
    """Of all processes that have ended so far [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _test(row: Row, source: str | None, seconds: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    if row.module in sys.modules:
        raise RuntimeError(f"{row.module} was imported before it could be mutated")
    if source is not None:
        _put_in_place(row.module, source)
    if row.interpreted:
        _interpret(row.module.split(".")[0])
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        status = pytest.main([*OPTIONS, *(str(ROOT / test) for test in row.tests)])
    sys.exit(int(status))


def _put_in_place(module: str, source: str) -> None:
    """Let the import of a module take this source."""
    get_code = SourceFileLoader.get_code

    def mutated(loader: SourceFileLoader, name: str) -> CodeType | None:
        if name == module:
            return compile(source, loader.path, "exec")
        return get_code(loader, name)

    SourceFileLoader.get_code = mutated  # type: ignore[method-assign]


def _interpret(package: str) -> None:
    """Let the kernels of a package run as Python: what is compiled lies in a cache, unmutated."""
    kernels = importlib.import_module("softhand_common.numerics.compiled")
    compiled = kernels.compiled

    def chosen(function: Any) -> Callable[..., Any]:
        if function.__module__.split(".")[0] != package:
            return compiled(function)
        function.py_func = function  # as a compiled one has it
        return function

    kernels.compiled = chosen
