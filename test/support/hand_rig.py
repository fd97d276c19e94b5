"""The box on the simulated box with the actuators of a hand, as with `volume_model: hand`."""

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.modes import MODES
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.chain.volumes import FreeActuators
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.hand.hand import load_hand


class PressedActuators:
    """The actuators of a hand, free or against an object.

    `give` is the share of their free growth over pressure that an object leaves them: 1 is free
    posture, 0 holds them at rest.
    """

    def __init__(self, hand):
        self._free = FreeActuators(hand)
        self._ambient = np.full(len(hand.channels), AMBIENT_PRESSURE)
        self.give = 1.0

    def volumes(self, pressures_abs):
        rest = self._free.volumes(self._ambient)
        return rest + self.give * (self._free.volumes(pressures_abs) - rest)


class HandRig:
    """Runs the box and a bench with the channels of `hand`; `actuators.give` blocks them."""

    def __init__(self, hand="rbo_hand_2", mode="mass", seed=1, **settings):
        described = load_hand(hand)
        self.names = described.channels
        self.actuators = PressedActuators(described)
        self.bench = EmbeddedRig(self.names, self.actuators, seed=seed)
        self.box = PneumaticBox(
            BoxSettings(
                channels=self.names,
                rest_volumes=tuple(described.rest_volumes().tolist()),
                pressure_limits=tuple(described.max_pressures().tolist()),
                control_modes=(mode,) * len(self.names),
                volume_model="hand",
                hand=hand,
                **settings,
            ),
            load_calibration(None, len(self.names)),
        )

    def run(self, duration, dt=4e-3):
        """Samples for `duration` [s], dt [s] apart; the highest true gauge pressure [Pa]."""
        peak = 0.0
        for _ in range(round(duration / dt)):
            readings = self.bench.advance(dt)
            self.bench.command(self.box.on_sample(self.bench.time, readings))
            peak = max(peak, float(self.gauge.max()))
        return peak

    def started(self):
        """The rig, once the box has averaged its sensors."""
        self.run(1.0)
        return self

    def command(self, names, values, after=0.0):
        """Send targets of the channels' own mode, in which all of them are."""
        mode = MODES[self.box.control.modes[self.names.index(names[0])]]
        point = TrajectoryPoint(after, **{mode.field: values})
        take = self.box.schedule_valves if mode.scheduled else self.box.command
        take(names, [point], 0.0, self.box.time)

    @property
    def gauge(self):
        """True gauge pressures (n,) [Pa]."""
        return self.bench.plant.pressures - self.box.settings.ambient

    @property
    def growth(self):
        """True volumes above those at rest (n,) [m3]."""
        return self.bench.volumes - np.array(self.box.settings.rest_volumes)
