"""Control of the channel volume, which the estimated mass and the pressure tell (section 4.1)."""

import numpy as np

from pneumaticbox_driver.controllers.view import BoxView, Flags, Floats
from pneumaticbox_driver.volume_model import pressure_after


class Volume:
    """The estimated volume `m R_s T/p_abs`; setpoints in [m3] above rest."""

    def state(self, view: BoxView, gauge: Floats) -> tuple[Floats, Floats]:
        """Gauge pressures [Pa] and volumes [m3] now (n,)."""
        return gauge, view.volume_at(gauge + view.ambient)

    def goal(self, view: BoxView, gauge: Floats, volume: Floats) -> tuple[Floats, Floats]:
        """Gauge pressures [Pa] and volumes [m3] at the setpoint (n,)."""
        target = np.maximum(view.setpoints, 0.0) + view.rest_volumes
        return pressure_after(view.volume_model, gauge, target - volume), target

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the volume has passed its setpoint by a `margin` of pressure [Pa] (n,)."""
        volume = view.volume_at(view.pressures)
        beyond = volume - view.rest_volumes - view.setpoints
        return np.asarray(view.direction * beyond > volume * margin / view.pressures)
