"""The file of results: one line of JSON a trial, appended and flushed as soon as it is done."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any

from grasp_strategies.sweep.trial_line import Record, TrialLine

NAME = "results.jsonl"

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]


class Results:
    """The results of a sweep in a folder, to go on with; a context.

    A last line that was torn off, as a killed process leaves it, is dropped, and its trial done
    again; so is a trial that ended in an error. Raises ValueError when the file holds results of
    other trials than `lines`, or when another process writes to it.
    """

    def __init__(self, folder: Path, lines: Iterable[TrialLine]) -> None:
        self.path = folder / NAME
        folder.mkdir(parents=True, exist_ok=True)
        self._file = self.path.open("a+b")
        try:
            self._lock()
            self._drop_torn_line()
            self.done = self._check({line.key: line for line in lines})
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
                f"{self.path}: expected results that nobody else writes, got those of a sweep that "
                "still runs"
            ) from None

    def _drop_torn_line(self) -> None:
        self._file.seek(0)
        text = self._file.read()
        self._file.truncate(text.rfind(b"\n") + 1)

    def _check(self, wanted: dict[str, TrialLine]) -> set[str]:
        done: set[str] = set()
        for record in read_results(self.path):
            key = record["key"]
            line = wanted.get(key)
            if line is None or line.digest != record["digest"]:
                got = "a key that the plan does not have" if line is None else "other settings"
                raise ValueError(
                    f"{self.path}: expected results of this plan, got {key} with {got}: the plan "
                    "or a file that it names has changed; take a new folder, or remove the results"
                )
            if "error" not in record:
                done.add(key)
        return done

    def append(self, record: Record) -> None:
        """Write one line, so that no end of this process loses it; a trial that is there already is
        left out.
        """
        if record["key"] in self.done:
            return
        self._file.write((json.dumps(record, allow_nan=False) + "\n").encode())
        self._file.flush()
        self.done.add(record["key"])

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
