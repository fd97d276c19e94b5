"""The file of results: one line of JSON for each result, appended and flushed as soon as it is
finished."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType

from softhand_common.documents.json_document import json_node
from softhand_common.documents.output_file import named
from softhand_common.documents.yaml_document import DocumentError
from softhand_trials.sweep.record import check_record
from softhand_trials.sweep.task import Record, Task

RESULTS_FILE = "results.jsonl"
LONGEST_LINE = 2**22  # [bytes]

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]


class Results:
    """The results in a folder, to which new ones are added; a context manager.

    An incomplete last line, as a killed process leaves it, is removed, and its task is run again.
    Raises ValueError when another process writes to the file, or when it holds results of tasks
    that are not among `tasks`.

    Args:
        folder: folder of the results.
        tasks: all tasks that can be in the file; None if they are not known in advance.
        result, needed: fields of the records, as in `read_results`.
    """

    def __init__(
        self,
        folder: Path,
        tasks: Sequence[Task] | None = None,
        result: str = "",
        needed: Iterable[str] = (),
    ) -> None:
        self.path = folder / RESULTS_FILE
        folder.mkdir(parents=True, exist_ok=True)
        self._file = self.path.open("a+b", buffering=0)  # what cannot be written is not kept either
        try:
            self._lock()
            self._drop_torn_line()
            found = read_results(self.path, ("digest", *needed), result)
            self.records = {record["key"]: record for record in found}
            if tasks is not None:
                self._check(tasks)
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
                f"{self.path}: expected a file to which no other run writes, got one to which a "
                "run still writes; wait until that run ends, or take another folder"
            ) from None

    def _drop_torn_line(self) -> None:
        self._file.seek(0)
        text = self._file.read()
        self._file.truncate(text.rfind(b"\n") + 1)

    def _check(self, tasks: Sequence[Task]) -> None:
        keys = {task.key for task in tasks}
        for key in self.records:
            if key not in keys:
                raise self._refused(key, "which is not in the plan")
        self.left(tasks)

    def _refused(self, key: str, got: str) -> ValueError:
        return ValueError(
            f"{self.path}: expected results of this plan, got one of the trial {key}, {got}: the "
            "plan or a file that it names has changed; take a new folder, or remove the results"
        )

    def left(self, tasks: Iterable[Task], again: bool = True) -> list[Task]:
        """Tasks without a result, and with `again` also those that ended in an error.

        Raises ValueError when the file has a result of a task with other settings.
        """
        found = []
        for task in tasks:
            record = self.records.get(task.key)
            if record is not None and record["digest"] != task.digest:
                raise self._refused(task.key, "which was run with other settings")
            if record is None or (again and "error" in record):
                found.append(task)
        return found

    def append(self, record: Record) -> None:
        """Write one line at once, so that it is kept if this process is killed; a record whose task
        has a result already is not written. Raises UnwritableFile on a full disk; earlier lines
        stay whole.
        """
        there = self.records.get(record["key"])
        if there is not None and "error" not in there:
            return
        text = json.dumps(record, allow_nan=False)
        self._write((text + "\n").encode())
        self.records[record["key"]] = json.loads(text)  # as it is read back

    def _write(self, line: bytes) -> None:
        end, left = self.path.stat().st_size, memoryview(line)
        with named(self.path):
            try:
                while left:
                    left = left[self._file.write(left) :]
            except OSError:
                self._file.truncate(end)  # no part of a line
                raise

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


def read_results(path: Path, needed: Iterable[str] = (), result: str = "") -> list[Record]:
    """The records in the complete lines of a file of results, or of the one in a folder; none if
    there is no such file.

    Args:
        path: the file or the folder; an incomplete last line is left out.
        needed: fields that every line must have besides its key.
        result: the field that every line without `error` must have, such as the outcome of a trial.

    Raises:
        DocumentError: a line is not such a record; the message names file, line and field.
    """
    file = path / RESULTS_FILE if path.is_dir() else path
    if not file.exists():
        return []
    found: list[Record] = []
    with file.open("rb") as lines:
        for number in itertools.count(1):
            line = lines.readline(LONGEST_LINE)
            if len(line) == LONGEST_LINE:
                raise DocumentError(
                    f"{file}:{number}: expected at most {LONGEST_LINE} bytes, got more"
                )
            if not line.endswith(b"\n"):
                return found
            found.append(check_record(json_node(f"{file}:{number}", line), needed, result))
    return found


def find_record(key: str, folder: Path) -> Record:
    """The record of the trial with a key in the results below a folder; if the key names no
    replicate, that of its first replicate.

    Raises:
        ValueError: there is no such trial; the message lists trials of the same object.
    """
    keys: list[str] = []
    for file in sorted(folder.rglob(RESULTS_FILE)):
        for record in read_results(file, ("settings", "placement")):
            if record["key"] == key or record["key"].rpartition("/")[0] == key:
                return record
            keys.append(record["key"])
    near = [name for name in keys if name.split("/")[:2] == key.split("/")[:2]]
    some = ", ".join((near or keys)[:5]) or "no results"
    raise ValueError(f"cell: expected a trial in {folder}, such as {some}; got {key}")
