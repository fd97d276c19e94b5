"""CPU time of the simulator's steps, inside and outside PyBullet's stepSimulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from unittest import mock

import numpy as np
import pybullet

from pneuflex_sim.simulation import Simulation


@dataclass
class StepTimes:
    """CPU seconds of every step, whole and inside `stepSimulation`."""

    whole: list[float] = field(default_factory=list)
    inside: list[float] = field(default_factory=list)

    def factor(self, step: float) -> float:
        """Simulated over CPU time [-]."""
        return len(self.whole) * step / sum(self.whole)

    def share(self) -> float:
        """Share of `stepSimulation` in the CPU time [-]."""
        return sum(self.inside) / sum(self.whole)

    def outside(self) -> float:
        """Median time [s] of a step outside `stepSimulation`."""
        return float(np.median(np.subtract(self.whole, self.inside)))


@contextmanager
def timed_steps(
    after: Callable[[Simulation], None] = lambda simulation: None,
) -> Iterator[StepTimes]:
    """Time all steps within the block; `after` looks at the simulation after each, untimed."""
    times, inner, outer = StepTimes(), pybullet.stepSimulation, Simulation.step

    def step_bullet(**arguments: int) -> None:
        start = time.thread_time()
        inner(**arguments)
        times.inside[-1] = time.thread_time() - start

    def step_all(simulation: Simulation, valves: Any = None) -> None:
        times.inside.append(0.0)
        start = time.thread_time()
        outer(simulation, valves)
        times.whole.append(time.thread_time() - start)
        after(simulation)

    with (
        mock.patch.object(pybullet, "stepSimulation", step_bullet),
        mock.patch.object(Simulation, "step", step_all),
    ):
        yield times
