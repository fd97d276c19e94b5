"""The physics engine, imported without the line about its build that it prints to the standard
error. Import it from here alone.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


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


with _silent_error():
    import pybullet

__all__ = ["pybullet"]
