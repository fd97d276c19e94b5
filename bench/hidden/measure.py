"""What is measured of a plant, and the strength at which a law shows as much as asked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from bench.hidden import balance
from bench.hidden.design import Scene
from bench.hidden.laws.registry import LAWS, build
from bench.hidden.plant import Body, Plant

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
    if plant.grips:
        supply = supply + plant.grips * output
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
    body, dt = plant.aged(scene.body(), scene.before), time[:, 1] - time[:, 0]
    _carry_softening(scene, plant, body, dt, pressure, blocked)
    stretch, force = balance.stretches(plant, body, dt, pressure, scene.temperature, blocked)
    if blocked:
        return force
    if plant.set_share:
        stretch = _longer_at_rest(scene, plant, stretch)
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


def _longer_at_rest(scene: Scene, plant: Plant, stretch: Array) -> Array:
    """Stretch (runs, steps, sections) of fingers that keep a share of their largest strain, from
    that of fingers that do not: lam = u*(1 + share*(largest - 1)).

    While it grows, lam is the largest one itself, which makes it u*(1 - share)/(1 - share*u).
    """
    if plant.mass_scale or plant.tip_mass or plant.remembers:
        raise ValueError("expected a permanent set without weight or memory")
    growing = stretch * (1 - plant.set_share) / (1 - plant.set_share * stretch)
    start = carried(scene, growing.max(axis=1))
    largest = np.maximum(np.maximum.accumulate(growing, axis=1), start[:, None])
    return stretch * (1 + plant.set_share * (largest - 1))


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
    body, stretch = plant.aged(scene.body(), scene.before), 1.0 + supply
    warm, dt = scene.temperature[:, None], (time[:, 1] - time[:, 0])[:, None]
    for memory in (plant.modes, plant.loop):
        if memory is not None:
            memory.reset((len(stretch), 1))
    start = carried(scene, stretch.max(axis=1, keepdims=True))
    largest = np.maximum(np.maximum.accumulate(stretch, axis=1), start)
    if plant.softening is not None:
        plant.softening.largest = largest
    if plant.set_share:
        longer = 1.0 + plant.set_share * (largest - 1.0)
        stretch = np.maximum(stretch / longer, 1.0)
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


NODES = 6
THINNED = 40  # samples a run
THINNED_MOVING = 100
SLACK = 0.15  # of the modulus, as calibration


class BaseFit:
    """Least misfit of the base model over the modulus scale, for one set of inputs."""

    def __init__(self, experiment: str, scene: Scene, drive: Array) -> None:
        nodes = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
        scales = 1 + SLACK * nodes
        answers = [base_output(experiment, scene, drive, scale) for scale in scales]
        matrix = chebyshev.chebvander(nodes, NODES - 1)
        series = np.linalg.solve(matrix, np.reshape(answers, (NODES, -1)))
        trials = chebyshev.chebvander(np.linspace(-1, 1, 121), NODES - 1)
        self.answers = trials @ series

    def misfit(self, output: Array) -> float:
        """Root mean square of what the best base model leaves."""
        square = ((self.answers - output.reshape(1, -1)) ** 2).mean(axis=1)
        return float(np.sqrt(square.min()))


def floor_of(shown: Shown, noise: float, scatter: float) -> float:
    """Noise floor [unit of the output]: sensor noise and scatter from run to run."""
    sensor = noise * np.abs(shown.output).max()
    return float(np.hypot(sensor, scatter * np.sqrt((shown.output**2).mean())))


def strength_for(
    experiment: str,
    scene: Scene,
    entry: tuple[str, dict[str, float]],
    scale: float,
    ratio: float,
    noise: float,
    scatter: float,
) -> tuple[dict[str, float], float]:
    """Parameters with the knob set so that error before = ratio*floor, and the ratio reached.

    The knob stops at the end of its range when the ratio cannot be reached. Long scenes of many
    sections are thinned out meanwhile.
    """
    name, parameters = entry
    if scene.sections > 1:
        most = THINNED_MOVING if build([entry], scale).moving else THINNED
        scene = replace(scene, samples=min(scene.samples, most))
    reached = _Reached(experiment, scene, name, parameters, scale, noise, scatter)
    if LAWS[name].knob is None:
        return parameters, reached.ratio(None)
    knob, weak, strong = LAWS[name].knob
    sign = np.sign(parameters[knob])
    for end, beyond in ((strong, np.less_equal), (weak, np.greater_equal)):
        found = reached.ratio(sign * end)
        if beyond(found, ratio):
            return {**parameters, knob: float(sign * end)}, found

    def surplus(logarithm: float) -> float:
        found = reached.ratio(sign * np.exp(logarithm))
        return float(np.log((found**2 - 1 + 1e-9) / (ratio**2 - 1)))

    ends = sorted(np.log([weak, strong]))
    value = sign * np.exp(brentq(surplus, *ends, xtol=0.002, maxiter=30))
    return {**parameters, knob: float(value)}, reached.ratio(value)


class _Reached:
    """Ratio of error before to floor as a function of the knob."""

    def __init__(self, experiment, scene, name, parameters, scale, noise, scatter) -> None:
        self.experiment, self.scene, self.name = experiment, scene, name
        self.parameters, self.scale = parameters, scale
        self.noise, self.scatter = noise, scatter
        self.fit: BaseFit | None = None

    def ratio(self, value: float | None) -> float:
        """Error before over floor with the knob at a value."""
        law = LAWS[self.name]
        values = dict(self.parameters)
        if value is not None:
            values[law.knob[0]] = float(value)
        plant = build([(self.name, values)], self.scale, mode_of(self.experiment))
        shown = measure(self.experiment, self.scene, plant, fine=False)
        if self.fit is None or plant.gauge or plant.grips:
            self.fit = BaseFit(self.experiment, self.scene, shown.drive)
        floor = floor_of(shown, self.noise, self.scatter)
        return float(np.hypot(self.fit.misfit(shown.output), floor) / floor)


def mode_of(experiment: str) -> str:
    """Mode of the strain in an experiment."""
    return "uniaxial" if experiment == "uniaxial" else "planar"
