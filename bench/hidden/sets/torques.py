"""Making one measurement set of the torque on the base of a finger whose tip is pushed about."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from bench.hidden import balance, chain
from bench.hidden.chain import SEGMENTS, Springs
from bench.hidden.design import PlannedRun, Scene, specimen
from bench.hidden.laws import catalogue, outside  # noqa: F401  (they register)
from bench.hidden.laws.registry import LAWS, build
from bench.hidden.plant import Plant
from bench.hidden.protocols import Protocol, through
from bench.hidden.sets.writing import write_set

Array = np.ndarray
Entries = list[tuple[str, dict[str, float]]]
PARTS = 5
OUTPUTS = ("torque_x", "torque_y", "torque_z")
POSE = ("tip_x", "tip_y", "tip_z", "tip_qx", "tip_qy", "tip_qz", "tip_qw")
UNITS = {"time": "s", "pressure": "kPa"} | dict.fromkeys(POSE[:3], "m")
UNITS |= dict.fromkeys(POSE[3:], "") | dict.fromkeys(OUTPUTS, "mN*m")
PUSHES = {  # protocol: what is pushed (force x, y, z; moment x, y, z; in B/L**2, B/L), pressure
    "sideways": ([0.0, 0.5, 0.0, 0.0, 0.0, 0.0], [(0, 0), (3, 0.7), (20, 0.7)]),
    "up_down": ([0.5, 0.0, 0.3, 0.0, 0.0, 0.0], [(0, 0), (3, 0.7), (20, 0.7)]),
    "roll": ([0.0, 0.0, 0.0, 0.1, 0.0, 0.4], [(0, 0), (3, 0.7), (20, 0.7)]),
    "pumped": ([0.2, 0.2, 0.0, 0.0, 0.2, 0.0], [(0, 0), (4, 1.0), (8, 0.4), (14, 0.9), (20, 0.5)]),
    "stepped": (
        [0.0, 0.3, 0.2, 0.0, 0.2, 0.2],
        [(0, 0), (2, 0.5), (6, 0.5), (7, 0.95), (12, 0.95), (13, 0.6), (20, 0.6)],
    ),
    "mixed": ([0.3, -0.3, 0.1, 0.2, 0.0, -0.3], [(0, 0), (6, 0.9), (14, 0.9), (20, 0.3)]),
}
PUSH_COURSE = ([4.0, 5.0, 7.0, 8.0, 9.0, 11.0, 12.0, 13.0, 15.0, 16.0, 17.0, 19.0, 20.0],) + (
    [0.0, 1.0, 1.0, 0.0, 0.8, 0.8, 0.0, -1.0, -1.0, 0.0, -0.8, -0.8, 0.0],
)  # of a push: twice the one way, twice the other


class Rig:
    """One finger, its runs, and the pushes on it."""

    def __init__(self, rng: np.random.Generator, runs: int, repeats: int, samples: int) -> None:
        wall = float(rng.choice([0.0025, 0.003]))
        names = list(PUSHES)[: max(1, runs // repeats)] * repeats
        planned = [PlannedRun("finger", _pressure(name)) for name in names]
        peak = float(rng.uniform(40e3, 48e3))
        ones = np.ones(len(names))
        self.scene = Scene({"finger": specimen(wall)}, tuple(planned), samples, peak, gains=ones)
        self.body = self.scene.body()
        self.strength = np.array([PUSHES[name][0] for name in names]) * rng.uniform(0.8, 1.1)

    def springs(self, plant: Plant, rest: Array) -> Springs:
        """Springs at all samples, rest (n,) [rad] of the whole finger."""
        return Springs(
            np.full(len(rest), self._stiffness(plant.scale)),
            rest / SEGMENTS,
            float(self.body.length[0, 0]) / SEGMENTS,
            plant.bend_twist,
            plant.slack,
        )

    def _stiffness(self, scale: float) -> float:
        """k = B/edge with B = (2/ratio)*2*G*d*(c/4)**3 (3.26)."""
        body = self.body
        edge = (body.height + body.width) / 2
        bending = 2 / body.ratio * 2 * body.modulus * scale * body.wall * edge**3
        return float(bending[0, 0] / body.length[0, 0] * SEGMENTS)

    def angle(self, plant: Plant, time: Array, pressure: Array) -> Array:
        """Free angle (runs, steps) [rad] of the finger."""
        for change in plant.chamber:
            pressure = change(time, pressure)
        dt, warm = time[:, 1] - time[:, 0], self.scene.temperature
        stretch, _ = balance.stretches(plant, self.body, dt, pressure, warm, False)
        return balance.tip_angle(stretch, self.body)

    def pushed(self, time: Array, rest: Array) -> Array:
        """Force and torque (n, 6) on the base: pushes on the tip as it lies without them."""
        length = float(self.body.length[0, 0])
        bending = self._stiffness(1.0) * length / SEGMENTS
        size = np.repeat([bending / length**2, bending / length], 3)
        course = np.interp(time.ravel(), *PUSH_COURSE)[:, None]
        strength = np.repeat(self.strength, time.shape[1], axis=0)
        wrench = course * strength * size
        free = np.zeros((len(rest), 3))
        tip, _ = chain.march(self.springs(Plant(), rest), free, free)
        wrench[:, 3:] += np.cross(tip, wrench[:, :3])
        return wrench


def _pressure(name: str) -> Protocol:
    times, values = zip(*PUSHES[name][1], strict=True)
    return Protocol(name, 20.0, through(list(times), list(values)))


def shown(rig: Rig, plant: Plant, parts: int) -> dict[str, Array]:
    """Columns (runs, samples) in SI units, without noise."""
    plant.parts, time = parts, rig.scene.time(parts)
    supply = rig.scene.drive(time)
    rest = rig.angle(plant, time, supply)[:, ::parts].ravel()
    at = time[:, ::parts]
    wrench = rig.pushed(at, rest)
    place, turn = chain.march(rig.springs(plant, rest), wrench[:, :3], wrench[:, 3:])
    for gauge in plant.gauge:
        supply = gauge(supply)
    columns = {"time": at, "pressure": supply[:, ::parts]}
    pose = np.hstack([place, turn.as_quat()]).T.reshape(7, *at.shape)
    columns |= dict(zip(POSE, pose, strict=True))
    torque = wrench[:, 3:].T.reshape(3, *at.shape)
    for sensor in plant.sensors:
        torque = np.array([sensor(at, part, columns["pressure"]) for part in torque])
    for mix in plant.mixing:
        torque = np.einsum("ij,jrk->irk", mix, torque)
    return columns | dict(zip(OUTPUTS, torque, strict=True))


class BaseFit:
    """Least misfit of the base model on shown columns, its modulus free by 15 %."""

    def __init__(self, rig: Rig, columns: dict[str, Array]) -> None:
        place = np.stack([columns[name].ravel() for name in POSE[:3]], axis=1)
        turn = Rotation.from_quat(np.stack([columns[name].ravel() for name in POSE[3:]], axis=1))
        measured = np.stack([columns[name].ravel() for name in OUTPUTS], axis=1)
        self.left = []
        start = np.hstack([np.zeros_like(measured), measured])
        for scale in (0.86, 0.93, 1.0, 1.07, 1.14):
            plant = Plant(scale)
            rest = rig.angle(plant, columns["time"], columns["pressure"]).ravel()
            wrench = chain.held(rig.springs(plant, rest), place, turn, start)
            start = wrench
            self.left.append(wrench[:, 3:] - measured)

    def misfit(self) -> float:
        """Root mean square over samples and outputs, at the best scale of a parabola."""
        squares = [float((left**2).mean()) for left in self.left]
        scales = np.array([0.86, 0.93, 1.0, 1.07, 1.14])
        fine = np.linspace(0.85, 1.15, 61)
        curve = np.polyval(np.polyfit(scales, squares, 3), fine)
        return float(np.sqrt(max(curve.min(), 0.0)))


def floor_of(columns: dict[str, Array], noise: float, scatter: float) -> tuple[float, float]:
    """Noise floor and sensor noise [N m]."""
    torque = np.array([columns[name] for name in OUTPUTS])
    sigma = noise * float(np.abs(torque).max())
    return float(np.hypot(sigma, scatter * np.sqrt((torque**2).mean()))), sigma


def make_torque_set(
    folder: Path,
    hidden: Entries,
    *,
    seed: int,
    noise: float,
    scatter: float,
    ratio: float | None,
    runs: int,
    samples: int,
    repeats: int,
    with_noise: bool,
    adjacent: bool,
) -> dict[str, Any]:
    """Write a set of base torques; arguments and truth as those of `make_set`."""
    rng = np.random.default_rng(seed)
    rig = Rig(rng, runs, repeats, min(samples, 60))
    scale = float(rng.uniform(0.92, 1.08))

    def reached(entries: Entries) -> float:
        columns = shown(rig, build(entries, scale), 1)
        floor, _ = floor_of(columns, noise, scatter)
        return float(np.hypot(BaseFit(rig, columns).misfit(), floor) / floor)

    entries, ratios = [], []
    for name, given in hidden:
        values = LAWS[name].complete(given, rng)
        if ratio is not None:
            values, found = _tuned(reached, name, values, given, ratio)
            ratios.append(found)
        entries.append((name, values))
    columns = shown(rig, build(entries, scale), PARTS)
    floor, sigma = floor_of(columns, noise, scatter)
    gains = 1 + scatter * rng.standard_normal((len(rig.scene.runs), 1))
    together = reached(entries)
    for name in OUTPUTS:
        clean = columns[name]
        columns[name] = clean * gains + sigma * rng.standard_normal(clean.shape)
    _write(Path(folder), rig, columns, sigma if with_noise else None)
    return {
        "experiment": "base_torque",
        "hidden": [{"name": name, "parameters": values} for name, values in entries],
        "modulus_scale": scale,
        "noise": sigma,
        "floor": floor,
        "ratio": together,
        "ratios": ratios,
    }


def _tuned(
    reached: Callable[[Entries], float],
    name: str,
    values: dict[str, float],
    given: dict[str, float],
    ratio: float,
) -> tuple[dict[str, float], float]:
    """Values with the knob set for the ratio, and the ratio reached; a coarse search."""
    knob = LAWS[name].knob
    if knob is None or knob[0] in given:
        return values, reached([(name, values)])
    sign = np.sign(values[knob[0]])

    def trial(logarithm: float) -> dict[str, float]:
        return {**values, knob[0]: float(sign * np.exp(logarithm))}

    def surplus(logarithm: float) -> float:
        found = reached([(name, trial(logarithm))])
        return float(np.log((found**2 - 1 + 1e-9) / (ratio**2 - 1)))

    low, high = np.log(knob[1]), np.log(knob[2])
    for part in np.linspace(0, 1, 7)[1:]:  # from weak to strong: far beyond, base poses fail
        end = low + part * (high - low)
        if surplus(end) > 0:
            weaker = end - (high - low) / 6
            sought = surplus(weaker) < 0  # else it is as weak as the knob goes, and stronger yet
            value = brentq(surplus, *sorted((weaker, end)), xtol=0.02) if sought else weaker
            return trial(value), reached([(name, trial(value))])
    return values, reached([(name, values)])


def _write(folder: Path, rig: Rig, columns: dict[str, Array], sigma: float | None) -> None:
    runs = {}
    for k, run in enumerate(rig.scene.runs):
        entry = {"specimen": run.specimen, "temperature": run.temperature}
        entry["protocol"] = run.protocol.name
        runs[f"r{k + 1:02d}"] = (entry, {name: columns[name][k] for name in UNITS})
    head = {
        "experiment": "base_torque",
        "title": "torque of a finger on its base",
        "specimens": rig.scene.specimens,
    }
    noise = None if sigma is None else dict.fromkeys(OUTPUTS, sigma)
    write_set(folder, head, UNITS, noise, runs)
