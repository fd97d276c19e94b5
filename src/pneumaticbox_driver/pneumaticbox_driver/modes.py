"""Table of the control modes: name, field of a command, unit of its targets."""

import math
from dataclasses import dataclass

from softhand_common.documents.quoted import quoted


@dataclass(frozen=True)
class Mode:
    """A control mode of a channel.

    `field` is that of a trajectory_msgs/JointTrajectoryPoint with the targets, `unit` that of the
    targets. `idle` is the target without effect, NaN if there is none. `scheduled` targets are
    steps, given by `pneumaticbox/valve_schedule`; others are interpolated linearly.
    """

    name: str
    field: str
    unit: str
    idle: float = math.nan
    scheduled: bool = False

    @property
    def absolute(self) -> bool:
        """Whether a target determines the content of the channel, so that 0 empties it."""
        return math.isnan(self.idle)


MODES = {
    mode.name: mode
    for mode in (
        Mode("mass", "positions", "kg"),  # air above that at rest and ambient pressure
        Mode("mass_flow", "velocities", "kg/s", idle=0.0),  # air that flows into the channel
        Mode("pressure", "effort", "Pa"),  # gauge
        Mode("volume", "positions", "m3"),  # above that at rest, for hands only
        Mode("time", "positions", "-", idle=0.0, scheduled=True),  # +1 in, -1 out, 0 closed
    )
}


def check_mode(name: str) -> Mode:
    """Return the control mode of a name.

    Raises:
        ValueError: no such mode; the message lists the existing ones.

    >>> check_mode("mass").unit
    'kg'
    """
    if name not in MODES:
        raise ValueError(f"control_mode must be one of {list(MODES)}, got {quoted(name)}")
    return MODES[name]
