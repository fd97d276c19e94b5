"""CPU time of a simulator's steps, inside and outside its engine, which is PyBullet's
stepSimulation or that of another one that is compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any
from unittest import mock

import numpy as np

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.simulation import Simulation


@dataclass
class StepTimes:
    """CPU seconds of every step, whole and inside the engine."""

    whole: list[float] = field(default_factory=list)
    inside: list[float] = field(default_factory=list)

    def factor(self, step: float) -> float:
        """Simulated over CPU time [-]."""
        return len(self.whole) * step / sum(self.whole)

    def share(self) -> float:
        """Share of the engine in the CPU time [-]."""
        return sum(self.inside) / sum(self.whole)

    def outside(self) -> float:
        """Median time [s] of a step outside the engine."""
        return float(np.median(np.subtract(self.whole, self.inside)))


@contextmanager
def timed_steps(
    after: Callable[[Any], None] = lambda simulation: None,
    simulator: type = Simulation,
    engine: tuple[ModuleType, str] = (pybullet, "stepSimulation"),
) -> Iterator[StepTimes]:
    """Time all steps of a class of simulator within the block, and its calls of the engine; `after`
    looks at the simulation after each, untimed.
    """
    times, inner, outer = StepTimes(), getattr(*engine), simulator.step

    def step_engine(*arguments: Any, **named: Any) -> None:
        start = time.thread_time()
        inner(*arguments, **named)
        times.inside[-1] = time.thread_time() - start

    def step_all(simulation: Any, *arguments: Any) -> None:
        times.inside.append(0.0)
        start = time.thread_time()
        outer(simulation, *arguments)
        times.whole.append(time.thread_time() - start)
        after(simulation)

    with mock.patch.object(*engine, step_engine), mock.patch.object(simulator, "step", step_all):
        yield times
