"""Ranges of the targets: what a channel can contain below its pressure limit."""

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

Range = tuple[Floats, Floats]  # least and greatest value (n,)
# generous, so that nothing is refused that some actuator could do
STRETCHED = 1.5  # volume of an actuator of a known hand over that in free posture at its limit
SWOLLEN = 10.0  # volume of an unknown actuator over that at rest
FASTEST = 1e-3  # in which a channel is filled or emptied, where no shortest pulse is set [s]


def target_ranges(settings: BoxSettings, model: VolumeModel) -> dict[str, Range]:
    """Ranges (n,) of the targets of each mode that has a quantity, in its unit.

    The greatest volume `V` is 1.5 times that of the hand's free posture at the pressure limit, or
    ten times the rest volume where that alone is known. At the limit it contains
    `m = (p_max V - p_0 V_0)/(R_s T)` more than at rest. The least is what a vacuum leaves: nothing
    of what is in it at rest; all targets below zero empty a channel to ambient pressure. The flow
    is that which does all of it within the shortest pulse.

    Args:
        settings: of the box.
        model: of the channels' volumes.
    """
    rest, limits = np.array(settings.rest_volumes), np.array(settings.pressure_limits)
    of_hand = settings.volume_model == "hand"
    volume = STRETCHED * model.volumes(limits) if of_hand else SWOLLEN * rest
    heat, ambient = GAS_CONSTANT * settings.temperature, settings.ambient
    fill = ambient * rest / heat
    most = (ambient + limits) * volume / heat - fill
    fastest = (fill + most) / max(settings.shortest_pulse, FASTEST)
    return {
        "mass": (-fill, most),
        "mass_flow": (-fastest, fastest),
        "pressure": (np.full_like(limits, -ambient), limits),
        "volume": (-rest, volume - rest),
    }


def refusal(mode: str, channel: int, value: float, ranges: dict[str, Range]) -> str:
    """What is expected of a target of this channel, "" when the `value` is within its range."""
    if mode not in ranges:
        return ""
    low, high = (float(bound[channel]) for bound in ranges[mode])
    return "" if low <= value <= high else f"{low:.3g} to {high:.3g} {MODES[mode].unit}"
