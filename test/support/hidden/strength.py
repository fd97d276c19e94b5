"""How strong a hidden law is made: the misfit of the base model, its modulus free by 15 %."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from hidden.design import Scene
from hidden.laws import LAWS, build
from hidden.measure import Shown, base_output, measure

Array = np.ndarray
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
        if self.fit is None or plant.gauge:
            self.fit = BaseFit(self.experiment, self.scene, shown.drive)
        floor = floor_of(shown, self.noise, self.scatter)
        return float(np.hypot(self.fit.misfit(shown.output), floor) / floor)


def mode_of(experiment: str) -> str:
    """Mode of the strain in an experiment."""
    return "uniaxial" if experiment == "uniaxial" else "planar"
