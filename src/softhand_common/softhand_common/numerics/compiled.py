"""Numerical kernels, compiled by numba and cached on disk until one of them changes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import event
from numba.core.dispatcher import Dispatcher

COMMON_PACKAGE = Path(__file__).parents[1]
COMPILING = "compiling the numerical kernels: about a minute, at the first start only"


def compiled(function: Callable[..., Any], *, allocates: bool = True) -> Any:
    """Decorator: compile a numerical kernel by numba and cache it on disk. A division by zero gives
    inf or nan, as in numpy.

    A cached kernel is compiled again when a kernel of its package, of this package, or one that it
    calls by name has changed. Numba by itself looks only at the file of the kernel and would keep
    using old versions of what it calls in other files. For a function in no package, the folder of
    its file is taken as the package. A kernel that was cached under another module name is compiled
    again, too, since numba would import it by that name.

    Args:
        function: the kernel.
        allocates: whether the kernel allocates arrays. If False, references to arrays are not
            counted, which is faster for a kernel that is called very often.
    """
    counting: dict[str, Any] = {"_nrt": allocates}  # of references; not in numba's type hints
    kernel: Any = njit(cache=True, fastmath=False, error_model="numpy", **counting)(function)
    kernel._cache.save_overload = _kept_if_possible(kernel._cache)
    kernel._cache._cache_file._load_index = _known_index(kernel._cache._cache_file)
    file, depth = Path(function.__code__.co_filename), function.__module__.count(".")
    if file.is_file():
        own = kernels_stamp(file.parents[max(0, depth - 1)], "**/*.py" if depth else "*.py")
        called = map(function.__globals__.get, function.__code__.co_names)
        stamps = sorted(_stamp(one) for one in called if isinstance(one, Dispatcher))
        parts = own, kernels_stamp(COMMON_PACKAGE), function.__module__, stamps
        kernel._cache._cache_file._source_stamp = sha256(repr(parts).encode()).hexdigest()
    return kernel


without_allocation = partial(compiled, allocates=False)


def _kept_if_possible(cache: Any) -> Callable[[Any, Any], None]:
    """Numba's function that keeps what was compiled, warning where there is no room for it."""
    keep = cache.save_overload

    def save(signature: Any, compiled_kernel: Any) -> None:
        try:
            keep(signature, compiled_kernel)
        except OSError as reason:
            _warn_of(str(reason.strerror), cache.cache_path)

    return save


def _known_index(cache_file: Any) -> Callable[[], dict[Any, str]]:
    """Numba's function that reads which kernels are kept; none where they are of types that have
    been moved or renamed since, at which it would raise before it sees that they are stale.
    """
    load = cache_file._load_index

    def known() -> dict[Any, str]:
        try:
            return dict(load())
        except (ImportError, AttributeError):
            return {}

    return known


_warned: set[str] = set()


def _warn_of(reason: str, folder: str) -> None:
    """Warn once that compiled kernels cannot be kept; there are dozens."""
    if reason not in _warned:
        _warned.add(reason)
        warnings.warn(
            f"{folder}: expected room for compiled kernels, got {reason}; they are not kept, and "
            "compiled again at the next start: make room, or set NUMBA_CACHE_DIR to another folder",
            stacklevel=3,
        )


def _stamp(kernel: Any) -> str:
    """The stamp by which numba's cache tells whether a kernel is current; "" without a cache."""
    return str(getattr(getattr(kernel._cache, "_cache_file", None), "_source_stamp", ""))


@cache
def kernels_stamp(folder: Path, pattern: str = "**/*.py") -> tuple[float, int]:
    """Time of the latest change [s] and total size [bytes] of the files with kernels in a folder.

    The pattern `**/*.py` includes subfolders, `*.py` does not.
    """
    files = (file for file in folder.glob(pattern) if b"@compiled" in file.read_bytes())
    stats = [file.stat() for file in files]
    return max((s.st_mtime for s in stats), default=0.0), sum(s.st_size for s in stats)


class _BeforeCompiling(event.Listener):
    """Calls `announce` before the first kernel is compiled."""

    def __init__(self, announce: Callable[[str], None]) -> None:
        self._announce, self._announced = announce, False

    def on_start(self, event: event.Event) -> None:
        """Called by numba before it compiles a kernel that is not in the cache."""
        if not self._announced:
            self._announced = True
            self._announce(COMPILING)

    def on_end(self, event: event.Event) -> None:
        """Called by numba after it has compiled a kernel."""


@contextmanager
def compilation_announced(announce: Callable[[str], None]) -> Iterator[None]:
    """Call `announce` with a sentence before the first kernel of the block is compiled, if any."""
    with event.install_listener("numba:compile", _BeforeCompiling(announce)):
        yield
