"""Ranges of the targets: possible contents of a channel below its pressure limit."""

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

Range = tuple[Floats, Floats]  # least and greatest value (n,)
# generous, so that no target is refused which some actuator could reach
LARGEST_GROWTH = 1.5  # largest volume in a known hand, over that in free posture at the limit
LARGEST_UNKNOWN_GROWTH = 10.0  # largest volume of an unknown actuator, over that at rest
SHORTEST_FILLING = 1e-3  # time in which a channel is filled, if no shortest pulse is set [s]


def target_ranges(settings: BoxSettings, model: VolumeModel) -> dict[str, Range]:
    """Ranges (n,) of the targets by mode, in the unit of the mode.

    The largest volume `V` is 1.5 times that of the hand in free posture at the pressure limit, or
    ten times the rest volume if only that is known. At the limit it contains
    `m = (p_max V - p_0 V_0)/(R_s T)` more air than at rest. The smallest targets are those of a
    vacuum; all negative targets empty a channel to ambient pressure. The largest flow fills the
    channel within the shortest pulse.

    Args:
        settings: settings of the box.
        model: model of the channels' volumes.
    """
    rest, limits = np.array(settings.rest_volumes), np.array(settings.pressure_limits)
    of_hand = settings.volume_model == "hand"
    volume = LARGEST_GROWTH * model.volumes(limits) if of_hand else LARGEST_UNKNOWN_GROWTH * rest
    heat, ambient = GAS_CONSTANT * settings.temperature, settings.ambient
    fill = ambient * rest / heat
    most = (ambient + limits) * volume / heat - fill
    fastest = (fill + most) / max(settings.shortest_pulse, SHORTEST_FILLING)
    return {
        "mass": (-fill, most),
        "mass_flow": (-fastest, fastest),
        "pressure": (np.full_like(limits, -ambient), limits),
        "volume": (-rest, volume - rest),
    }


def refusal(mode: str, channel: int, value: float, ranges: dict[str, Range]) -> str:
    """The allowed range in words if `value` is outside of it, else ""."""
    if mode not in ranges:
        return ""
    low, high = (float(bound[channel]) for bound in ranges[mode])
    return "" if low <= value <= high else f"{low:.3g} to {high:.3g} {MODES[mode].unit}"
