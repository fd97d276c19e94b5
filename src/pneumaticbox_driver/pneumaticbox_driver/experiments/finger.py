"""Fingers on the pretended bench: their air by pressure, and how they bend."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.box import PneumaticBox
from pneumaticbox_driver.calibration import ChannelCalibration
from pneumaticbox_driver.experiments.bench_run import BenchRun
from pneumaticbox_driver.experiments.boxes import OUTLETS
from pneumaticbox_driver.experiments.report import Floats
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.chain import discretise
from softhand_model.free_volumes import FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hands import load_hand
from softhand_model.model_file import Model
from softhand_model.pneumatics import Pneumatics

HAND, CHAIN = "single_finger", "finger"
SEGMENTS = 20  # of the drawn finger
BEND = 1  # index of the bending axis (y)


class Fingers:
    """`count` fingers of one kind that nothing touches, one a channel; pressures gauge (n,) [Pa].

    It is both what the plant fills (`volumes` of absolute pressures through `chambers`) and, in
    the driver, the model of a channel's volume.

    >>> fingers = Fingers(2)
    >>> (1e6 * fingers.volumes(np.array([0.0, 30e3]))).round(1).tolist()
    [18.8, 24.5]
    """

    def __init__(self, count: int) -> None:
        self.hand = load_hand(HAND)
        self._free = FreeVolumes(self.hand)
        self.rest: Floats = np.repeat(self._free.rest, count)
        self.limit = float(self.hand.max_pressures()[0])

    def volumes(self, gauge: Floats) -> Floats:
        """Volumes with tubes (n,) [m3]."""
        return np.array([self._free.volumes(p)[0] for p in gauge[:, None]])

    def slopes(self, gauge: Floats) -> Floats:
        """Derivatives of the volumes by the pressures (n,) [m3/Pa]."""
        return np.array([self._free.slopes(p)[0] for p in gauge[:, None]])

    def mass(self, gauge: Floats) -> Floats:
        """Air above the fill at rest (n,) [kg]."""
        rest = air_mass(AMBIENT_PRESSURE, self.rest)
        return np.asarray(air_mass(gauge + AMBIENT_PRESSURE, self.volumes(gauge)) - rest)

    @cached_property
    def _chain(self):
        return discretise(self.hand.chain(CHAIN), SEGMENTS, Model())

    def bends(self, gauge: float) -> Floats:
        """Angle of the tangent against the base along the finger (SEGMENTS + 1,) [rad]."""
        joints = self._chain.rest_rotation([max(gauge, 0.0)])[:, BEND]
        return np.concatenate([[0.0], np.cumsum(joints)])

    def tip_angles(self, gauge: Floats) -> Floats:
        """Angles of the tips against the bases (n,) [rad]."""
        return np.array([self.bends(p)[-1] for p in gauge])

    @property
    def length(self) -> float:
        """Length of a finger [m]."""
        return next(iter(self.hand.chain(CHAIN).actuators.values())).length


class _AtPressures:
    """The fingers as chambers of the plant, which knows absolute pressures."""

    def __init__(self, fingers: Fingers) -> None:
        self._fingers = fingers

    def volumes(self, pressures_abs: Floats) -> Floats:
        """Volumes (n,) [m3] at absolute pressures (n,) [Pa]."""
        return self._fingers.volumes(pressures_abs - AMBIENT_PRESSURE)


def on_fingers(
    fingers: Fingers,
    constants: Pneumatics,
    calibrations: Sequence[ChannelCalibration],
    seed: int,
    drift_correction: bool = False,
    sensor_offset: float = 0.0,
) -> BenchRun:
    """A run in mass control with a finger on each channel, tared once, at its start.

    Args:
        fingers: one a channel.
        constants: of the plant.
        calibrations: one a channel.
        seed: of noise and jitter.
        drift_correction: whether the box weighs the fingers by pressure and volume when they are
            still.
        sensor_offset: that the channels' sensors have besides their own errors [Pa].
    """
    n = len(calibrations)
    settings = BoxSettings(
        tuple(OUTLETS[:n]), tuple(fingers.rest.tolist()), (fingers.limit,) * n, ("mass",) * n
    )
    box = PneumaticBox(settings, calibrations, fingers)
    box.drift_correction = drift_correction
    bench = EmbeddedBench(OUTLETS[:n], _AtPressures(fingers), constants, seed)
    return BenchRun(box, bench, fingers.mass, sensor_offset)
