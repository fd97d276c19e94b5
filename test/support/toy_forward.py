"""A forward model without any physics, y = a*x + b*x**2, for tests of the lab's statistics."""

from dataclasses import dataclass

import numpy as np

from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen


@dataclass(frozen=True)
class ToyParameter:
    name: str
    low: float = -10.0
    high: float = 10.0
    start: float = 0.5
    typical: tuple = (0.0, 1.0)
    logarithmic: bool = False
    effect: str | None = None
    unit: str = ""
    spread: float = np.inf


class ToyForward:
    def __init__(self, x, measured, parameters=(ToyParameter("a"), ToyParameter("b"))):
        self.x, self.measured, self.parameters = x, measured, parameters

    def predict(self, values):
        powers = np.stack([self.x ** (order + 1) for order in range(len(self.parameters))])
        return values @ powers


def toy_set(random, runs=12, samples=100, gain=0.01, noise=0.02, truth=(2.0, 0.5), repeats=2):
    """A set (as of free_bending) of ramps to different heights, repeated, with scatter in gain."""
    made = []
    for index in range(runs):
        protocol = index // repeats
        x = np.linspace(0.0, 1.0 + 0.2 * protocol, samples)
        y = (truth[0] * x + truth[1] * x**2) * (1.0 + gain * random.standard_normal())
        y = y + noise * random.standard_normal(samples)
        columns = {"time": np.arange(samples) * 0.1, "pressure": x, "tip_angle": y}
        made.append(Run(f"r{index}", "s", f"p{protocol}", 293.15, columns))
    return MeasurementSet("free_bending", "toy", {"s": Specimen("s")}, tuple(made))


def toy_forward(data):
    x = np.concatenate([run.columns["pressure"] for run in data.runs])
    return ToyForward(x, np.concatenate([run.columns["tip_angle"] for run in data.runs]))
