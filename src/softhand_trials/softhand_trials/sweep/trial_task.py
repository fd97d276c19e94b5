"""One trial of a sweep as plain data, the digest of its settings, and its result."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Any

from grasp_strategies.strategy import STRATEGY_FOLDER
from pneuflex_sim.engines import PYBULLET
from softhand_common.documents.quoted import listed
from softhand_trials.sweep.task import DIGEST_DIGITS, Record
from softhand_trials.trials import Placement, TrialSettings, started_scene

NAMED_FILES = ("strategy", "hand", "object", "scene", "model", "friction")  # of the settings


@dataclass(frozen=True)
class TrialTask:
    """One trial of a sweep, whose result depends on these fields alone.

    `key` names it, such as `push_map/marker/12,-30/1`: plan, object, cell [mm], replicate, and what
    varies; `cell` (x, y) [m] is its place in the map.
    """

    key: str
    object: str
    cell: tuple[float, float]
    replicate: int
    settings: TrialSettings
    placement: Placement

    @property
    def digest(self) -> str:
        """Hash of settings, placement and the content of the files that the settings name, wherever
        these lie.
        """
        settings = {
            setting.name: getattr(self.settings, setting.name)
            for setting in fields(TrialSettings)
            if "added" not in setting.metadata or setting.name in self._changed
        }
        settings |= {name: path.name for name, path in _own_files(self.settings).items()}
        plain = {"settings": settings, "placement": asdict(self.placement)}
        text = json.dumps(plain, sort_keys=True) + _files(self.settings)
        return hashlib.sha256(text.encode()).hexdigest()[:DIGEST_DIGITS]

    @property
    def _changed(self) -> dict[str, Any]:
        """Settings that are not the usual ones, on whatever machine."""
        usual, given = vars(TrialSettings(engine=PYBULLET)), vars(self.settings)
        return {name: value for name, value in given.items() if value != usual[name]}

    def describe(self) -> Record:
        """Description of the trial in its record; only settings that differ from the defaults are
        listed.
        """
        return {
            "key": self.key,
            "digest": self.digest,
            "object": self.object,
            "cell": self.cell,
            "replicate": self.replicate,
            "settings": self._changed,
            "placement": asdict(self.placement),
        }

    def result(self) -> Record:
        """Result of the trial: verdict, phase, cause and measures."""
        try:
            found = asdict(started_scene(self.settings).run(self.placement))
        except Exception:
            started_scene.cache_clear()  # its state is not known
            raise
        return {key: _plain(value) for key, value in found.items()}


def trial_of(record: Mapping[str, Any]) -> tuple[TrialSettings, Placement]:
    """Settings and placement of the trial of a record.

    Raises ValueError for settings that this version does not know.
    """
    unknown = sorted(set(record["settings"]) - {field.name for field in fields(TrialSettings)})
    if unknown:
        raise ValueError(
            f"{record['key']}: settings: expected those of a trial, got {listed(unknown)}"
        )
    placement = dict(record["placement"], offset=tuple(record["placement"]["offset"]))
    return TrialSettings(**{"engine": PYBULLET, **record["settings"]}), Placement(**placement)


@lru_cache(maxsize=64)
def _files(settings: TrialSettings) -> str:
    """Hashes of the strategy and of the user's own files that settings name."""
    shipped = STRATEGY_FOLDER / f"{settings.strategy}.yaml"
    paths = [*([shipped] if shipped.is_file() else []), *_own_files(settings).values()]
    return "".join(hashlib.sha256(path.read_bytes()).hexdigest() for path in paths)


@lru_cache(maxsize=64)
def _own_files(settings: TrialSettings) -> dict[str, Path]:
    """The user's own files that settings name, by field."""
    named = {name: getattr(settings, name) for name in NAMED_FILES}
    paths = {name: Path(str(value)) for name, value in named.items() if value is not None}
    return {name: path for name, path in paths.items() if path.is_file()}


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
