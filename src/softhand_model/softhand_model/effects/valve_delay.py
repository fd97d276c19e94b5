"""Valves that let air through for a shorter time than they are commanded to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class ValveDelay(FlowEffect):
    """The valve opens later than it closes: duration -> max(0, duration - delay).

    The integrals of friction and injector shrink in proportion. delay [s] is the one of opening
    less the one of closing, 20 to 40 ms each (section 4.3); a valve that closes more slowly than it
    opens has one below zero.
    """

    name = "valve_delay"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "delay",
            "s",
            -0.05,
            0.2,
            "time by which the open valve falls short of its command",
            typical=(0.002, 0.04),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "switching_volume": "takes off c*p_in*delay as a c3 below zero does, while no pulse is "
        "shorter than the delay",
        "pulse_bias": "alike while p_in varies little",
    }
    rank = -1

    def act_on_pulse(self, pulse: Pulse, mass: Array) -> Pulse:
        """The pulse with the time that the valve is open."""
        return pulse.lasting(np.maximum(pulse.duration - self.of("delay"), 0.0))
