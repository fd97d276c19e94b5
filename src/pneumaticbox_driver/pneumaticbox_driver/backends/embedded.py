"""Embedded backend: a pretended bench in process, with bottles or actuators on its channels."""

import math
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from softhand_model.chain.volumes import Bottles, Chambers
from softhand_model.pneumatics import CommandWatch, PneumaticPlant, Pneumatics, load_pneumatics

RESPONSE_TIME = 0.02  # in which actuators take on the volume in balance, about a finger's [s]
LONGEST_STEP = 5e-3  # with the volumes held on their way; far below what could make them swing [s]
TICK = 1e-3  # of the bench's clock: the plant's longest substep, so that none is wasted [s]
LONGEST_CATCH_UP = 0.1  # that the bench catches up with when the process was held [s]


class EmbeddedBench:
    """The pneumatic plant with a chamber on each channel; time starts at 0.

    Like the simulator it opens the outlets when the driver falls silent. Chambers that follow the
    pressure do so with a lag of 20 ms.

    Args:
        channels: names of the channels.
        volumes: of bottles (n,) [m3], or `Chambers` as in `softhand_model.chain.volumes`.
        parameters: constants of the plant; None for those that are shipped.
        seed: of noise and jitter.
        relief_pressures: of mechanical relief valves (n,), gauge [Pa]; None without.

    Raises:
        ValueError: as the plant does.
    """

    def __init__(
        self,
        channels: Sequence[str],
        volumes: ArrayLike | Chambers,
        parameters: Pneumatics | None = None,
        seed: int = 0,
        relief_pressures: ArrayLike | None = None,
    ) -> None:
        self.chambers = volumes if hasattr(volumes, "volumes") else Bottles(volumes)
        ambient = (parameters or load_pneumatics()).ambient_pressure
        self.volumes = self.chambers.volumes(np.full(len(channels), ambient))
        self.plant = PneumaticPlant(channels, self.volumes, parameters, seed, relief_pressures)
        self._compile()
        self._watch = CommandWatch(len(channels))
        self._rest = self.plant.rest_mass(self.volumes)

    def _compile(self) -> None:
        # a step and back, so that nothing has to be compiled between two samples
        start = self.plant.save()
        self.plant.step(1e-3, np.zeros(len(self.volumes)), self.volumes)
        self.plant.restore(start)

    @property
    def time(self) -> float:
        """Time of the bench [s]."""
        return self.plant.time

    @property
    def mass(self) -> Floats:
        """True air masses above the fill at rest (n,) [kg]; not for the driver."""
        return self.plant.mass - self._rest

    def command(self, valves: ArrayLike) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        self._watch.receive(self.time, valves)

    def advance(self, dt: float) -> Floats:
        """Let `dt` [s] pass and read the sensors: channels, then supply (n + 1,) [Pa absolute]."""
        count = math.ceil(dt / LONGEST_STEP - 1e-9)
        for _ in range(count):
            self._step(dt / count)
        return self.plant.read()

    def _step(self, dt: float) -> None:
        balanced = self.chambers.volumes(self.plant.pressures)
        if balanced is not self.volumes:  # as that of bottles is
            self.volumes = self.volumes + dt / (dt + RESPONSE_TIME) * (balanced - self.volumes)
        self.plant.step(dt, self._watch.valves(self.time), self.volumes)


class EmbeddedBoard:
    """Lets a bench run up to the present whenever it is read.

    Args:
        bench: from its time 0 on.
        clock: monotonic [s].
    """

    def __init__(self, bench: EmbeddedBench, clock: Callable[[], float] = time.monotonic) -> None:
        self.bench = bench
        self._clock = clock
        self._last = clock()

    @property
    def time(self) -> float:
        """Up to when the bench has run, on the monotonic clock, in whole ticks [s]."""
        return self._last

    def read(self) -> Floats:
        """Read absolute pressures now: channels, then supply (n + 1,) [Pa]."""
        passed = math.floor((self._clock() - self._last) / TICK + 1e-6)
        self._last += passed * TICK
        return self.bench.advance(min(passed * TICK, LONGEST_CATCH_UP))

    def command(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        self.bench.command(valves)

    def set_supply(self, pressure: float) -> None:
        """Turn the supply regulator to a gauge pressure [Pa]."""
        self.bench.plant.set_supply(pressure)

    def close(self) -> None:
        """Open the outlets."""
        self.bench.command(np.full(len(self.bench.mass), -1, dtype=np.int8))
