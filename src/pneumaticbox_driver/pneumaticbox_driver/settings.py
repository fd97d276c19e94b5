"""Settings of the box, checked by their constructor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pneumaticbox_driver.modes import check_mode
from softhand_common.documents.quoted import quoted
from softhand_model.gas import AMBIENT_PRESSURE, ROOM_TEMPERATURE

MOST_CHANNELS = 8
NOT_NEGATIVE = (
    "command_timeout",
    "command_lead",
    "command_span",
    "shortest_pause",
    "shortest_pulse",
    "zero_band",
)
VOLUME_MODELS = ("hand", "fixed")


@dataclass(frozen=True)
class BoxSettings:
    """Settings of the box.

    `channels` are names in the order of the outlets, `rest_volumes` [m3] those at rest with the
    tubes, `pressure_limits` gauge [Pa], `control_modes` one per channel. `command_timeout` [s] is
    the time without a command after which the box vents, 0 to hold the last target. A command may
    begin up to `command_lead` [s] ahead of now and last up to `command_span` [s]. `shortest_pulse`
    and `shortest_pause` [s] are those of the valves, `zero_band` [Pa] is the largest offset of a
    sensor. `volume_model` is "fixed" for bottles, or "hand" for the actuators of `hand`, a name or
    a file; mode volume requires a hand.

    Raises:
        ValueError: names the setting, what was expected and what was found.
    """

    channels: tuple[str, ...]
    rest_volumes: tuple[float, ...]
    pressure_limits: tuple[float, ...]
    control_modes: tuple[str, ...]
    command_timeout: float = 0.0
    command_lead: float = 60.0
    command_span: float = 3600.0
    shortest_pulse: float = 0.045
    shortest_pause: float = 0.06
    zero_band: float = 5000.0
    ambient: float = AMBIENT_PRESSURE
    temperature: float = ROOM_TEMPERATURE
    start_enabled: bool = True
    volume_model: str = "fixed"
    hand: str = ""

    def __post_init__(self) -> None:
        n = len(self.channels)
        if not 1 <= n <= MOST_CHANNELS or len(set(self.channels)) < n:
            expected = f"1 to {MOST_CHANNELS} different names"
            raise ValueError(f"channels must be {expected}, got {quoted(list(self.channels))}")
        if not all(name and name.isidentifier() for name in self.channels):
            got = quoted(list(self.channels))
            raise ValueError(f"channels must be names of letters, digits and _, got {got}")
        for name in ("rest_volumes", "pressure_limits"):
            _check_positive(name, getattr(self, name), n)
        if self.volume_model not in VOLUME_MODELS:
            models, got = list(VOLUME_MODELS), self.volume_model
            raise ValueError(f"volume_model must be one of {models}, got {quoted(got)}")
        self.check_modes(self.control_modes)
        for name in NOT_NEGATIVE:
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} must be 0 or above, got {value}")

    def check_modes(self, modes: Sequence[str]) -> None:
        """Check that the channels can have these modes (n,).

        Raises:
            ValueError: wrong number of modes, an unknown mode, or mode volume with bottles.
        """
        n = len(self.channels)
        if len(modes) != n:
            raise ValueError(f"control_mode must have {n} entries, got {len(modes)}")
        for mode in modes:
            check_mode(mode)
        if "volume" in modes and self.volume_model == "fixed":
            raise ValueError(
                "control_mode 'volume' expects volume_model 'hand', got 'fixed': the volume of "
                "rigid bottles cannot be controlled"
            )


def _check_positive(name: str, values: Sequence[float], n: int) -> None:
    if len(values) != n:
        raise ValueError(f"{name} must have {n} values, one per channel, got {len(values)}")
    if not all(math.isfinite(value) and value > 0 for value in values):
        raise ValueError(f"{name} must be above 0, got {quoted(list(values))}")


def per_channel(name: str, given: Sequence[str], channels: int) -> tuple[str, ...]:
    """Repeat a setting with one entry for all channels.

    Raises:
        ValueError: neither one entry nor one per channel.

    >>> per_channel("control_mode", ["mass"], 3)
    ('mass', 'mass', 'mass')
    """
    if len(given) not in (1, channels):
        raise ValueError(f"{name} must have 1 or {channels} entries, got {len(given)}")
    return tuple(given) * channels if len(given) == 1 else tuple(given)


def outlet_numbers(given: Sequence[int], channels: int) -> tuple[int, ...]:
    """Outlet of each channel, counted from 1; a single 0 means 1, 2, ... in the channels' order.

    Raises:
        ValueError: not one per channel, or below 1.

    >>> outlet_numbers([0], 3), outlet_numbers([2, 1], 2)
    ((1, 2, 3), (2, 1))
    """
    if list(given) == [0]:
        return tuple(range(1, channels + 1))
    if len(given) != channels or min(given) < 1:
        expected = f"{channels} numbers from 1, one per channel"
        raise ValueError(f"outlets must be {expected}, got {quoted(list(given))}")
    return tuple(given)
