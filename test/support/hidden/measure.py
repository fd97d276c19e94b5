"""What a measurement would show without noise: a plant driven through the runs of a scene."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hidden import balance
from hidden.design import Scene
from hidden.plant import Body, Plant

Array = np.ndarray
FINE = 5  # steps a sample where something moves


@dataclass(frozen=True)
class Shown:
    """Columns (runs, samples): time [s], drive as its sensor shows it, output."""

    time: Array
    drive: Array
    output: Array


def measure(experiment: str, scene: Scene, plant: Plant, fine: bool = True) -> Shown:
    """Columns of all runs; `fine=False` computes at the samples only."""
    parts = FINE if fine and plant.moving else 1
    plant.parts, time = parts, scene.time(parts)
    supply = scene.drive(time)
    simulate = _pull if experiment == "uniaxial" else _inflate
    output = simulate(experiment, scene, plant, time, supply)
    for sensor in plant.sensors:
        output = sensor(time, output, supply)
    for gauge in plant.gauge:
        supply = gauge(supply)
    shown = supply + 1.0 if experiment == "uniaxial" else supply
    return Shown(time[:, ::parts], shown[:, ::parts], output[:, ::parts])


def base_output(experiment: str, scene: Scene, drive: Array, scale: float) -> Array:
    """What the base model says of the drive (runs, samples) that the sensor shows."""
    simulate = _pull if experiment == "uniaxial" else _inflate
    mode = "uniaxial" if experiment == "uniaxial" else "planar"
    supply = drive - 1.0 if experiment == "uniaxial" else drive
    return simulate(experiment, scene, Plant(scale, mode), scene.time(1), supply)


def _inflate(experiment: str, scene: Scene, plant: Plant, time: Array, supply: Array) -> Array:
    blocked = experiment == "blocked_tip"
    pressure = supply
    for change in plant.chamber:
        pressure = change(time, pressure)
    body, dt = scene.body(), time[:, 1] - time[:, 0]
    _carry_softening(scene, plant, body, dt, pressure, blocked)
    stretch, force = balance.stretches(plant, body, dt, pressure, scene.temperature, blocked)
    if blocked:
        return force
    if plant.printed is not None:
        return _printed_angle(plant, body, pressure)
    return balance.tip_angle(stretch, body)


def _carry_softening(
    scene: Scene, plant: Plant, body: Body, dt: Array, pressure: Array, blocked: bool
) -> None:
    """Largest stretch so far at every sample or, in a solution step by step, at each run's start.

    A softened wall reaches a new largest stretch on the curve of the unsoftened one.
    """
    if plant.softening is None:
        return
    virgin = replace(plant, softening=None, modes=None, loop=None)
    stretch, _ = balance.stretches(virgin, body, dt, pressure, scene.temperature, blocked)
    start = carried(scene, stretch.max(axis=1))
    if balance.stepwise(plant, blocked):
        plant.softening.largest = start
    else:
        so_far = np.maximum(np.maximum.accumulate(stretch, axis=1), start[:, None])
        plant.softening.largest = so_far.reshape(-1, stretch.shape[2])


def carried(scene: Scene, peaks: Array) -> Array:
    """Largest stretch (runs, sections) before each run, from each run's own largest one."""
    start, so_far = np.ones_like(peaks), {}
    for k, run in enumerate(scene.runs):
        if not run.virgin and run.specimen in so_far:
            start[k] = so_far[run.specimen]
        so_far[run.specimen] = np.maximum(start[k], peaks[k])
    return start


def _printed_angle(plant: Plant, body: Body, pressure: Array) -> Array:
    """Angle by the printed approximation (5.2, 5.3)."""
    a, p0 = plant.printed
    p, wall = pressure[:, :, None], (body.wall * body.modulus * plant.scale)[:, None]
    rule = p / (8 * wall)
    secant = 1 / np.sqrt(a) + p / np.sqrt(p**2 / (a - 1) + (a - 1) * p0**2)
    kappa = rule * body.ratio[:, None] * secant
    return (kappa * body.weights[:, None]).sum(axis=2)


def _pull(experiment: str, scene: Scene, plant: Plant, time: Array, supply: Array) -> Array:
    """Nominal stress of a strip: the stretch is given, so memory just follows."""
    body, stretch = scene.body(), 1.0 + supply
    warm, dt = scene.temperature[:, None], (time[:, 1] - time[:, 0])[:, None]
    for memory in (plant.modes, plant.loop):
        if memory is not None:
            memory.reset((len(stretch), 1))
    if plant.softening is not None:
        start = carried(scene, stretch.max(axis=1, keepdims=True))
        plant.softening.largest = np.maximum(np.maximum.accumulate(stretch, axis=1), start)
    elastic = plant.elastic(stretch, body)
    total = elastic.copy()
    for k in range(stretch.shape[1]):
        step = dt if k else np.zeros_like(dt)
        here = slice(k, k + 1)
        if plant.modes is not None:
            total[:, here] += plant.modes.trial(elastic[:, here], step)
            plant.modes.commit(elastic[:, here], step)
        if plant.loop is not None:
            total[:, here] += plant.loop.trial(stretch[:, here])
            plant.loop.commit(stretch[:, here])
    modulus = body.modulus * plant.scale
    for change in plant.modulus:
        modulus = modulus * change(warm)
    return modulus * total
