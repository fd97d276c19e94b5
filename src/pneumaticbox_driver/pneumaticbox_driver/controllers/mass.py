"""Bang-bang control of the contained air mass (section 4.4)."""

import numpy as np

from pneumaticbox_driver.controllers.view import LEAST_ERROR, BoxView, Floats, Valves


class MassController:
    """Opens a valve when the error exceeds the threshold, closes it when the error changes sign.

    The threshold is a good half of the smallest pulse (`BoxView.opened`), so the channel ends
    within one smallest pulse of its target. The observer's estimate is that of the mass after the
    valve has closed, so the delay of the valve is anticipated.

    A target of zero or below empties the channel to ambient pressure, where its mass is known.
    """

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        return follow_mass(view, view.setpoints)


def follow_mass(view: BoxView, target: Floats) -> Valves:
    """Valves (n,) that bring the estimated masses to a `target` (n,) [kg], NaN for none."""
    error = target - view.observer.mass
    # a valve closes at the sample that comes nearest to the target
    margin = (0.5 * view.dt) * np.abs(view.observer.flow)
    keep = view.direction * error > margin
    wanted = np.where(keep, view.direction, 0)
    at_rest = view.direction == 0
    if (at_rest & (np.abs(error) > LEAST_ERROR)).any():
        wanted = np.where(at_rest, view.opened(error), wanted)
    return view.or_emptied(target, wanted)
