"""Control of pressure or volume by single pulses, each judged when it has settled (section 4.1).

While air flows a pressure sensor in the box sees the drop along the tube, and the valve's delay
makes what it reads old. So a pulse is not closed in a loop around the sensor: the air that it takes
to reach the target is computed when it begins, the observer says when it has moved, and the
pressure is judged anew when it has settled.
"""

from typing import Protocol

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.control.interface import LEAST_ERROR, OPENING_SHARE, BoxView
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY
from pneumaticbox_driver.observer.volume_model import pressure_after
from pneumaticbox_driver.safety import RELIEF_END

SETTLING = 0.12  # from the command that closes a valve until the pressure is judged [s]
LEAST_SAMPLES = 10  # that are averaged before it is judged
MOST_SAMPLES = 50  # over which the average reaches back
NOISE = 100.0  # of one sample of a channel's pressure, converter included, one sigma [Pa]
SIGNIFICANT = 3.0  # times the noise of the average: a pulse is not opened for less [-]
LESSON = 500.0  # change, as one of pressure, by which a pulse tells as much as all before it [Pa]
FOREIGN = 1000.0  # change of pressure without a pulse: something pushed, or let go [Pa]
PLAUSIBLE_RATIO = (0.2, 10.0)  # of the air that it took over the air that the model asks for
CEILING = RELIEF_END  # of the pressure limit; nothing is inflated beyond it [-]
State = tuple[Floats, Floats]  # gauge pressures [Pa] and volumes [m3], (n,) each


class Quantity(Protocol):
    """What is controlled, by its values (n,) in its own unit."""

    def state(self, view: BoxView, pressures: Floats) -> State:
        """State now, from averaged gauge `pressures` (n,) [Pa]."""
        ...

    def value(self, view: BoxView, state: State) -> Floats:
        """What is controlled, in a state."""
        ...

    def goal(self, view: BoxView, state: State, value: Floats) -> State:
        """State in which a free actuator has a `value`, as seen from the present one."""
        ...

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """How much a pulse tells, as a change of pressure (n,) [Pa]; 0 for nothing.

        Args:
            view: of the box.
            change: of what is controlled, by the pulse.
            moved: air, by the pulse (n,) [kg].
        """
        ...

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the measured quantity has passed the setpoint by a `margin` of pressure [Pa]."""
        ...


class PulsewiseController:
    """Opens a valve for the air that is needed by the volume model, and learns from the pulse.

    The ratio of the air that a pulse moved over that which the model asks for what it did to the
    controlled quantity tells how compliant the actuator is where it is now, free or against an
    object; the next pulse is shortened or lengthened by it, so that a wrong model does not make
    the valves take turns. Against an object a change of pressure takes less air than in free
    posture and a change of volume takes more, up to a volume that no air changes: then the
    pressure limit ends it, and `saturated` (n,) says so. What was learnt is forgotten when the
    pressure changes by itself: the actuator has met an object, or left it.

    Args:
        quantity: that is controlled.
    """

    def __init__(self, quantity: Quantity) -> None:
        self._quantity = quantity
        self._rest: Floats = np.empty(0)  # for which the valve has been closed [s]
        self.saturated: Flags = np.zeros(0, dtype=bool)

    def _begin(self, view: BoxView) -> None:
        n = len(view.pressures_abs)
        self._rest = np.full(n, SETTLING)
        self._count = np.zeros(n)  # of samples in the average
        self._mean = view.pressures_abs - view.ambient
        self._ratio = np.ones(n)
        self._pulsed, self.saturated = np.zeros((2, n), dtype=bool)  # _pulsed: not judged yet
        self._left_at = self._mean.copy()  # gauge pressure at the last look [Pa]
        self._start_gauge, self._start_volume, self._start_mass = np.zeros((3, n))

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        if not len(self._rest):
            self._begin(view)
        is_open = view.direction != 0
        self._average(view, is_open)
        settled = ~is_open & (self._count >= LEAST_SAMPLES) & view.mine
        wanted = np.zeros_like(view.direction)
        if (is_open & view.mine).any():
            wanted = np.where(self._unfinished(view), view.direction, 0)
        if settled.any():
            wanted = np.where(settled, self._opened(view, settled), wanted)
        # there is no less than empty: the outlet is open until the channel is at ambient pressure
        emptied = np.where(view.empty, 0, -1)
        return np.where(view.setpoints <= 0, emptied, wanted).astype(np.int8)

    def _average(self, view: BoxView, is_open: Flags) -> None:
        self._rest = np.where(is_open, 0.0, self._rest + view.dt)
        self._count = np.where(self._rest < SETTLING, 0.0, self._count + 1.0)
        weight = 1.0 / np.clip(self._count, 1.0, MOST_SAMPLES)
        self._mean = self._mean + weight * (view.pressures_abs - view.ambient - self._mean)

    def _modelled(self, view: BoxView, state: State, value: Floats) -> tuple[Floats, Floats]:
        """Air [kg] that leads from a state to a value by the model, and the rise [Pa]."""
        goal = self._quantity.goal(view, state, value)
        return _product(view, *goal) - _product(view, *state), goal[0] - state[0]

    def _needed(self, view: BoxView, state: State) -> tuple[Floats, Floats]:
        """Air [kg] that leads from a state to the setpoint, and the rise [Pa]; without one 0."""
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
        count = np.clip(self._count, 1.0, MOST_SAMPLES)
        sure = np.abs(rise) > SIGNIFICANT * NOISE / np.sqrt(count)
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
        """Begin to learn anew where the pressure has changed by itself since it was left."""
        foreign = settled & ~self._pulsed & (np.abs(pressures - self._left_at) > FOREIGN)
        self._ratio = np.where(foreign, 1.0, self._ratio)
        seen = foreign | (settled & self._pulsed)
        self._left_at = np.where(seen, pressures, self._left_at)

    def _learn(self, view: BoxView, judged: Flags, state: State) -> None:
        """Compare what the last pulses moved with what the model asks for what they did."""
        if not judged.any():
            return
        self._pulsed &= ~judged
        moved = view.observer.mass - self._start_mass
        start = self._start_gauge, self._start_volume
        value = self._quantity.value(view, state)
        asked, _ = self._modelled(view, start, value)
        change = value - self._quantity.value(view, start)
        evidence = self._quantity.evidence(view, change, moved)
        # pulses that have done nothing, or less: the most air that is plausible
        least = np.maximum(np.abs(moved), LEAST_ERROR) / PLAUSIBLE_RATIO[1]
        ratio = np.abs(moved) / np.maximum(np.sign(moved) * asked, least)
        weight = np.where(judged, evidence / (evidence + LESSON), 0.0)
        ratio = np.where(weight > 0, np.maximum(ratio, PLAUSIBLE_RATIO[0]), 0.0)
        self._ratio = self._ratio + weight * (ratio - self._ratio)

    def _unfinished(self, view: BoxView) -> Flags:
        needed, _ = self._needed(view, (self._start_gauge, self._start_volume))
        left = needed - (view.observer.mass - self._start_mass)
        margin = (0.5 * view.dt) * np.abs(view.observer.flow)
        passed = self._quantity.passed(view, SIGNIFICANT * NOISE)
        gauge = view.pressures_abs - view.ambient
        to_come = VALVE_DELAY * view.observer.flow * view.gas / view.volume_at(view.pressures_abs)
        full = (view.direction > 0) & (gauge + to_come > CEILING * view.limits)
        return np.asarray((view.direction * left > margin) & ~passed & ~full)


def _worth_a_pulse(view: BoxView, needed: Floats) -> Valves:
    """Which valves to open for masses (n,) [kg] that are `needed`.

    None opens for less than a good half of what the smallest pulse would move from the present
    pressures, by equation 4.1: so a pulse always leaves a smaller error than it found.
    """
    gain, loss = view.observer.pulse_mass(view.shortest_pulse, view.pressures_abs, view.supply_abs)
    inflate = needed > np.maximum(OPENING_SHARE * gain, LEAST_ERROR)
    deflate = -needed > np.maximum(OPENING_SHARE * loss, LEAST_ERROR)
    return inflate.astype(np.int8) - deflate.astype(np.int8)


def _has_room(view: BoxView, pressures: Floats, volume: Floats) -> Flags:
    """Where the smallest pulse stays below the ceiling, whether or not the volume gives way."""
    gain, _ = view.observer.pulse_mass(view.shortest_pulse, view.pressures_abs, view.supply_abs)
    return np.asarray(pressures + gain * view.gas / volume < CEILING * view.limits)


def _product(view: BoxView, pressures: Floats, volume: Floats) -> Floats:
    """Air (n,) [kg] in volumes at gauge pressures."""
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
        """Gauge pressures [Pa] and volumes [m3] at other pressures (n,)."""
        pressures, volume = state
        model = view.volume_model
        return value, volume + model.volumes(value) - model.volumes(pressures)

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """The change of pressure itself (n,) [Pa], if it is that of the air."""
        size = np.where(change * moved > 0, np.abs(change), 0.0)
        return np.where(size > NOISE, size, 0.0)

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
        """Gauge pressures [Pa] and volumes [m3] at other volumes above rest (n,)."""
        pressures, volume = state
        target = value + view.rest_volumes
        return pressure_after(view.volume_model, pressures, target - volume), target

    def evidence(self, view: BoxView, change: Floats, moved: Floats) -> Floats:
        """What the air would do to the pressure of a volume that does not give way (n,) [Pa]."""
        size = np.abs(moved) * view.gas / view.volume_at(view.pressures_abs)
        return np.where(size > NOISE, size, 0.0)

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the volume has passed its setpoint by a `margin` of pressure [Pa] (n,)."""
        volume = view.volume_at(view.pressures_abs)
        beyond = volume - view.rest_volumes - view.setpoints
        return np.asarray(view.direction * beyond > volume * margin / view.pressures_abs)
