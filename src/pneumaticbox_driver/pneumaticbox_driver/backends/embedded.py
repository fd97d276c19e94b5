"""Embedded backend: a simulated box in the driver's process, with bottles or actuators."""

import math
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from pneumaticbox_driver.arrays import Floats, Valves
from softhand_model.chain.volumes import Bottles, Chambers
from softhand_model.pneumatics import CommandWatch, PneumaticPlant, Pneumatics, load_pneumatics

RESPONSE_TIME = 0.02  # time constant of the volumes, about that of a finger [s]
LONGEST_RIG_STEP = 5e-3  # with constant volumes; far below the limit of stability [s]
RIG_TICK = 1e-3  # of the rig's clock: the longest substep of the plant [s]
LONGEST_CATCH_UP = 0.1  # simulated at most after the process was suspended [s]


class EmbeddedRig:
    """The pneumatic plant with a chamber on each channel; time starts at 0.

    Like the simulator it opens the outlets when commands stop. Volumes that depend on the pressure
    follow it with a lag of 20 ms.

    Args:
        channels: names of the channels.
        volumes: volumes of bottles (n,) [m3], or `Chambers` as in `softhand_model.chain.volumes`.
        parameters: constants of the plant; None for the shipped ones.
        seed: seed of the sensors' noise and of the scatter of the valves' delays.
        relief_pressures: gauge pressures at which mechanical relief valves open (n,) [Pa]; None:
            there are none.

    Raises:
        ValueError: as `PneumaticPlant` does.
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
        # one step, then restored: no kernel has to be compiled between two samples
        start = self.plant.save()
        self.plant.step(1e-3, np.zeros(len(self.volumes)), self.volumes)
        self.plant.restore(start)

    @property
    def time(self) -> float:
        """Time of the rig [s]."""
        return self.plant.time

    @property
    def mass(self) -> Floats:
        """True air mass (n,) [kg] that each simulated channel holds beyond that at ambient
        pressure. The driver cannot see it.
        """
        return self.plant.mass - self._rest

    def command(self, valves: ArrayLike) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        self._watch.receive(self.time, valves)

    def advance(self, dt: float) -> Floats:
        """Simulate `dt` [s]; returns the sensors' absolute pressures, supply last (n + 1,) [Pa]."""
        count = math.ceil(dt / LONGEST_RIG_STEP - 1e-9)
        for _ in range(count):
            self._step(dt / count)
        return self.plant.read()

    def _step(self, dt: float) -> None:
        balanced = self.chambers.volumes(self.plant.pressures)
        if balanced is not self.volumes:  # bottles return the same array
            self.volumes = self.volumes + dt / (dt + RESPONSE_TIME) * (balanced - self.volumes)
        self.plant.step(dt, self._watch.valves(self.time), self.volumes)


class EmbeddedBoard:
    """Simulates a rig up to the present time at each reading.

    Args:
        rig: the rig, at its time 0.
        clock: returns the monotonic time [s].
    """

    def __init__(self, rig: EmbeddedRig, clock: Callable[[], float] = time.monotonic) -> None:
        self.rig = rig
        self._clock = clock
        self._last = clock()

    @property
    def time(self) -> float:
        """Monotonic time up to which the rig has been simulated, in whole ticks [s]."""
        return self._last

    def read(self) -> Floats:
        """Read absolute pressures now: channels, then supply (n + 1,) [Pa]."""
        passed = math.floor((self._clock() - self._last) / RIG_TICK + 1e-6)
        self._last += passed * RIG_TICK
        return self.rig.advance(min(passed * RIG_TICK, LONGEST_CATCH_UP))

    def command(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        self.rig.command(valves)

    def set_supply(self, pressure: float) -> None:
        """Set the supply regulator to a gauge pressure [Pa]."""
        self.rig.plant.set_supply(pressure)

    def close(self) -> None:
        """Open the outlets."""
        self.rig.command(np.full(len(self.rig.mass), -1, dtype=np.int8))
