"""One trial of a hand with a motion: a line of results, a pure function of plain data."""

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

from grasp_strategies.sweep.line import DIGITS, Record
from grasp_strategies.trials import Placement, StartedScene, TrialSettings
from thesis.co_design import hands, motions

SHIPPED = hands.SHIPPED | motions.SHIPPED
HAND, STRATEGY = "hand.yaml", "strategy.yaml"
KEPT = ("outcome", "phase", "cause", "lift_height", "slip", "turn", "hold_time", "duration")

Design = tuple[tuple[str, float], ...]  # numbers of hand and motion by name


@dataclass(frozen=True)
class Physics:
    """How finely a trial is simulated: step [s], segments an actuator, whether neighbouring fingers
    touch.
    """

    step: float = 0.005
    segments: int = 5
    finger_contact: bool = False


class Shared(NamedTuple):
    """What trials share that need one scene."""

    design: Design
    object: str
    modulus_scale: float
    physics: Physics


@dataclass(frozen=True)
class DesignTrial:
    """A design on an object that lies somewhere; `key` names it in the results."""

    key: str
    shared: Shared
    placement: Placement

    @property
    def settings(self) -> Shared:
        """Workers stay with a scene."""
        return self.shared

    @property
    def digest(self) -> str:
        """Hash of design with its files, object, physics and placement."""
        plain = [self._plain(), *_texts(self.shared.design)]
        return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()[:DIGITS]

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
        """What the line of its result says of it."""
        return {"key": self.key, "digest": self.digest, **self._plain()}

    def result(self) -> Record:
        """What came of the trial."""
        try:
            found = asdict(_started(self.shared).scene.run(self.placement))
        except Exception:
            _started.cache_clear()  # nobody knows in which state it is
            raise
        return {key: _number(found[key]) for key in KEPT}


def _number(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


class _Blind(StartedScene):
    """Without the course of the empty hand: a design is tried too rarely for what that takes."""

    empty_course = None


class _Started:
    """The scene of a design on an object, with the design's files as long as it lives."""

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
    folder.mkdir(parents=True, exist_ok=True)
    texts = files_of(values)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in texts]


def design_of(values: Mapping[str, float]) -> Design:
    """All numbers of a design, those that are not given as shipped."""
    return tuple((SHIPPED | dict(values)).items())
