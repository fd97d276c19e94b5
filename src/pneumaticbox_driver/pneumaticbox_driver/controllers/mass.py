"""Bang-bang control of the contained air mass (section 4.4)."""

import numpy as np

from pneumaticbox_driver.controllers.view import BoxView, Floats, Valves

OPENING_SHARE = 0.55  # of the smallest pulse; above one half, so that a pulse lessens the error
LEAST_ERROR = 1e-7  # a valve does not open for less [kg]


class MassController:
    """Opens a valve when the error exceeds the threshold, closes it when the error changes sign.

    The threshold is a good half of what the smallest pulse would move from the present
    pressures, by equation 4.1: so a pulse always leaves a smaller error than it found, and the
    channel ends within one smallest pulse of its target. The observer's estimate is that of the
    mass after the valve has closed, so the delay of the valve is anticipated.

    A target of zero or below empties the channel to ambient pressure, where its mass is known.
    """

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        # there is no less than empty: a target below zero is the target zero
        error = np.maximum(view.setpoints, 0.0) - view.observer.mass
        # a valve closes at the sample that comes nearest to the target
        margin = (0.5 * view.dt) * np.abs(view.observer.flow)
        keep = view.direction * error > margin
        wanted = np.where(keep, view.direction, 0)
        at_rest = view.direction == 0
        if (at_rest & (np.abs(error) > LEAST_ERROR)).any():
            wanted = np.where(at_rest, self._opened(view, error), wanted)
        emptying = (view.setpoints <= 0) & ~view.empty & (view.direction <= 0)
        return np.where(emptying, -1, wanted).astype(np.int8)

    def _opened(self, view: BoxView, error: Floats) -> Valves:
        gain, loss = view.observer.pulse_mass(view.shortest_pulse, view.pressures, view.supply)
        inflate = error > np.maximum(OPENING_SHARE * gain, LEAST_ERROR)
        deflate = -error > np.maximum(OPENING_SHARE * loss, LEAST_ERROR)
        return inflate.astype(np.int8) - deflate.astype(np.int8)
