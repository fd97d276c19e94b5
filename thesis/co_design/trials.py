"""One trial of a hand with a motion: a record of results that depends on plain data alone."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from softhand_common.documents.output_file import write_files
from softhand_trials.sweep.task import DIGEST_DIGITS, Record
from softhand_trials.trials import Placement, StartedScene, TrialSettings
from thesis.co_design import hands, motions

SHIPPED = hands.SHIPPED | motions.SHIPPED
HAND, STRATEGY = "hand.yaml", "strategy.yaml"
KEPT = ("outcome", "phase", "cause", "lift_height", "slip", "turn", "hold_time", "duration")

Design = tuple[tuple[str, float], ...]  # numbers of hand and motion by name


@dataclass(frozen=True)
class Physics:
    """Resolution of a simulation: step [s], segments per actuator, whether neighbouring fingers
    touch.
    """

    step: float = 0.005
    segments: int = 5
    finger_contact: bool = False


class Shared(NamedTuple):
    """Data shared by all trials of one scene."""

    design: Design
    object: str
    modulus_scale: float
    physics: Physics


@dataclass(frozen=True)
class DesignTrial:
    """A trial of a design with an object at some place; `key` names it in the results."""

    key: str
    shared: Shared
    placement: Placement

    @property
    def settings(self) -> Shared:
        """Settings of the scene; a worker keeps the scene for trials with equal settings."""
        return self.shared

    @property
    def digest(self) -> str:
        """Hash of design with its files, object, physics and placement."""
        plain = [self._plain(), *_texts(self.shared.design)]
        text = json.dumps(plain, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:DIGEST_DIGITS]

    def _plain(self) -> dict[str, Any]:
        shared = self.shared
        return {
            "values": dict(shared.design),
            "object": shared.object,
            "modulus_scale": shared.modulus_scale,
            "physics": asdict(shared.physics),
            "placement": asdict(self.placement),
        }

    def describe(self) -> Record:
        """Description of the trial in the record of its result."""
        return {"key": self.key, "digest": self.digest, **self._plain()}

    def result(self) -> Record:
        """Run the trial; its outcome as plain data."""
        try:
            found = asdict(_started(self.shared).scene.run(self.placement))
        except Exception:
            _started.cache_clear()  # nobody knows in which state it is
            raise
        return {key: _number(found[key]) for key in KEPT}


def _number(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


class _Blind(StartedScene):
    """A scene without the path of the empty hand: a design has too few trials to pay for computing
    it.
    """

    empty_course = None


class _Started:
    """The scene of a design and an object; the design's files exist as long as it does."""

    def __init__(self, shared: Shared) -> None:
        self._folder = TemporaryDirectory(prefix="softhand-design-")
        folder = Path(self._folder.name)
        write_design(dict(shared.design), folder)
        self.scene = _Blind(
            TrialSettings(
                strategy=str(folder / STRATEGY),
                hand=str(folder / HAND),
                object=shared.object,
                modulus_scale=shared.modulus_scale,
                early_end=True,
                **asdict(shared.physics),
            )
        )


@lru_cache(maxsize=1)
def _started(shared: Shared) -> _Started:
    return _Started(shared)


def files_of(values: Mapping[str, float]) -> dict[str, str]:
    """Texts of the hand's and the strategy's YAML by their file names."""
    strategy = motions.strategy_text(values, values["finger_length"], HAND)
    return {HAND: hands.hand_text(values), STRATEGY: strategy}


@lru_cache(maxsize=64)
def _texts(design: Design) -> tuple[str, ...]:
    return tuple(files_of(dict(design)).values())


def write_design(values: Mapping[str, float], folder: Path) -> list[Path]:
    """Write hand and strategy of a design, over earlier ones."""
    texts = {folder / name: text for name, text in files_of(values).items()}
    write_files(texts)
    return list(texts)


def design_of(values: Mapping[str, float]) -> Design:
    """All numbers of a design; those that are not given are the shipped ones."""
    return tuple((SHIPPED | dict(values)).items())
