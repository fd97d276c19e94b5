"""Random trials: objects, offsets, pressure steps, closing times. None may diverge."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from bench.row import at_most
from pneuflex_sim.simulation import Simulation, SimulationConfig

TRIALS = {0.005: 200, 0.002: 20, 0.001: 10}  # by step [s]
OBJECTS = ("cylinder", "tube", "ball", "tape_dispenser", "marker")
PALM_DOWN = np.array([0.0, 0.92388, 0.0, 0.38268])
DURATION = 3.0  # [s]
HIGHEST = 100e3  # [Pa]
CLOSING = (0.05, 0.8)  # [s]
HEIGHTS = (0.14, 0.20)  # [m] of the wrist, but for a quarter of the trials
FAR = 3.0  # [m]: an object that rolls away is no divergence, one that flies off is


def masses_at(simulation: Simulation, pressures: np.ndarray) -> np.ndarray:
    """Air masses [kg above rest] that give these gauge pressures [Pa] when nothing is touched."""
    still = np.zeros_like(simulation.bodies.v)
    bend = simulation.air.rest_bend(simulation.step_size, pressures, still, simulation.temperature)
    ambient, temperature = simulation.ambient, simulation.temperature
    return simulation.air.masses(pressures + ambient, ambient, temperature, bend)


class RandomCommands:
    """Pressure steps of random heights and closing times for all channels, and wrist poses."""

    def __init__(
        self,
        simulation: Simulation,
        draw: np.random.Generator,
        heights: tuple[float, float] = HEIGHTS,
    ) -> None:
        self._simulation, self._draw = simulation, draw
        in_the_air = draw.random() < 0.25
        self._height = 0.4 if in_the_air else draw.uniform(*heights)
        self._move(0.02)
        self._from = self._to = np.zeros(len(simulation.channels))
        self._begin, self._closing, self._next = 0.5, CLOSING[0], 0.5

    def _move(self, spread: float) -> None:
        place = np.array([-0.057, -0.015, self._height]) + self._draw.uniform(-spread, spread, 3)
        self._simulation.command_wrist(place, PALM_DOWN)

    def give(self) -> None:
        """Command what is due now."""
        now, draw = self._simulation.time, self._draw
        if now >= self._next:
            vent = draw.random() < 0.15
            pressures = draw.uniform(0.0, 0.0 if vent else HIGHEST, len(self._to))
            self._from, self._to = self._to, masses_at(self._simulation, pressures)
            self._begin, self._closing = now, draw.uniform(*CLOSING)
            self._next = now + self._closing + draw.uniform(0.0, 0.4)
            if draw.random() < 0.3:
                self._move(0.05)
        share = min(1.0, max(0.0, (now - self._begin) / self._closing))
        self._simulation.set_air_masses(self._from + share * (self._to - self._from))


def run_random(seed: int, step: float) -> str:
    """One trial; empty, or why it failed."""
    draw = np.random.default_rng(seed)
    config = SimulationConfig(
        object=str(draw.choice(OBJECTS)),
        step=step,
        object_offset=tuple(draw.uniform(-0.04, 0.04, 2).tolist()),
        object_mass_scale=float(draw.uniform(0.5, 2.0)),
    )
    simulation = Simulation(config)
    try:
        commands = RandomCommands(simulation, draw)
        while simulation.time < DURATION:
            commands.give()
            simulation.step()
            height = simulation.object_pose()[0][2]
            if not -0.03 < height < FAR:
                return f"the object is at a height of {height:.2f} m"
    except RuntimeError as error:
        return str(error)
    finally:
        simulation.close()
    return ""


def rows(small: bool) -> list[dict[str, Any]]:
    """Trials that ended, and those that failed, by step."""
    found = []
    for step, count in TRIALS.items():
        count = max(1, count // 10) if small else count
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of joints at their stops: meant here
            failures = [text for seed in range(count) if (text := run_random(seed, step))]
        for text in failures:
            print(f"  {1e3 * step:g} ms: {text}", flush=True)
        name = f"random trials, {1e3 * step:g} ms"
        found.append(at_most(f"{name}: failed", len(failures), f"of {count}", 0))
    return found
