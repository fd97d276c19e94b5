"""Control of the channel pressure by pulses (section 4.1)."""

import numpy as np

from pneumaticbox_driver.controllers.view import BoxView, Flags, Floats


class Pressure:
    """The measured gauge pressure; setpoints in [Pa]. The volume is that of the model."""

    def state(self, view: BoxView, gauge: Floats) -> tuple[Floats, Floats]:
        """Gauge pressures [Pa] and volumes [m3] now (n,)."""
        return gauge, view.volume_model.volumes(gauge)

    def goal(self, view: BoxView, gauge: Floats, volume: Floats) -> tuple[Floats, Floats]:
        """Gauge pressures [Pa] and volumes [m3] at the setpoint (n,)."""
        target = np.maximum(view.setpoints, 0.0)
        model = view.volume_model
        return target, volume + model.volumes(target) - model.volumes(gauge)

    def passed(self, view: BoxView, margin: float) -> Flags:
        """Whether the pressure has passed its setpoint by a `margin` [Pa] (n,)."""
        beyond = view.pressures - view.ambient - view.setpoints
        return np.asarray(view.direction * beyond > margin)
