"""Effects of a hand that only show when it moves."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.hand import HandEffect
from softhand_model.hand.hand import HandDescription
from softhand_model.hand.joint_stiffness import DAMPING_TIME

IN_MOTION = frozenset({"hand_motion"})
UNSEEN_AT_REST: Mapping[str, str] = {"hand_pose": "a hand at rest shows nothing of it"}


class JointDamping(HandEffect):
    """The rubber of all joints damps more or less: each spring has a Kelvin-Voigt damper of `time`
    times its stiffness, in place of that of the base model.
    """

    name = "joint_damping"
    experiments = IN_MOTION
    unseen_in = UNSEEN_AT_REST
    parameters = (
        Parameter(
            "time",
            "s",
            5e-4,
            0.3,
            "damping over stiffness",
            (0.004, 0.025),
            logarithmic=True,
            neutral=DAMPING_TIME,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "channel_lag": "both delay what pressure does: a wrist that moves shows damping alone"
    }

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """The whole hand."""
        return [{}]

    def damping_time(self) -> float | None:
        """Damping of all joints over their stiffness [s]."""
        return float(self.values["time"])


class ChannelLag(HandEffect):
    """A channel's pressure reaches its actuators through a tube: time_constant*p' = p_read - p.

    It is of first order, and exact for readings that are linear between samples. The air mass of
    the channel is counted as if the measured pressure were everywhere.
    """

    name = "channel_lag"
    experiments = IN_MOTION
    unseen_in = UNSEEN_AT_REST
    place_keys = ("channel",)
    parameters = (
        Parameter(
            "time_constant",
            "s",
            1e-4,
            5.0,
            "time in which the actuators follow",
            (0.01, 0.15),
            logarithmic=True,
        ),
    )

    @classmethod
    def places(cls, hand: HandDescription, markers: Collection[str] = ()) -> list[dict[str, str]]:
        """Every channel."""
        return [{"channel": name} for name in hand.channels]

    def lag_of(self, channel: str) -> float:
        """Time constant [s] with which the actuators of a channel follow its pressure."""
        return float(self.values["time_constant"]) if channel == self.where["channel"] else 0.0
