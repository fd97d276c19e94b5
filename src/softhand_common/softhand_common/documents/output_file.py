"""Writes results: each file completely or not at all, and over an earlier one only on request.

Every result of the suite is written by this module. An existing file keeps its content until the
new one is complete on the disk.
"""

from __future__ import annotations

import errno
import json
import os
import secrets
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

STREAMS = ("/dev/stdout", "/dev/stderr", "/dev/fd/")
PICTURES = (".png", ".pdf", ".svg")  # what matplotlib writes without more libraries


def check_new(path: Path, force: bool, suffixes: tuple[str, ...] = ()) -> None:
    """Raise ValueError where no result can be written: a folder, an existing file (unless `force`),
    or a path that does not end in one of `suffixes`, if there are any.

    Call it before the computation whose result is to be written.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(
            f"{path}: expected a file with the suffix {' or '.join(suffixes)}, got "
            f"{path.suffix or 'none'}"
        )
    if path.is_dir():
        raise ValueError(f"{path}: expected the name of a file, got a folder")
    if path.exists() and not force:
        raise ValueError(f"{path}: expected a new file, got one that exists; --force overwrites it")


class UnwritableFile(ValueError):
    """A file cannot be written, for example on a full disk; an earlier file is left unchanged."""

    def __init__(self, path: Path, reason: Exception) -> None:
        got = getattr(reason, "strerror", None) or reason
        super().__init__(f"{path}: expected a place to write to, got {got}")


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Turn an OSError of the block into UnwritableFile, whose message names `path`."""
    try:
        yield
    except (OSError, RuntimeError) as reason:  # pathlib raises the latter for a loop of links
        if isinstance(reason, RuntimeError) and "loop" not in str(reason):
            raise
        raise UnwritableFile(path, reason) from reason


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give the path of a temporary file in the folder of `path`, with the same suffix. When the
    block ends it replaces `path`; if the block raises it is removed and `path` stays unchanged.

    Missing folders are created. The path of a device or pipe, such as /dev/stdout, is given itself.

    Raises UnwritableFile when the file cannot be written.
    """
    with ExitStack() as files:
        written = _Written(path, files)
        with named(path):
            yield written.place
            written.complete()
            written.take_place()


class _Written:
    """A file that is written beside the one whose place it takes; `files` removes it at the end."""

    def __init__(self, path: Path, files: ExitStack) -> None:
        self._target: Path | None = None
        with named(path):
            device = path.exists() and not (path.is_file() or path.is_dir())
            if device or str(path).startswith(STREAMS):
                self.place = path
                return
            self._target = target = path.resolve()  # a link keeps pointing to its file
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.exists() and not os.access(target, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else 0o666
            # a name that nobody can foresee, and a file that was not there before
            short = os.fsencode(target.stem)[:200].decode(errors="ignore")
            self.place = target.with_name(f".{short}.{secrets.token_hex(8)}{target.suffix}")
            opened = os.open(self.place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
            files.callback(self.place.unlink, missing_ok=True)
            try:
                if target.exists():
                    os.fchmod(opened, mode)  # the umask may have taken some of it
            finally:
                os.close(opened)

    def complete(self) -> None:
        """Write buffered content of the file to the disk."""
        if self._target is not None:
            _synchronise(self.place)

    def take_place(self) -> None:
        """Replace the earlier file by this one."""
        if self._target is not None:
            self.place.replace(self._target)
            _synchronise(self._target.parent)


def _synchronise(path: Path) -> None:
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def write_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together, text as UTF-8; earlier files are replaced only when all
    new ones are complete. Raises UnwritableFile for a file that cannot be written.
    """
    with ExitStack() as files:
        written = {path: _Written(path, files) for path in contents}
        for path, content in contents.items():
            with named(path):
                data = content.encode() if isinstance(content, str) else content
                written[path].place.write_bytes(data)
                written[path].complete()
        for path, file in written.items():
            with named(path):
                file.take_place()


def write_file(path: Path, content: str | bytes) -> None:
    """Write or replace one file, text as UTF-8; raises UnwritableFile when that fails."""
    write_files({path: content})


def write_new(path: Path, text: str, force: bool = False) -> None:
    """Write a text file; raises ValueError when it exists (unless `force`) or cannot be written."""
    check_new(path, force)
    write_file(path, text)


def save_figure(figure: Any, path: Path, **options: Any) -> None:
    """Write or replace a picture of a matplotlib figure.

    Args:
        figure: the matplotlib figure.
        path: the file to write; its suffix chooses the format.
        options: keywords of `Figure.savefig`, such as `dpi`.

    Raises:
        UnwritableFile: the file cannot be written.
    """
    with written_whole(path) as file:
        figure.savefig(file, **options)


def write_json(path: Path, content: dict[str, Any], force: bool = False) -> None:
    """Write a JSON file; numbers that are not finite become null. Raises as `write_new` does."""
    write_new(path, json_text(content), force)


def json_text(content: dict[str, Any]) -> str:
    """The text that `write_json` writes."""
    return json.dumps(plain(content), indent=1, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """The value with arrays as lists, numpy numbers as Python's, and None for NaN and infinity.

    >>> plain({"a": np.array([1.0, np.nan])})
    {'a': [1.0, None]}
    """
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
