"""One trial of a sweep as plain data, the digest of its settings, and its run."""

from __future__ import annotations

import hashlib
import json
import math
import platform
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from grasp_strategies.strategy import DATA
from grasp_strategies.trials import Placement, TrialSettings, started_scene

PACKAGES = ("grasp_strategies", "pneuflex_sim", "softhand_model")
LIBRARIES = ("pybullet", "numpy", "numba")
NAMED_FILES = ("strategy", "hand", "object", "scene", "model", "friction")  # of the settings
DIGITS = 16  # of a digest, in hexadecimal

Record = dict[str, Any]


@dataclass(frozen=True)
class TrialLine:
    """One trial of a sweep: a pure function of this.

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
        """Hash of settings, placement and the files that the settings name."""
        plain = {"settings": asdict(self.settings), "placement": asdict(self.placement)}
        text = json.dumps(plain, sort_keys=True) + _files(self.settings)
        return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]

    def describe(self) -> Record:
        """What the line of its result says of the trial, settings as far as they are not usual."""
        usual = TrialSettings()
        settings = {
            field.name: getattr(self.settings, field.name)
            for field in fields(TrialSettings)
            if getattr(self.settings, field.name) != getattr(usual, field.name)
        }
        return {
            "key": self.key,
            "digest": self.digest,
            "object": self.object,
            "cell": self.cell,
            "replicate": self.replicate,
            "settings": settings,
            "placement": asdict(self.placement),
        }


def trial_of(record: Mapping[str, Any]) -> tuple[TrialSettings, Placement]:
    """Settings and placement of the trial that a line of results is of."""
    placement = dict(record["placement"], offset=tuple(record["placement"]["offset"]))
    return TrialSettings(**record["settings"]), Placement(**placement)


@lru_cache(maxsize=64)
def _files(settings: TrialSettings) -> str:
    """Texts of the strategy and of the user's own files that settings name."""
    named = [getattr(settings, name) for name in NAMED_FILES]
    paths = [Path(str(name)) for name in named if name is not None]
    shipped = DATA / f"{settings.strategy}.yaml"
    texts = [path.read_bytes() for path in (shipped, *paths) if path.is_file()]
    return "".join(hashlib.sha256(text).hexdigest() for text in texts)


@lru_cache(maxsize=1)
def versions() -> Record:
    """What runs here: packages with a digest of their code and data, libraries, the machine's
    architecture.
    """
    found = {name: metadata.version(name) for name in (*PACKAGES, *LIBRARIES)}
    return found | {"code": _code_digest(), "machine": platform.machine()}


def _code_digest() -> str:
    code = hashlib.sha256()
    for package in PACKAGES:
        root = Path(str(resources.files(package)))
        for path in sorted(root.rglob("*")):
            if path.suffix in (".py", ".yaml"):
                code.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return code.hexdigest()[:DIGITS]


def run_line(line: TrialLine) -> Record:
    """Run a trial; its result as plain data for JSON. A trial that raises is a record with the
    `error` and without an outcome.
    """
    begin, cpu = time.perf_counter(), time.process_time()
    record = line.describe()
    try:
        started = started_scene(line.settings)
        result = asdict(started.run(line.placement))
    except Exception as error:  # noqa: BLE001 (a sweep goes on, and the line says what it was)
        started_scene.cache_clear()  # nobody knows in which state it is
        record["error"] = f"{type(error).__name__}: {error}"
    else:
        record |= {key: _plain(value) for key, value in result.items()}
    times = {"wall_time": time.perf_counter() - begin, "cpu_time": time.process_time() - cpu}
    return record | times | {"versions": versions()}


def lost_line(line: TrialLine, losses: int) -> Record:
    """The record of a trial whose worker got lost each time."""
    return line.describe() | {"error": f"its worker was lost {losses} times"}


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
