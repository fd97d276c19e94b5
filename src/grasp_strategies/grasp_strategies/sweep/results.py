"""The file of results: one line of JSON each, appended and flushed as soon as it is done."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from grasp_strategies.sweep.line import Line, Record

NAME = "results.jsonl"

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]


class Results:
    """The results in a folder, to go on with; a context.

    A last line that was torn off, as a killed process leaves it, is dropped, and its work done
    again. Raises ValueError when another process writes to the file, or when it holds results of
    others than `lines`.

    Args:
        folder: of the results.
        lines: all that there can be; None when they become known one after the other.
    """

    def __init__(self, folder: Path, lines: Sequence[Line] | None = None) -> None:
        self.path = folder / NAME
        folder.mkdir(parents=True, exist_ok=True)
        self._file = self.path.open("a+b")
        try:
            self._lock()
            self._drop_torn_line()
            self.records = {record["key"]: record for record in read_results(self.path)}
            if lines is not None:
                self._check(lines)
        except BaseException:
            self._file.close()
            raise

    def _lock(self) -> None:
        if fcntl is None:
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ValueError(
                f"{self.path}: expected results that nobody else writes, got those of a run that "
                "still runs"
            ) from None

    def _drop_torn_line(self) -> None:
        self._file.seek(0)
        text = self._file.read()
        self._file.truncate(text.rfind(b"\n") + 1)

    def _check(self, lines: Sequence[Line]) -> None:
        keys = {line.key for line in lines}
        for key in self.records:
            if key not in keys:
                raise self._refused(key, "a key that the plan does not have")
        self.left(lines)

    def _refused(self, key: str, got: str) -> ValueError:
        return ValueError(
            f"{self.path}: expected results of this plan, got {key} with {got}: the plan or a file "
            "that it names has changed; take a new folder, or remove the results"
        )

    def left(self, lines: Iterable[Line], again: bool = True) -> list[Line]:
        """Lines without a result; those that ended in an error are among them to be tried `again`.

        Raises ValueError for a result of other settings.
        """
        found = []
        for line in lines:
            record = self.records.get(line.key)
            if record is not None and record["digest"] != line.digest:
                raise self._refused(line.key, "other settings")
            if record is None or (again and "error" in record):
                found.append(line)
        return found

    def append(self, record: Record) -> None:
        """Write one line, so that no end of this process loses it; one whose result is there
        already is left out.
        """
        there = self.records.get(record["key"])
        if there is not None and "error" not in there:
            return
        text = json.dumps(record, allow_nan=False)
        self._file.write((text + "\n").encode())
        self._file.flush()
        self.records[record["key"]] = json.loads(text)  # as it is read back

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.fsync(self._file.fileno())
        self._file.close()


def read_results(path: Path) -> list[dict[str, Any]]:
    """The finished lines of a file of results, or of the one in a folder; without one, none.

    Raises ValueError for a line that is no JSON, but for a last one without its end.
    """
    file = path / NAME if path.is_dir() else path
    if not file.exists():
        return []
    *lines, _torn = file.read_bytes().split(b"\n")
    found = []
    for number, line in enumerate(lines, 1):
        try:
            found.append(json.loads(line))
        except ValueError as reason:
            raise ValueError(f"{file}:{number}: expected a result as JSON: {reason}") from reason
    return found


def find_record(key: str, folder: Path) -> Record:
    """The finished trial of a key in the results below a folder, of its first replicate if the key
    names none.

    Raises:
        ValueError: there is none; the message lists what is there of the same object.
    """
    keys: list[str] = []
    for file in sorted(folder.rglob(NAME)):
        for record in read_results(file):
            if record["key"] == key or record["key"].rpartition("/")[0] == key:
                return record
            keys.append(record["key"])
    near = [name for name in keys if name.split("/")[:2] == key.split("/")[:2]]
    some = ", ".join((near or keys)[:5]) or "no results"
    raise ValueError(f"cell: expected a trial in {folder}, such as {some}; got {key}")
