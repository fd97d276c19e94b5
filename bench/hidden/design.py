"""Which specimens are measured in which runs: the designs of time-based sets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bench.hidden import protocols
from bench.hidden.plant import Body
from bench.hidden.protocols import Protocol

Array = np.ndarray
ROOM = 293.15
UPHILL = {"base_up": 1.0, "base_down": -1.0, "bending_plane_level": 0.0}


@dataclass(frozen=True)
class PlannedRun:
    """One run: of which specimen, under which protocol, how warm, on a virgin specimen or not."""

    specimen: str
    protocol: Protocol
    temperature: float = ROOM
    virgin: bool = False


@dataclass(frozen=True)
class Scene:
    """Specimens (entries of experiment.yaml) and runs, all of `samples` samples.

    peak: of the drive, [Pa] or stretch minus one. sections: per specimen in the solution, of equal
    length or at Gauss's nodes.
    """

    specimens: dict[str, dict[str, Any]]
    runs: tuple[PlannedRun, ...]
    samples: int
    peak: float
    sections: int = 1
    gauss: bool = False
    gains: Array = field(default_factory=lambda: np.ones(1))  # run to run, on the modulus

    def time(self, parts: int) -> Array:
        """Times (runs, steps), `parts` steps a sample."""
        steps = (self.samples - 1) * parts + 1
        ends = np.array([run.protocol.duration for run in self.runs])
        return np.linspace(np.zeros_like(ends), ends, steps, axis=1)

    def drive(self, time: Array) -> Array:
        """Drive (runs, steps)."""
        rows = [run.protocol(t) for run, t in zip(self.runs, time, strict=True)]
        return self.peak * np.array(rows)

    @property
    def temperature(self) -> Array:
        """Temperature (runs,)."""
        return np.array([run.temperature for run in self.runs])

    @property
    def before(self) -> Array:
        """How many runs the specimen of each run (runs,) has had before, none if virgin."""
        so_far: dict[str, int] = {}
        counted = []
        for run in self.runs:
            so_far[run.specimen] = 0 if run.virgin else so_far.get(run.specimen, -1) + 1
            counted.append(so_far[run.specimen])
        return np.array(counted, float)

    def body(self) -> Body:
        """Sections of each run's specimen."""
        rows = [
            _sections(self.specimens[run.specimen], self.sections, self.gauss) for run in self.runs
        ]
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        columns["modulus"] = columns["modulus"] * self.gains.reshape(-1, 1)
        return Body(**columns)


def _sections(entry: dict[str, Any], count: int, gauss: bool) -> dict[str, Array]:
    """Sections of one specimen; profiles are straight between their points."""
    length = entry["length"]
    x, weights = (np.arange(count) + 0.5) * length / count, np.full(count, length / count)
    if gauss:
        nodes, shares = np.polynomial.legendre.leggauss(count)
        x, weights = (nodes + 1) * length / 2, shares * length / 2

    def along(value: float | list[list[float]]) -> Array:
        if isinstance(value, list):
            places, numbers = np.array(value, float).T
            return np.interp(x, places, numbers)
        return np.full(count, float(value))

    return {
        "x": x,
        "weights": weights,
        "length": np.array([length]),
        "height": along(entry["height"]),
        "width": along(entry["width"]),
        "wall": along(entry["wall"]),
        "side": along(entry["side_wall"]),
        "modulus": along(entry["shear_modulus"]),
        "mass": np.array([entry["mass"]]),
        "uphill": np.array([UPHILL[entry["mount"]]]),
    }


def specimen(wall: float, mount: str = "bending_plane_level", **more: Any) -> dict[str, Any]:
    """Entry of one actuator like those of the thesis."""
    entry: dict[str, Any] = {"length": 0.09, "height": 0.02, "width": 0.02, "wall": wall}
    entry |= {"side_wall": wall, "shear_modulus": 67000.0, "mass": 0.035}
    return entry | {"mount": mount, "batch": "A"} | more


@dataclass(frozen=True)
class ExtraRun:
    """A run beyond the design: times [s] and drive ([Pa] or stretch minus one) of its course.

    changes: of the specimen's entry against the first one of the design, if it is another.
    """

    protocol: str
    specimen: str
    temperature: float
    times: Array
    drive: Array
    changes: dict[str, Any] = field(default_factory=dict)


def extended(scene: Scene, extra: tuple[ExtraRun, ...]) -> Scene:
    """The scene with more runs behind its own."""
    specimens, runs = dict(scene.specimens), list(scene.runs)
    first = next(iter(scene.specimens.values()))
    for one in extra:
        specimens.setdefault(one.specimen, {**first, **one.changes})
        share = protocols.through(list(one.times), list(np.asarray(one.drive) / scene.peak))
        course = Protocol(one.protocol, float(one.times[-1]), share)
        runs.append(PlannedRun(one.specimen, course, one.temperature))
    gains = np.concatenate([scene.gains, np.ones(len(extra))])
    return replace(scene, specimens=specimens, runs=tuple(runs), gains=gains)


Make = Callable[[np.random.Generator, list[Protocol], int], tuple[dict[str, Any], list[PlannedRun]]]


def _passes(
    names: list[str], drives: list[Protocol], repeats: int, virgin: bool
) -> list[PlannedRun]:
    """Every specimen under every protocol, and all of it again."""
    return [
        PlannedRun(name, drive, virgin=virgin)
        for _ in range(repeats)
        for name in names
        for drive in drives
    ]


def standard(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """One specimen under all protocols."""
    wall = float(rng.choice([0.0025, 0.003, 0.0035]))
    return {"finger": specimen(wall)}, _passes(["finger"], drives, repeats, False)


def thin(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """One specimen with the wall of the thesis's finger, under all protocols."""
    return {"finger": specimen(0.002)}, _passes(["finger"], drives, repeats, False)


def recovered(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """One specimen, recovered to its virgin state before every run."""
    wall = float(rng.choice([0.0025, 0.003, 0.0035]))
    return {"finger": specimen(wall)}, _passes(["finger"], drives, repeats, True)


def walls(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """Four walls under three of the protocols."""
    made = {f"d{1e3 * wall:g}": specimen(wall) for wall in (0.0025, 0.0035, 0.0045, 0.0055)}
    return made, _passes(list(made), _some(rng, drives, 3), repeats, False)


def shapes(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """Four fingers of other lengths and heights under three of the protocols."""
    sizes = ((0.06, 0.02, 0.003), (0.09, 0.02, 0.0025), (0.09, 0.028, 0.003), (0.12, 0.016, 0.0035))
    made = {
        f"f{1e3 * length:.0f}_{1e3 * height:.0f}": specimen(wall, length=length, height=height)
        for length, height, wall in sizes
    }
    return made, _passes(list(made), _some(rng, drives, 3), repeats, False)


def temperatures(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """One specimen at three temperatures under four of the protocols."""
    chosen = _some(rng, drives, 4)
    runs = [
        PlannedRun("finger", drive, warm)
        for warm in (283.15, 296.15, 313.15)
        for _ in range(repeats)
        for drive in chosen
    ]
    return {"finger": specimen(float(rng.choice([0.0025, 0.003, 0.0035])))}, runs


def mounts(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """One finger level, hanging and standing, under four of the protocols."""
    wall = float(rng.choice([0.0025, 0.003, 0.0035]))
    kinds = {"level": "bending_plane_level", "hanging": "base_up", "standing": "base_down"}
    made = {name: specimen(wall, mount) for name, mount in kinds.items()}
    return made, _passes(list(made), _some(rng, drives, 4), repeats, False)


def tapered(
    rng: np.random.Generator, drives: list[Protocol], repeats: int
) -> tuple[dict[str, Any], list[PlannedRun]]:
    """A finger whose height falls towards the tip."""
    height = [[0.0, 0.02], [0.03, 0.0178], [0.06, 0.0145], [0.09, 0.0095]]
    made = {"finger": specimen(0.0025, height=height)}
    return made, _passes(["finger"], drives, repeats, False)


def _some(rng: np.random.Generator, drives: list[Protocol], count: int) -> list[Protocol]:
    chosen = rng.choice(len(drives), min(count, len(drives)), replace=False)
    return [drives[k] for k in sorted(chosen)]


DESIGNS: dict[str, Make] = {
    "standard": standard,
    "thin": thin,
    "recovered": recovered,
    "walls": walls,
    "shapes": shapes,
    "temperatures": temperatures,
    "mounts": mounts,
    "tapered": tapered,
}
DRIVES = {
    "standard": protocols.standard,
    "one_rate": protocols.one_rate,
    "above": protocols.above,
    "slow": protocols.slow,
}
SECTIONS = {"mounts": 24, "tapered": 30}
