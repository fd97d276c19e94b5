"""Control of pressure or volume by single pulses, evaluated after settling (section 4.1).

During flow the reading of a pressure sensor in the box includes the pressure drop along the tube,
and the valve's delay makes it late. A pulse is therefore not controlled by the sensor: the required
air mass is computed when the pulse begins, the observer tells when it has moved, and the pressure
is evaluated again after settling.
"""

from typing import Protocol

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.control.interface import LEAST_ERROR, OPENING_SHARE, BoxView
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY
from pneumaticbox_driver.observer.volume_model import pressure_after
from pneumaticbox_driver.safety import RELIEF_END

JUDGING_DELAY = 0.12  # from the command that closes a valve to the average of the pressure [s]
LEAST_AVERAGED = 10  # samples in the average before the pressure is evaluated
AVERAGED_SAMPLES = 50  # in the average
PRESSURE_NOISE = 100.0  # of one sample of a channel's pressure, converter included, one sigma [Pa]
SIGNIFICANT_RISE = 3.0  # times the noise of the average; smaller errors cause no pulse [-]
LEARNING_SCALE = 500.0  # change of pressure by which a pulse has the weight of all before [Pa]
FOREIGN_CHANGE = 1000.0  # change of pressure without a pulse that means a contact or release [Pa]
PLAUSIBLE_RATIO = (0.2, 10.0)  # of the required air mass over that of the model
INFLATION_CEILING = RELIEF_END  # share of the pressure limit at which inflation ends [-]
State = tuple[Floats, Floats]  # gauge pressures [Pa] and volumes [m3], (n,) each


class Quantity(Protocol):
    """The controlled quantity; its values (n,) are in the unit of the quantity."""

    def state(self, view: BoxView, pressures: Floats) -> State:
        """Present state, from averaged gauge `pressures` (n,) [Pa]."""
        ...

    def value(self, view: BoxView, state: State) -> Floats:
        """Value of the quantity in a state (n,)."""
        ...

    def goal(self, view: BoxView, state: State, value: Floats) -> State:
        """State with the given values (n,), reached from `state` by a free actuator."""
        ...

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """Weight of a pulse in learning, as a change of pressure (n,) [Pa]; 0 for none.

        Args:
            view: state of the box.
            change: change of the quantity by the pulse (n,).
            moved: air mass of the pulse (n,) [kg].
        """
        ...

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the measured quantity has passed the setpoint by a `margin` of pressure [Pa]."""
        ...


class PulsewiseController:
    """Opens a valve for the air mass that the volume model requires, and learns from the pulse.

    After a pulse, the moved air mass is divided by the mass that the model requires for the
    measured change. This ratio describes the compliance of the actuator, free or in contact, and
    scales the next pulse, so that a wrong model does not cause alternating pulses. In contact a
    change of pressure needs less air than in free posture, and a change of volume more. If no air
    mass changes the volume, inflation ends at the pressure limit and `saturated` (n,) is set. The
    ratio is reset when the pressure changes without a pulse, as the contact has changed.

    Args:
        quantity: the quantity to control.
    """

    def __init__(self, quantity: Quantity) -> None:
        self._quantity = quantity
        self._rest: Floats = np.empty(0)  # time since the valve was closed [s]
        self.saturated: Flags = np.zeros(0, dtype=bool)

    def _begin(self, view: BoxView) -> None:
        n = len(view.pressures_abs)
        self._rest = np.full(n, JUDGING_DELAY)
        self._count = np.zeros(n)  # of samples in the average
        self._mean = view.pressures_abs - view.ambient
        self._ratio = np.ones(n)
        self._pulsed, self.saturated = np.zeros((2, n), dtype=bool)  # _pulsed: not evaluated
        self._left_at = self._mean.copy()  # gauge pressure at the last evaluation [Pa]
        self._start_gauge, self._start_volume, self._start_mass = np.zeros((3, n))

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        if not len(self._rest):
            self._begin(view)
        is_open = view.direction != 0
        self._average(view, is_open)
        settled = ~is_open & (self._count >= LEAST_AVERAGED) & view.mine
        wanted = np.zeros_like(view.direction)
        if (is_open & view.mine).any():
            wanted = np.where(self._unfinished(view), view.direction, 0)
        if settled.any():
            wanted = np.where(settled, self._opened(view, settled), wanted)
        # a target of zero or below empties the channel to ambient pressure
        emptied = np.where(view.empty, 0, -1)
        return np.where(view.setpoints <= 0, emptied, wanted).astype(np.int8)

    def _average(self, view: BoxView, is_open: Flags) -> None:
        self._rest = np.where(is_open, 0.0, self._rest + view.dt)
        self._count = np.where(self._rest < JUDGING_DELAY, 0.0, self._count + 1.0)
        weight = 1.0 / np.clip(self._count, 1.0, AVERAGED_SAMPLES)
        self._mean = self._mean + weight * (view.pressures_abs - view.ambient - self._mean)

    def _modelled(self, view: BoxView, state: State, value: Floats) -> tuple[Floats, Floats]:
        """Air mass [kg] from a state to a value by the model, and the rise of pressure [Pa]."""
        goal = self._quantity.goal(view, state, value)
        return _product(view, *goal) - _product(view, *state), goal[0] - state[0]

    def _needed(self, view: BoxView, state: State) -> tuple[Floats, Floats]:
        """Air mass [kg] from a state to the setpoint and rise of pressure [Pa]; 0 without one."""
        value = np.where(
            np.isnan(view.setpoints),
            self._quantity.value(view, state),
            np.maximum(view.setpoints, 0.0),
        )
        air, rise = self._modelled(view, state, value)
        return self._ratio * air, rise

    def _opened(self, view: BoxView, settled: Flags) -> Valves:
        state = pressures, volume = self._quantity.state(view, self._mean)
        self._forget(settled, pressures)
        self._learn(view, settled & self._pulsed, state)
        needed, rise = self._needed(view, state)
        count = np.clip(self._count, 1.0, AVERAGED_SAMPLES)
        sure = np.abs(rise) > SIGNIFICANT_RISE * PRESSURE_NOISE / np.sqrt(count)
        opened = np.where(sure, _worth_a_pulse(view, needed), 0)
        full = (opened > 0) & ~_has_room(view, pressures, volume)
        self.saturated = np.where(settled, full, self.saturated)
        opened = np.where(full, 0, opened)
        begun = settled & ((opened != 0) | (view.setpoints <= 0))
        self._start_gauge = np.where(begun, pressures, self._start_gauge)
        self._start_volume = np.where(begun, volume, self._start_volume)
        self._start_mass = np.where(begun, view.observer.mass, self._start_mass)
        self._pulsed |= begun
        return opened.astype(np.int8)

    def _forget(self, settled: Flags, pressures: Floats) -> None:
        """Reset the ratio of channels whose pressure has changed without a pulse."""
        foreign = settled & ~self._pulsed & (np.abs(pressures - self._left_at) > FOREIGN_CHANGE)
        self._ratio = np.where(foreign, 1.0, self._ratio)
        seen = foreign | (settled & self._pulsed)
        self._left_at = np.where(seen, pressures, self._left_at)

    def _learn(self, view: BoxView, judged: Flags, state: State) -> None:
        """Compare the air masses of the last pulses with those of the model for their effects."""
        if not judged.any():
            return
        self._pulsed &= ~judged
        moved = view.observer.mass - self._start_mass
        start = self._start_gauge, self._start_volume
        value = self._quantity.value(view, state)
        asked, _ = self._modelled(view, start, value)
        change = value - self._quantity.value(view, start)
        evidence = self._quantity.evidence(view, change, moved)
        # pulses without effect, or with the opposite one, get the largest plausible ratio
        least = np.maximum(np.abs(moved), LEAST_ERROR) / PLAUSIBLE_RATIO[1]
        ratio = np.abs(moved) / np.maximum(np.sign(moved) * asked, least)
        weight = np.where(judged, evidence / (evidence + LEARNING_SCALE), 0.0)
        ratio = np.where(weight > 0, np.maximum(ratio, PLAUSIBLE_RATIO[0]), 0.0)
        self._ratio = self._ratio + weight * (ratio - self._ratio)

    def _unfinished(self, view: BoxView) -> Flags:
        needed, _ = self._needed(view, (self._start_gauge, self._start_volume))
        left = needed - (view.observer.mass - self._start_mass)
        margin = (0.5 * view.dt) * np.abs(view.observer.flow)
        passed = self._quantity.passed(view, SIGNIFICANT_RISE * PRESSURE_NOISE)
        gauge = view.pressures_abs - view.ambient
        to_come = VALVE_DELAY * view.observer.flow * view.gas / view.volume_at(view.pressures_abs)
        full = (view.direction > 0) & (gauge + to_come > INFLATION_CEILING * view.limits)
        return np.asarray((view.direction * left > margin) & ~passed & ~full)


def _worth_a_pulse(view: BoxView, needed: Floats) -> Valves:
    """Valves (n,) to open for the masses `needed` (n,) [kg].

    A valve opens only for more than OPENING_SHARE of the mass of the smallest pulse by equation
    4.1, so that a pulse always reduces the error.
    """
    gain, loss = view.observer.pulse_mass(view.shortest_pulse, view.pressures_abs, view.supply_abs)
    inflate = needed > np.maximum(OPENING_SHARE * gain, LEAST_ERROR)
    deflate = -needed > np.maximum(OPENING_SHARE * loss, LEAST_ERROR)
    return inflate.astype(np.int8) - deflate.astype(np.int8)


def _has_room(view: BoxView, pressures: Floats, volume: Floats) -> Flags:
    """Channels that stay below the ceiling in the smallest pulse, even with a rigid volume (n,)."""
    gain, _ = view.observer.pulse_mass(view.shortest_pulse, view.pressures_abs, view.supply_abs)
    return np.asarray(pressures + gain * view.gas / volume < INFLATION_CEILING * view.limits)


def _product(view: BoxView, pressures: Floats, volume: Floats) -> Floats:
    """Air masses (n,) [kg] in volumes [m3] at gauge pressures [Pa]."""
    return np.asarray((pressures + view.ambient) * volume / view.gas)


class Pressure:
    """The measured gauge pressure; setpoints in [Pa]. The volume is that of the model."""

    def state(self, view: BoxView, pressures: Floats) -> State:
        """Gauge pressures [Pa] and volumes [m3] now (n,)."""
        return pressures, view.volume_model.volumes(pressures)

    def value(self, view: BoxView, state: State) -> Floats:
        """The gauge pressures (n,) [Pa]."""
        return state[0]

    def goal(self, view: BoxView, state: State, value: Floats) -> State:
        """Gauge pressures [Pa] and volumes [m3] at the gauge pressures `value` (n,) [Pa]."""
        pressures, volume = state
        model = view.volume_model
        return value, volume + model.volumes(value) - model.volumes(pressures)

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """How much each pulse counts in learning: the size (n,) [Pa] of the measured change of
        pressure; 0 if it is within the noise, or has the wrong sign for the moved air.
        """
        size = np.where(change * moved > 0, np.abs(change), 0.0)
        return np.where(size > PRESSURE_NOISE, size, 0.0)

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the pressure has passed its setpoint by a `margin` [Pa] (n,)."""
        beyond = view.pressures_abs - view.ambient - view.setpoints
        return np.asarray(view.direction * beyond > margin)


class Volume:
    """The estimated volume `m R_s T/p_abs`; setpoints in [m3] above rest."""

    def state(self, view: BoxView, pressures: Floats) -> State:
        """Gauge pressures [Pa] and volumes [m3] now (n,)."""
        return pressures, view.volume_at(pressures + view.ambient)

    def value(self, view: BoxView, state: State) -> Floats:
        """The volumes above those at rest (n,) [m3]."""
        return state[1] - view.rest_volumes

    def goal(self, view: BoxView, state: State, value: Floats) -> State:
        """Gauge pressures [Pa] and volumes [m3] at the volumes `value` above rest (n,) [m3]."""
        pressures, volume = state
        target = value + view.rest_volumes
        return pressure_after(view.volume_model, pressures, target - volume), target

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """Change of pressure (n,) [Pa] by the moved air in a rigid volume."""
        size = np.abs(moved) * view.gas / view.volume_at(view.pressures_abs)
        return np.where(size > PRESSURE_NOISE, size, 0.0)

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the volume has passed its setpoint by a `margin` of pressure [Pa] (n,)."""
        volume = view.volume_at(view.pressures_abs)
        beyond = volume - view.rest_volumes - view.setpoints
        return np.asarray(view.direction * beyond > volume * margin / view.pressures_abs)
