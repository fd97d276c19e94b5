"""Air that valve and dead volume move at each switching, whatever the duration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class SwitchingVolume(FlowEffect):
    """What a pulse moves by being switched: c3*p_in(t_on) + c4*p_out(t_on) (eq. 4.1).

    c3 and c4 [kg/Pa]; a dead volume V between valve and choke gives c3 = V/(R_s*T) = -c4 while
    inflating (1.8e-12 kg/Pa for 0.15 cm3). ERRATUM: while deflating p_out is ambient and constant,
    its column is collinear with the bias, so there is no c4 (Algorithm 1 lists it).
    """

    name = "switching_volume"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "c3_inflate",
            "kg/Pa",
            -1e-9,
            1e-9,
            "inlet's dead volume, filled from the supply",
            typical=(1e-12, 1e-11),
            neutral=0.0,
        ),
        Parameter(
            "c3_deflate",
            "kg/Pa",
            -1e-9,
            1e-9,
            "outlet's dead volume, filled from the channel",
            typical=(1e-12, 1e-11),
            neutral=0.0,
        ),
        Parameter(
            "c4_inflate",
            "kg/Pa",
            -1e-9,
            1e-9,
            "what the channel's pressure holds back",
            typical=(-1e-11, -1e-12),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "valve_delay": "a delay takes off c*p_in*delay, which is a c3 below zero",
        "pulse_bias": "alike while p_in varies little",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the switching terms added."""
        channel = np.where(pulse.inflating, self.of("c4_inflate"), 0.0) * pulse.p_out
        return mass + self.by_direction("c3", pulse) * pulse.p_in + channel
