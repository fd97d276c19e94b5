"""The plan of a sweep, read from YAML, and its list of trials.

The file has the keys

* `format: softhand-sweep/1`, `name` (first part of every key), `strategy`;
* `objects`: a list of names, or a mapping of them to settings of their own, among these `place`
  (x, y) [m] where the object lies for a hand that is not displaced;
* `cells`: a list of displacements (x, y) [m] of the hand, or `grid: {x: [first, last, pitch], y:
  ...}` [m]. Such a displacement is called a cell. It is simulated by the opposite displacement of
  the object, while the strategy runs unchanged; with `moves: object` the object is displaced by
  the cell itself;
* `replicates` (1): jittered trials of each cell, numbered from 1; `nominal: true` runs one without
  jitter as number 0; `seed` (0) and `jitter: {place, yaw, mass, friction, modulus}`: largest shift
  in x and y [m], largest turn [rad], and shares on mass, friction of all pairs and shear modulus;
* any setting of a trial: scene, model, step, segments, solver, friction, wall_inclination, options,
  without, air_scale, displacement, hand, object_rpy, early_end (true here);
* `vary: {setting: [value, ...]}`: all trials are run with each value.

The jitter of a trial follows from seed, object, cell and replicate alone, so trials with other
settings have the same jitter. All cells of a replicate have the same factor on the modulus, as each
factor needs a newly built hand.
"""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from softhand_common.documents.yaml_document import Bounds, Node, read_document
from softhand_trials.sweep.record import read_setting
from softhand_trials.sweep.trial_task import TrialTask
from softhand_trials.trials import Placement, TrialSettings

FORMAT = "softhand-sweep/1"
MOVES = ("hand", "object")
LARGEST_COUNT = 1_000_000
SETTING_NAMES = tuple(f.name for f in fields(TrialSettings) if "set_by" not in f.metadata)
PLANNED_PLACE = Bounds(-2.0, 2.0, "m")
SHARE_BOUNDS = Bounds(0.0, 0.9, "")
JITTER_BOUNDS = {
    "place": Bounds(0.0, 0.1, "m"),
    "yaw": Bounds(0.0, np.pi, "rad"),
    "mass": SHARE_BOUNDS,
    "friction": SHARE_BOUNDS,
    "modulus": SHARE_BOUNDS,
}

Cell = tuple[float, float]


@dataclass(frozen=True)
class Jitter:
    """Largest changes of a replicate: place in x and y [m], yaw [rad], shares of mass, of the
    friction of all pairs and of the shear modulus.
    """

    place: float = 0.001
    yaw: float = 0.0349
    mass: float = 0.05
    friction: float = 0.15
    modulus: float = 0.05


@dataclass(frozen=True)
class SweptObject:
    """An object with its place (x, y) [m] under a hand that is not displaced, and the settings that
    only its trials have.
    """

    name: str
    place: Cell = (0.0, 0.0)
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepPlan:
    """A sweep, with the fields that the module's text describes. `settings`: the settings that all
    its trials share.
    """

    name: str
    settings: TrialSettings
    objects: tuple[SweptObject, ...]
    cells: tuple[Cell, ...] = ((0.0, 0.0),)
    moves: str = "hand"
    replicates: int = 1
    nominal: bool = False
    seed: int = 0
    jitter: Jitter = field(default_factory=Jitter)
    vary: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)

    def in_engines(self, engines: Sequence[str]) -> SweepPlan:
        """The plan with its trials in each of these engines, one engine after the other."""
        return replace(self, vary={**self.vary, "engine": tuple(engines)})

    def tasks(self) -> list[TrialTask]:
        """All trials; trials with the same hand and scene follow each other."""
        return list(self._tasks())

    def _tasks(self) -> Iterator[TrialTask]:
        numbers = range(0 if self.nominal else 1, self.replicates + 1)
        for varied in self._variations():
            for swept, replicate in itertools.product(self.objects, numbers):
                modulus_scale = self._modulus_scale(replicate)
                settings = replace(
                    self.settings,
                    object=swept.name,
                    modulus_scale=modulus_scale,
                    **{**swept.settings, **varied},
                )
                for cell in self.cells:
                    key = "/".join([*self._names(swept, varied), in_mm(cell), str(replicate)])
                    placement = self._placement(swept, cell, replicate)
                    yield TrialTask(key, swept.name, cell, replicate, settings, placement)

    def _names(self, swept: SweptObject, varied: Mapping[str, Any]) -> list[str]:
        values = [f"{name}={_short(value)}" for name, value in varied.items()]
        return [self.name, Path(swept.name).stem, *values]

    def _variations(self) -> Iterator[dict[str, Any]]:
        for values in itertools.product(*self.vary.values()):
            yield dict(zip(self.vary, values, strict=True))

    def _modulus_scale(self, replicate: int) -> float:
        if replicate == 0:
            return 1.0
        draw = np.random.default_rng([self.seed, replicate]).uniform(-1.0, 1.0)
        return float(1.0 + self.jitter.modulus * draw)

    def _placement(self, swept: SweptObject, cell: Cell, replicate: int) -> Placement:
        sign = -1.0 if self.moves == "hand" else 1.0
        x, y = np.array(swept.place) + sign * np.array(cell)
        if replicate == 0:
            return Placement((float(x), float(y)))
        place = f"{swept.name}/{in_mm(cell)}/{replicate}"
        generator = np.random.default_rng([self.seed, zlib.crc32(place.encode())])
        dx, dy, yaw, mass, friction = generator.uniform(-1.0, 1.0, 5).tolist()
        return Placement(
            (float(x) + self.jitter.place * dx, float(y) + self.jitter.place * dy),
            1.0 + self.jitter.mass * mass,
            self.jitter.yaw * yaw,
            1.0 + self.jitter.friction * friction,
        )


def in_mm(cell: Cell) -> str:
    """A cell (x, y) [m] as text in mm, as it stands in keys.

    >>> in_mm((0.012, -0.03))
    '12,-30'
    """
    return ",".join(f"{round(1e3 * value, 3) + 0.0:g}" for value in cell)


def _short(value: Any) -> str:
    if isinstance(value, tuple):
        return "+".join(map(_short, value))
    if isinstance(value, float):
        return f"{value:g}"
    return Path(value).stem if isinstance(value, str) else str(value)


def grid(x: tuple[float, float, float], y: tuple[float, float, float]) -> tuple[Cell, ...]:
    """Cells (x, y) [m] of a grid: first, last and pitch of either axis [m].

    >>> grid((0.0, 0.01, 0.01), (0.0, 0.0, 0.01))
    ((0.0, 0.0), (0.01, 0.0))
    """
    return tuple((a, b) for a in _axis(x) for b in _axis(y))


def _axis(axis: tuple[float, float, float]) -> list[float]:
    first, last, pitch = axis
    count = int(np.floor((last - first) / pitch + 1e-9)) + 1
    return [round(first + k * pitch, 9) for k in range(count)]


# ---------------------------------------------------------------- reading
def load_plan(path: str | Path) -> SweepPlan:
    """Read a plan; paths in it are relative to its folder.

    Raises ValueError naming file, key, expected and got.
    """
    document = read_document(Path(path), FORMAT)
    required = ("format", "name", "strategy", "objects")
    own = ("cells", "grid", "moves", "replicates", "nominal", "seed", "jitter", "vary")
    top = document.fields(required, (*own, *(name for name in SETTING_NAMES if name != "strategy")))
    settings = {name: _setting(name, top[name]) for name in SETTING_NAMES if name in top}
    plan = SweepPlan(
        top["name"].name(),
        TrialSettings(**{"early_end": True, **settings}),
        _objects(top["objects"]),
        _cells(document, top),
        top["moves"].choice(MOVES) if "moves" in top else "hand",
        top["replicates"].whole(0, LARGEST_COUNT) if "replicates" in top else 1,
        top["nominal"].choice([True, False]) if "nominal" in top else False,
        top["seed"].whole(0, 2**32 - 1) if "seed" in top else 0,
        _jitter(top["jitter"]) if "jitter" in top else Jitter(),
        _vary(top["vary"]) if "vary" in top else {},
    )
    if plan.replicates == 0 and not plan.nominal:
        raise top["replicates"].error("1 or more, or 0 beside `nominal: true`")
    return plan


def _objects(node: Node) -> tuple[SweptObject, ...]:
    if isinstance(node.value, list):
        node.names()
        return tuple(SweptObject(_file(child)) for child in node.items())
    found = []
    for name, child in node.mapping().items():
        own = {} if child.value is None else child.fields(optional=("place", *SETTING_NAMES))
        place = _pair(own.pop("place")) if "place" in own else (0.0, 0.0)
        settings = {key: _setting(key, value) for key, value in own.items()}
        found.append(SweptObject(name, place, settings))
    if not found:
        raise node.error("at least one object")
    return tuple(found)


def _cells(document: Node, top: Mapping[str, Node]) -> tuple[Cell, ...]:
    if "cells" in top and "grid" in top:
        raise document.error("either `cells` or `grid`", "both")
    if "grid" in top:
        axes = top["grid"].fields(("x", "y"))
        return grid(_grid_axis(axes["x"]), _grid_axis(axes["y"]))
    if "cells" not in top:
        return ((0.0, 0.0),)
    cells = tuple(map(_pair, top["cells"].items()))
    if not cells or len({in_mm(cell) for cell in cells}) < len(cells):
        raise top["cells"].error("cells without duplicates")
    return cells


def _pair(node: Node) -> Cell:
    x, y = node.vector(2, PLANNED_PLACE)
    return x, y


def _grid_axis(node: Node) -> tuple[float, float, float]:
    first, last, pitch = node.vector(3, PLANNED_PLACE)
    if not (pitch >= 1e-5 and last >= first):
        raise node.error("first, last and pitch [m], with last no less than first")
    return first, last, pitch


def _jitter(node: Node) -> Jitter:
    children = node.fields(optional=JITTER_BOUNDS)
    return Jitter(**{key: child.within(JITTER_BOUNDS[key]) for key, child in children.items()})


def _vary(node: Node) -> dict[str, tuple[Any, ...]]:
    children = node.fields(optional=SETTING_NAMES)
    return {
        name: tuple(_setting(name, value) for value in child.items())
        for name, child in children.items()
    }


def _setting(name: str, node: Node) -> Any:
    value = read_setting(name, node)
    return _file(node) if isinstance(value, str) else value


def _file(node: Node) -> str:
    """A name, or the path of a file from the plan's folder on."""
    name = node.text()
    path = Path(node.file).parent / name
    return str(path) if Path(name).suffix and path.is_file() else name
