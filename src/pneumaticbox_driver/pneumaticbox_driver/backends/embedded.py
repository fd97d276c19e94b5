"""A pretended bench in process: the plant with fixed volumes on its channels."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softhand_model.pneumatics import CommandWatch, Pneumatics

Floats = NDArray[np.float64]


class EmbeddedBench:
    """The pneumatic plant with a bottle on each channel; time starts at 0.

    Like the simulator it opens the outlets when the driver falls silent.

    Args:
        channels: names of the channels.
        volumes: of the bottles (n,) [m3].
        parameters: constants of the plant; None for those that are shipped.
        seed: of noise and jitter.
        relief_pressures: of mechanical relief valves (n,), gauge [Pa]; None without.

    Raises:
        ValueError: as the plant does.
    """

    def __init__(
        self,
        channels: Sequence[str],
        volumes: ArrayLike,
        parameters: Pneumatics | None = None,
        seed: int = 0,
        relief_pressures: ArrayLike | None = None,
    ) -> None:
        # imported here, for it takes numba along
        from softhand_model.pneumatics.compiled_plant import PLANT

        self.plant = PLANT(channels, volumes, parameters, seed, relief_pressures)
        self._volumes = np.asarray(volumes, dtype=float)
        self._compile()
        self._watch = CommandWatch(len(channels))
        self._rest = self.plant.rest_mass(self._volumes)

    def _compile(self) -> None:
        # a step and back, so that nothing has to be compiled between two samples
        start = self.plant.save()
        self.plant.step(1e-3, np.zeros(len(self._volumes)), self._volumes)
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
        self.plant.step(dt, self._watch.valves(self.time), self._volumes)
        return self.plant.read()
