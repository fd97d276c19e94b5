"""Time-based control: the client schedules the valves (section 4.1)."""

import numpy as np

from pneumaticbox_driver.controllers.view import BoxView, Valves


class TimeController:
    """Commands what the schedule says: setpoints +1 inflate, -1 deflate, 0 or none closed."""

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        return np.nan_to_num(view.setpoints).astype(np.int8)
