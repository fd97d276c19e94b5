"""Flow effects: the air mass that a valve pulse moves (eq. 4.1 and what it leaves out)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import FlowEffect, Pulse
from softhand_model.gas import AMBIENT_PRESSURE

Described = tuple[str, tuple[float, float]]
"""Description and usual range of a parameter."""


def _each_way(
    name: str, either: Parameter, inflate: Described, deflate: Described
) -> tuple[Parameter, Parameter]:
    """A parameter for each direction of a pulse: unit, bounds and what else is alike, from one."""
    return (
        replace(either, name=f"{name}_inflate", description=inflate[0], typical=inflate[1]),
        replace(either, name=f"{name}_deflate", description=deflate[0], typical=deflate[1]),
    )


class InjectorFlow(FlowEffect):
    """Choked and unchoked flow through a small orifice: c2*int(p_in*Psi(p_out/p_in)) dt (eq. 4.1).

    Replaces the naive term c*p_in*duration, with which it is collinear while the flow is choked.
    c2 [kg/(s Pa)] is the conductance of choke and valve in series (`gas.orifice_conductance`), one
    value for each direction.
    """

    name = "injector_flow"
    parameters = _each_way(
        "c2",
        Parameter("", "kg/(s Pa)", 1e-12, 1e-7, logarithmic=True),
        inflate=("conductance of the inlet's choke", (8e-11, 2.5e-10)),
        deflate=("conductance of the outlet's choke", (5e-10, 2e-9)),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "calibration": "collinear with the naive term, which it replaces, while the flow is choked",
        "line_friction": "both grow as the channel nears p_in; varied supply tells them apart",
    }
    replaces_naive = True

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the injector term in place of the naive one."""
        term = self.by_direction("c2", pulse) * pulse.injector_integral
        return mass - pulse.naive + term


class LineFriction(FlowEffect):
    """Flow against the viscous friction of the walls: c1*int(p_in - p_out) dt (eq. 4.1).

    The thesis adds it to the flow through the choke although both resistances lie in series. So a
    negative c1 beside `injector_flow` makes sense: the tube reduces what the choke would pass.
    """

    name = "line_friction"
    parameters = _each_way(
        "c1",
        Parameter("", "kg/(s Pa)", -1e-8, 1e-8, neutral=0.0),
        inflate=("conductance of the line to the channel", (1e-12, 5e-11)),
        deflate=("conductance of the line from the channel", (1e-11, 5e-10)),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "injector_flow": "both fall as the pressures even out",
        "leakage": "inflating, c1*(p_in - p_out) and a leak both fall linearly with p_out",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the friction term added."""
        return mass + self.by_direction("c1", pulse) * pulse.friction_integral


class SwitchingVolume(FlowEffect):
    """Air that a pulse moves by switching alone: c3*p_in(t_on) + c4*p_out(t_on) (eq. 4.1).

    c3 and c4 [kg/Pa]; a dead volume V between valve and choke gives c3 = V/(R_s*T) = -c4 while
    inflating (1.8e-12 kg/Pa for 0.15 cm3). ERRATUM: while deflating p_out is ambient and constant,
    its column is collinear with the bias, so there is no c4 (Algorithm 1 lists it).
    """

    name = "switching_volume"
    parameters = (
        *_each_way(
            "c3",
            Parameter("", "kg/Pa", -1e-9, 1e-9, neutral=0.0),
            inflate=("inlet's dead volume, filled from the supply", (1e-12, 1e-11)),
            deflate=("outlet's dead volume, filled from the channel", (1e-12, 1e-11)),
        ),
        Parameter(
            "c4_inflate",
            "kg/Pa",
            -1e-9,
            1e-9,
            "what the channel's pressure holds back",
            (-1e-11, -1e-12),
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


class PulseBias(FlowEffect):
    """The bias c0 [kg] of a pulse, with one value per direction: the mean error of the other terms
    (eq. 4.1).
    """

    name = "pulse_bias"
    parameters = _each_way(
        "c0",
        Parameter("", "kg", -1e-4, 1e-4, neutral=0.0),
        inflate=("mass added to every inflating pulse", (1e-7, 2e-6)),
        deflate=("mass added to every deflating pulse", (1e-7, 2e-6)),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "switching_volume": "alike while p_in varies little",
        "valve_delay": "a delay takes off c*p_in*delay, a bias while p_in varies little",
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the bias added."""
        return mass + self.by_direction("c0", pulse)


class ValveDelay(FlowEffect):
    """The valve opens later than it closes: duration -> max(0, duration - delay).

    The integrals of friction and injector shrink in proportion. The delay [s] is that of opening
    less that of closing, 20 to 40 ms each (section 4.3); negative if the valve closes more slowly.
    """

    name = "valve_delay"
    parameters = (
        Parameter(
            "delay",
            "s",
            -0.05,
            0.2,
            "time by which the open valve falls short of its command",
            (0.002, 0.04),
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
        """The pulse with the time for which the valve is open."""
        return pulse.lasting(np.maximum(pulse.duration - self.of("delay"), 0.0))


class Leakage(FlowEffect):
    """Air that leaks from the channel during a pulse: mass - conductance*(p_channel - p_ambient)
    *duration.

    p_channel [Pa] is p_out inflating and p_in deflating, at switch-on; p_ambient is 101.3 kPa; the
    conductance is that of a laminar gap. The simulator's channels leak between pulses, too.
    """

    name = "leakage"
    parameters = (
        Parameter(
            "conductance",
            "kg/(s Pa)",
            0.0,
            1e-8,
            "mass flow of the leak per gauge pressure",
            (1e-12, 5e-11),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "line_friction": "inflating, c1*(p_in - p_out) and a leak both fall linearly with p_out"
    }

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] less what leaks."""
        channel = np.where(pulse.inflating, pulse.p_out, pulse.p_in)
        return mass - self.leak(channel) * pulse.duration

    def leak(self, pressure_abs: Array) -> Array:
        """Air [kg/s] that leaks from a channel at an absolute pressure [Pa]."""
        return self.of("conductance") * (pressure_abs - AMBIENT_PRESSURE)


class SupplyDroop(FlowEffect):
    """While inflating, the supply pressure falls with the mean flow: p_in -> p_in -
    resistance*mass/duration.

    The mass [kg] is the pulse's own, so the equation is implicit. The integrals are measured, with
    the supply as it was, and are not changed.
    """

    name = "supply_droop"
    parameters = (
        Parameter(
            "resistance",
            "Pa s/kg",
            0.0,
            1e11,
            "loss of supply pressure per mass flow",
            (1e8, 1e10),
            neutral=0.0,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "calibration": "with the naive term c*p_in*duration alone a factor 1/(1 + resistance*c) "
        "on c while inflating; it shows beside switching_volume only"
    }

    def act_on_pulse(self, pulse: Pulse, mass: Array) -> Pulse:
        """The pulse with the lowered supply pressure."""
        lasting = np.where(pulse.duration > 0.0, pulse.duration, np.inf)
        loss = np.where(pulse.inflating, self.of("resistance") * mass / lasting, 0.0)
        return pulse.fed_at(pulse.p_in - loss)


class PolytropicGas(FlowEffect):
    """A measured mass dp*V/(R_s*T) of air that changes by p*V**n = const is n times the true one.

    exponent n: 1 isothermal (the base), 1.4 adiabatic. It is a mere factor on the mass.
    """

    name = "polytropic_gas"
    parameters = (
        Parameter("exponent", "", 1.0, 1.4, "of the change of state", (1.02, 1.35), neutral=1.0),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        "valve_pulse": "a mere factor on the mass, which the calibration of both directions takes "
        "up"
    }
    confounded_with: ClassVar[Mapping[str, str]] = {"calibration": "a factor on both directions"}
    rank = 1

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] as measured by someone who assumes isothermal air."""
        return mass * self.of("exponent")
