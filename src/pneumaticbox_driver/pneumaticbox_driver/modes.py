"""Table of the control modes: name, field of a command, unit of its targets."""

import math
from dataclasses import dataclass

from softhand_model.documents.quoted import quoted


@dataclass(frozen=True)
class Mode:
    """A control mode of a channel.

    `field` is that of a trajectory_msgs/JointTrajectoryPoint which holds the targets, `unit` is
    theirs. `idle` is the target that asks for nothing, NaN where every target asks for something.
    Targets that are `scheduled` come as steps, by `pneumaticbox/valve_schedule`; the others go
    linearly from point to point.
    """

    name: str
    field: str
    unit: str
    idle: float = math.nan
    scheduled: bool = False

    @property
    def absolute(self) -> bool:
        """Whether a target says how much air the channel shall hold, so that 0 empties it."""
        return math.isnan(self.idle)


MODES = {
    mode.name: mode
    for mode in (
        Mode("mass", "positions", "kg"),  # air above the fill at rest and ambient pressure
        Mode("mass_flow", "velocities", "kg/s", idle=0.0),  # air that flows into the channel
        Mode("pressure", "effort", "Pa"),  # gauge
        Mode("volume", "positions", "m3"),  # above that at rest, for a hand alone
        Mode("time", "positions", "-", idle=0.0, scheduled=True),  # +1 in, -1 out, 0 closed
    )
}


def check_mode(name: str) -> Mode:
    """Return the control mode of a name.

    Raises:
        ValueError: no such mode; the message lists what there is.

    >>> check_mode("mass").unit
    'kg'
    """
    if name not in MODES:
        raise ValueError(f"control_mode must be one of {list(MODES)}, got {quoted(name)}")
    return MODES[name]
