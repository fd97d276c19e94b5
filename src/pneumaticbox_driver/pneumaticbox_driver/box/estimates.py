"""Checks whether the estimated air masses are possible at the measured pressures."""

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats
from pneumaticbox_driver.settings import BoxSettings
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import GAS_CONSTANT

# Smallest possible volume of a channel over that at rest. The volume of a bottle is constant; the
# margin is for an inaccurate rest volume and for an unknown actuator that is compressed.
LEAST_VOLUME_SHARE = {"fixed": 0.65, "hand": 0.5}
SURELY_POSSIBLE = 1.5  # largest volume over that at rest, unless the hand allows a larger one [-]
PERSISTENCE = 1.0  # time for which an estimate must be wrong, longer than switching and cooling [s]


class EstimateCheck:
    """Marks channels whose estimated mass would need an impossible volume.

    The volume is `V = m R_s T/p_abs` of all the air in the channel, with a margin of four standard
    deviations of the estimate. `wrong` (n,) marks the channels.

    Args:
        settings: settings of the box.
        greatest: largest volumes of the channels (n,) [m3].
    """

    def __init__(self, settings: BoxSettings, greatest: Floats) -> None:
        n = len(settings.channels)
        self._settings = settings
        self._gas = GAS_CONSTANT * settings.temperature
        self._rest: Floats = np.array(settings.rest_volumes)
        self._least = LEAST_VOLUME_SHARE[settings.volume_model] * self._rest
        self._greatest = np.maximum(greatest, SURELY_POSSIBLE * self._rest)
        self._since: Floats = np.full(n, np.inf)  # time from which it has been wrong [s]
        self._mass: Floats = np.zeros(n)
        self._pressures_abs: Floats = np.full(n, settings.ambient)
        self.wrong: Flags = np.zeros(n, dtype=bool)
        nothing = np.zeros(n, dtype=bool)  # compile or load the kernel before the first sample
        self.look(0.0, self._mass, self._mass, self._pressures_abs, nothing)

    def look(
        self, time: float, mass: Floats, drift: Floats, pressures_abs: Floats, known: Flags
    ) -> list[str]:
        """Compare estimates and pressures.

        Args:
            time: present time [s].
            mass: estimated masses above rest (n,) [kg].
            drift: two standard deviations of the estimates (n,) [kg].
            pressures_abs: absolute pressures (n,) [Pa].
            known: channels with a valid estimate (n,).

        Returns:
            A sentence for each channel that is newly marked.
        """
        self._mass, self._pressures_abs = mass, pressures_abs
        before = self.wrong.tolist()
        content = self._gas, self._settings.ambient
        volumes = self._rest, self._least, self._greatest
        if not judge_estimates(
            time, mass, drift, pressures_abs, known, content, volumes, self._since, self.wrong
        ):
            return []
        new = [i for i, wrong in enumerate(self.wrong.tolist()) if wrong and not before[i]]
        return [f"channel {self._settings.channels[i]}: {self.sentence(i)}" for i in new]

    def sentence(self, channel: int) -> str:
        """A warning for a marked channel; "" for others."""
        if not self.wrong[channel]:
            return ""
        mass, pressure_abs = self._mass[channel], self._pressures_abs[channel]
        ambient, rest = self._settings.ambient, self._rest[channel]
        share = (mass * self._gas + ambient * rest) / pressure_abs / rest
        return (
            f"an air mass of {mass * 1e6:.1f} mg above rest cannot be true at "
            f"{(pressure_abs - ambient) / 1e3:.0f} kPa: it needs {share:.2f} of the volume at "
            "rest; check rest volume, calibration, tubes and sensor, then vent and tare"
        )


@compiled
def judge_estimates(
    time: float,
    mass: Floats,
    drift: Floats,
    pressures_abs: Floats,
    known: Flags,
    content: tuple[float, float],
    volumes: tuple[Floats, Floats, Floats],
    since: Floats,
    wrong: Flags,
) -> bool:
    """Update `since` (n,) [s] and `wrong` (n,) of an `EstimateCheck` to a `time` [s], in place;
    returns whether a channel is wrong.

    `mass`, `drift`, absolute `pressures_abs` and `known` are those of `EstimateCheck.look`;
    `content` has the product of gas constant and temperature [J/kg], and the ambient pressure [Pa];
    `volumes` are those at rest, the least and the greatest, each (n,) [m3].
    """
    gas, ambient = content
    rest, least, greatest = volumes
    found = False
    for i in range(len(mass)):
        volume = (mass[i] * gas + ambient * rest[i]) / pressures_abs[i]
        margin = 2 * drift[i] * gas / pressures_abs[i]
        possible = volume + margin >= least[i] and volume - margin <= greatest[i]
        since[i] = min(since[i], time) if known[i] and not possible else np.inf
        wrong[i] = time - since[i] >= PERSISTENCE
        found |= wrong[i]
    return found
