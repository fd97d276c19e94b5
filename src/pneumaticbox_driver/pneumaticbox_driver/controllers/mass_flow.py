"""Control of the mass flow: the wanted flow adds up to an air mass that is followed (4.3)."""

import numpy as np

from pneumaticbox_driver.controllers.mass import follow_mass
from pneumaticbox_driver.controllers.view import LEAST_ERROR, BoxView, Flags, Floats, Valves

LONGEST_LEAD = 3.0  # of the reference over the estimate, in smallest pulses [-]


class MassFlowController:
    """Integrates the wanted flow into a reference and follows it as mass control does.

    Valves that are only open or closed give the flow on the mean over their pulses. Where they
    cannot follow, the reference waits a few smallest pulses ahead of the estimate, so that nothing
    is caught up after the flow has ended. It stands at the estimate while there is no setpoint. A
    flow out of an empty channel empties it.
    """

    def __init__(self) -> None:
        self._reference: Floats = np.empty(0)
        self._following: Flags = np.empty(0, dtype=bool)

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        flow, mass = view.setpoints, view.observer.mass
        following = view.mine & ~np.isnan(flow)
        if not len(self._reference):
            self._reference, self._following = mass.copy(), np.zeros_like(following)
        begun = following & ~self._following
        reference = np.where(begun, mass, self._reference) + np.nan_to_num(flow) * view.dt
        gain, loss = view.observer.pulse_mass(view.shortest_pulse, view.pressures, view.supply)
        lead = LONGEST_LEAD * np.maximum(np.maximum(gain, loss), LEAST_ERROR)
        reference = np.maximum(np.clip(reference, mass - lead, mass + lead), 0.0)
        self._reference, self._following = reference, following
        # nothing is let out of a channel for a drifted estimate below zero while no flow is wanted
        target = np.where(following & ((reference > 0) | (flow < 0)), reference, np.nan)
        return follow_mass(view, target)
