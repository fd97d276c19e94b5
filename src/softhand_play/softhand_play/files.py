"""Files that the page may open: those below `out` and below folders that the user has named.

Every path is checked, with symbolic links resolved and for its kind, before the file is read.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pneuflex_sim.scene.mesh import MESH_SUFFIXES
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import is_name, read_document
from softhand_trials.sweep.results import RESULTS_FILE as RESULTS
from softhand_trials.sweep.trial_task import NAMED_FILES
from softhand_trials.trials import TrialSettings

OUT_FOLDER = Path("out")
YAML = (".yaml", ".yml")
BAG, BAG_FILES = "metadata.yaml", (".mcap", ".db3")
SET = "experiment.yaml"
DIAGNOSIS = ".json"
OFFERED_LIMIT = 100  # of the newest of each kind, offered in a list


@dataclass(frozen=True)
class Openable:
    """Paths that the page can open, newest first: folders of bags and measurement sets, files with
    results of sweeps, and JSON files.
    """

    bags: tuple[str, ...]
    maps: tuple[str, ...]
    sets: tuple[str, ...]
    diagnoses: tuple[str, ...]


class AllowedFiles:
    """Checks paths of files below `out` in the working folder and below other folders.

    All methods raise ValueError for a path outside of these folders or of the wrong kind.
    """

    def __init__(self, folders: Iterable[Path] = ()) -> None:
        self.folders = (OUT_FOLDER, *folders)

    def find(self) -> Openable:
        """The paths below the folders that can be opened; symbolic links to folders are not
        followed.
        """
        found = [
            Path(folder) / name
            for top in self.folders
            for folder, _, names in os.walk(top)
            for name in names
        ]
        return Openable(
            _newest(found, lambda path: path.name == BAG, of_folder=True),
            _newest(found, lambda path: path.name == RESULTS),
            _newest(found, lambda path: path.name == SET, of_folder=True),
            _newest(found, lambda path: path.suffix == DIAGNOSIS),
        )

    def bag(self, path: str) -> Path:
        """The folder of a bag."""
        folder = self._folder(path, f"the folder of a bag, with {BAG} and {' or '.join(BAG_FILES)}")
        found = [self._file(each) for each in folder.iterdir() if each.suffix in BAG_FILES]
        if not found:
            raise ValueError(f"{folder}: expected files {' or '.join(BAG_FILES)}, got none")
        self._file(folder / BAG)
        return folder

    def results(self, path: str) -> Path:
        """The file with results of a sweep, from its path or its folder."""
        found = Path(path)
        return self._file(found / RESULTS if found.is_dir() else found, ".jsonl")

    def diagnosis(self, path: str) -> Path:
        """The JSON file of a diagnosis."""
        return self._file(Path(path), DIAGNOSIS)

    def measurements(self, path: str) -> Path:
        """The folder of a measurement set; the files that it names must be allowed, too."""
        folder = self._folder(path, f"the folder of a measurement set, with {SET}")
        self.check_document(self._file(folder / SET))
        return folder

    def check_settings(self, settings: TrialSettings) -> None:
        """Check the files that settings of a trial name, and the files that those name."""
        for name in NAMED_FILES:
            value = getattr(settings, name)
            if value is not None and not is_name(value):
                path = self._file(Path(str(value)))
                if path.suffix in YAML:
                    self.check_document(path)

    def check_document(self, path: Path) -> None:
        """Check that the files named in a YAML file are below its folder or the allowed ones."""
        self._check_document(path, path.parent, set())

    def _check_document(self, path: Path, folder: Path, seen: set[Path]) -> None:
        seen.add(path.resolve())
        for named in _named(path, read_document(path).value):
            if not self._allows(named, folder):
                raise ValueError(f"{path}: {self._elsewhere(named)}")
            if named.suffix in YAML and named.resolve() not in seen and named.is_file():
                self._check_document(named, folder, seen)

    def _folder(self, path: str, kind: str) -> Path:
        found = Path(path)
        self._check(found)
        if not found.is_dir():
            raise ValueError(f"{shortened(path)}: expected {kind}, got no folder")
        return found

    def _file(self, path: Path, suffix: str = "") -> Path:
        self._check(path)
        if suffix and path.suffix != suffix:
            raise ValueError(f"{path}: expected a file {suffix}, got {path.suffix or 'no suffix'}")
        if not path.is_file():
            raise ValueError(f"{path}: expected a file, got none")
        return path

    def _check(self, path: Path) -> None:
        if "\0" in str(path) or not self._allows(path):
            raise ValueError(self._elsewhere(path))

    def _allows(self, path: Path, *others: Path) -> bool:
        real = path.resolve()
        return any(real.is_relative_to(each.resolve()) for each in (*self.folders, *others))

    def _elsewhere(self, path: Path) -> str:
        return (
            f"{shortened(str(path))}: expected a file below {listed(self.folders)}, got one "
            "elsewhere; softhand-play --files FOLDER allows others"
        )


def _newest(
    found: list[Path], wanted: Callable[[Path], bool], of_folder: bool = False
) -> tuple[str, ...]:
    """The newest of the wanted files, as paths of the files or of their folders."""
    ages = {path: os.lstat(path).st_mtime for path in found if wanted(path)}
    newest = sorted(ages, key=lambda path: -ages[path])[:OFFERED_LIMIT]
    return tuple(str(path.parent if of_folder else path) for path in newest)


def _named(document: Path, content: Any) -> Iterator[Path]:
    """Existing files that texts of a document name, relative to its folder or, as some readers
    look for YAML files and meshes there, to the working folder.
    """
    for text in filter(None, _texts(content)):
        if os.path.lexists(document.parent / text):
            yield document.parent / text
        if Path(text).suffix.lower() in (*YAML, *MESH_SUFFIXES) and os.path.lexists(text):
            yield Path(text)


def _texts(value: Any) -> Iterator[str]:
    """All texts in nested lists and mappings."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _texts(each)
