"""Bang-bang control of the air mass (section 4.4) and of the mass flow (section 4.3)."""

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.control.interface import (
    LEAST_ERROR,
    OPENING_SHARE,
    BoxView,
)
from softhand_common.numerics.compiled import compiled

LONGEST_REFERENCE_LEAD = 3.0  # of the reference over the estimate, in smallest pulses [-]


class MassController:
    """Opens a valve when the error exceeds the threshold, closes it when the error changes sign.

    The threshold is OPENING_SHARE of the mass of the smallest pulse, so that the final error is
    below the mass of one smallest pulse. The observer estimates the mass after the valve has
    closed, which compensates the delay of the valve.

    A target of zero or below empties the channel to ambient pressure, where its mass is known.
    """

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        return follow_mass(view, view.setpoints)


def follow_mass(view: BoxView, target: Floats) -> Valves:
    """Valves (n,) that bring the estimated masses to a `target` (n,) [kg], NaN for none."""
    observer = view.observer
    pulses = observer.pulse_mass(view.shortest_pulse, view.pressures_abs, view.supply_abs)
    wanted = np.empty_like(view.direction)
    # a valve closes at the sample that is nearest to the target
    ahead = 0.5 * view.dt
    now = observer.mass, observer.flow
    _decide(target, now, pulses, view.direction, view.empty, ahead, wanted)
    return wanted


def rehearse_mass_control(channels: int) -> None:
    """Compile or load the kernel of mass control, so that the first sample need not wait for it."""
    zeros, valves = np.zeros(channels), np.zeros(channels, dtype=np.int8)
    pair = zeros, zeros
    _decide(zeros, pair, pair, valves, np.zeros(channels, dtype=bool), 0.0, valves)


@compiled
def _decide(
    target: Floats,
    now: tuple[Floats, Floats],
    pulses: tuple[Floats, Floats],
    direction: Valves,
    empty: Flags,
    ahead: float,
    wanted: Valves,
) -> None:
    mass, flow = now
    gain, loss = pulses
    for i in range(len(target)):
        error = target[i] - mass[i]
        wanted[i] = 0
        if target[i] <= 0:
            # at ambient pressure the channel is empty and its mass known
            wanted[i] = 0 if empty[i] else -1
        elif direction[i] != 0:
            if direction[i] * error > ahead * abs(flow[i]):
                wanted[i] = direction[i]
        elif error > max(OPENING_SHARE * gain[i], LEAST_ERROR):
            wanted[i] = 1
        elif -error > max(OPENING_SHARE * loss[i], LEAST_ERROR):
            wanted[i] = -1


class MassFlowController:
    """Integrates the setpoint of the flow to a reference mass and controls the mass to it.

    With on-off valves the flow is correct on average over several pulses. When the valves cannot
    follow, the reference is limited to a few smallest pulses ahead of the estimate, so that no flow
    remains to be made up later. Without a setpoint the reference is the estimate. A negative flow
    empties an empty channel.
    """

    def __init__(self) -> None:
        self._reference: Floats = np.empty(0)
        self._following: Flags = np.empty(0, dtype=bool)

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        flow, mass = view.setpoints, view.observer.mass
        following = ~np.isnan(flow)
        if not len(self._reference):
            self._reference, self._following = mass.copy(), np.zeros_like(following)
        begun = following & ~self._following
        reference = np.where(begun, mass, self._reference) + np.nan_to_num(flow) * view.dt
        gain, loss = view.observer.pulse_mass(
            view.shortest_pulse, view.pressures_abs, view.supply_abs
        )
        lead = LONGEST_REFERENCE_LEAD * np.maximum(np.maximum(gain, loss), LEAST_ERROR)
        reference = np.maximum(np.clip(reference, mass - lead, mass + lead), 0.0)
        self._reference, self._following = reference, following
        # a drifted, negative estimate must not open the outlet while the setpoint is zero
        target = np.where(following & ((reference > 0) | (flow < 0)), reference, np.nan)
        return follow_mass(view, target)
