"""The flow effects of a model file in the plant, applied to each pulse of a valve."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from softhand_common.numerics.arrays import Array, Spools
from softhand_model.effects.pipeline import in_order, moved_mass
from softhand_model.effects.stages import FlowEffect, Pulse
from softhand_model.gas import CHOKED_PSI, psi
from softhand_model.pneumatics.air_flow import INLET, OUTLET, Contents

LARGEST_FLOW_RATIO = 5.0  # largest flow added by effects, over the choked flow of the open path


class PulseEffects:
    """The running pulses in the channels of a plant, and the air that flow effects add to them.

    A pulse lasts as long as its spool is open. The air that the valve of the plant has moved so far
    takes the place of the naive term `c*p_in*duration`; the other quantities of a pulse are those
    of the lab: pressures at switch-on, duration and integrals so far. What the effects make of the
    pulse, beyond what the valve moves, flows in the same step, so that at the end of a pulse the
    channel has what the effects predict for it. No step takes a channel above the pressure of the
    supply or below that of the surroundings because of effects, or adds more than
    `LARGEST_FLOW_RATIO` times the flow that the open path can pass (the mean flow at the very start
    of a pulse is not meaningful); the remaining air follows later in the pulse.

    Args:
        effects: flow effects of a model file.
        conductance: of the inlet and outlet paths with their valves open (2, n) [kg/(s Pa)].
        ambient_abs: absolute pressure of the surroundings [Pa].
    """

    def __init__(
        self, effects: Iterable[FlowEffect], conductance: Array, ambient_abs: float
    ) -> None:
        self.effects = in_order(effects)
        self._conductance = conductance
        self._ambient = ambient_abs
        channels = conductance.shape[1]
        self._spools: Spools = np.zeros(channels, dtype=np.int8)
        # rows: duration, p_in, p_out, friction_integral, injector_integral, mass by the valve alone
        self._columns: Array = np.zeros((6, channels))
        self._added: Array = np.zeros(channels)  # to the channel, in the pulse so far [kg]

    def reset(self) -> None:
        """Reset: all valves are closed."""
        self._spools[:], self._columns[:], self._added[:] = 0, 0.0, 0.0

    def leaked(self, dt: float, spools: Spools, pressure_abs: Array, capacity: Array) -> Array:
        """Air (n,) [kg] that channels with closed valves lose in `dt` [s], at most down to the
        pressure of the surroundings.

        Args:
            dt: step [s].
            spools: states (n,): +1 inflating, -1 deflating, 0 closed.
            pressure_abs: in the channels, absolute (n,) [Pa].
            capacity: of the channels (n,) [kg/Pa].
        """
        flow = np.zeros(len(spools))
        for effect in self.effects:
            flow = flow + np.reshape(effect.leak(pressure_abs), -1)
        self._check(flow, "leak")
        excess = (pressure_abs - self._ambient) * capacity
        lost = np.clip(flow * dt, np.minimum(excess, 0.0), np.maximum(excess, 0.0))
        return np.where(spools == 0, lost, 0.0)

    def add(
        self,
        dt: float,
        spools: Spools,
        supply_abs: float,
        before: Contents,
        contents: Contents,
        capacity: Array,
    ) -> float:
        """Add the air of the effects to that of the valves in `dt` [s].

        Args:
            dt: step [s].
            spools: states (n,) in this step: +1 inflating, -1 deflating, 0 closed.
            supply_abs: absolute pressure of the supply before the step [Pa].
            before: contents of the channels before the step.
            contents: the same after it; changed in place.
            capacity: of the channels (n,) [kg/Pa].

        Returns:
            Mass that has left the supply for it [kg].

        Raises:
            ValueError: an effect gives a mass that is not a finite number.
        """
        inflating = spools > 0
        pressure = before.air / capacity
        p_in = np.where(inflating, supply_abs, pressure)
        p_out = np.where(inflating, pressure, self._ambient)
        inflow, outflow = contents.inflow - before.inflow, contents.outflow - before.outflow
        self._begin(spools, p_in, p_out)
        flows = np.array([np.ones_like(p_in), p_in - p_out, p_in * psi(p_out / p_in)])
        self._columns[[0, 3, 4]] += dt * flows
        self._columns[5] += np.where(inflating, inflow, outflow)
        path = np.where(inflating, self._conductance[INLET], self._conductance[OUTLET])
        most = LARGEST_FLOW_RATIO * dt * CHOKED_PSI * path * p_in
        wanted = np.clip(self._predicted_excess() - self._added, -most, most)
        air = contents.air
        low = np.minimum(air, self._ambient * capacity)
        high = np.maximum(air, supply_abs * capacity)
        added = np.where(spools == 0, 0.0, np.clip(air + wanted, low, high) - air)
        self._added += added
        contents.air[:] += added
        contents.received[:] += np.maximum(added, 0.0)
        contents.net_flow[:] += added / dt
        contents.inflow[inflating] += added[inflating]
        contents.outflow[spools < 0] -= added[spools < 0]
        return float(added[inflating].sum())

    def _begin(self, spools: Spools, p_in: Array, p_out: Array) -> None:
        """Note the pressures of pulses that begin now."""
        new = spools != self._spools
        if new.any():
            start = np.zeros_like(self._columns)
            start[1], start[2] = p_in, p_out
            self._columns[:, new] = start[:, new]
            self._added[new] = 0.0
            self._spools = spools.copy()

    def _predicted_excess(self) -> Array:
        """Air (n,) [kg] in open channels by the effects, in excess of that moved by the valves."""
        is_open = self._spools != 0
        inflating = self._spools[None, is_open] > 0
        excess = np.zeros(len(is_open))
        if not is_open.any():
            return excess
        columns = self._columns[:, None, is_open]
        mass = moved_mass(Pulse(inflating, *columns), self.effects)
        self._check(mass, "mass")
        excess[is_open] = np.where(inflating, 1.0, -1.0)[0] * (mass - columns[5])[0]
        return excess

    def _check(self, values: Array, what: str) -> None:
        """Refuse values that a user's effect may wrongly return."""
        if not np.isfinite(values).all():
            names = ", ".join(effect.name for effect in self.effects)
            raise ValueError(
                f"flow effects {names}: expected a finite {what} for each channel, got {values}"
            )

    def save(self) -> tuple[Spools, Array, Array]:
        """Return a copy of the changing state."""
        return self._spools.copy(), self._columns.copy(), self._added.copy()

    def restore(self, saved: tuple[Spools, Array, Array]) -> None:
        """Restore what `save` returned."""
        spools, columns, added = saved
        self._spools, self._columns, self._added = spools.copy(), columns.copy(), added.copy()
