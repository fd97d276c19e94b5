"""PyBullet, loaded when it is first used, without the build message that it prints to the standard
error. Import it only from here, so that all other modules also run where it is not installed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from typing import Any

NO_PYBULLET = (
    "pybullet: expected it to be installed, got none; `pip install pybullet`, or take engine mujoco"
)


class NotInstalled(RuntimeError):
    """The engine asked for is not installed; the message says what to install or to take
    instead.
    """


@contextmanager
def _silent_error() -> Iterator[None]:
    """Drop what C code prints to the standard error."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


class _OnDemand:
    """The module, whose names are taken over at the first use of one of them."""

    def __getattr__(self, name: str) -> Any:
        try:
            with _silent_error():
                module = import_module("pybullet")
        except ImportError as reason:
            raise NotInstalled(NO_PYBULLET) from reason
        vars(self).update(vars(module))
        return getattr(module, name)


def is_installed(name: str = "pybullet") -> bool:
    """Whether a module, by default PyBullet, can be imported."""
    try:
        return find_spec(name) is not None
    except ValueError:  # of a name that is None in sys.modules
        return False


def failures() -> tuple[type[Exception], ...]:
    """Types of the errors that an engine raises without a display, or when its window was
    closed.
    """
    return (RuntimeError, pybullet.error) if is_installed() else (RuntimeError,)


pybullet: Any = _OnDemand()

__all__ = ["NO_PYBULLET", "NotInstalled", "failures", "is_installed", "pybullet"]
