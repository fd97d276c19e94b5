"""What the box is made of and what it knows: estimates, modes, bounds."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.box.commands import CommandIntake, Setpoints
from pneumaticbox_driver.calibration.calibration import ChannelCalibration
from pneumaticbox_driver.calibration.run import CalibrationRun, CalibrationSession
from pneumaticbox_driver.control.interface import BoxView
from pneumaticbox_driver.control.modes import ControllerBank
from pneumaticbox_driver.control.pulse_timing import PulseTiming
from pneumaticbox_driver.faults.fault_watch import FaultWatch
from pneumaticbox_driver.observer.observer import MassObserver
from pneumaticbox_driver.observer.volume_model import VolumeModel, make_volume_model
from pneumaticbox_driver.observer.zeroing import KnownMasses
from pneumaticbox_driver.safety import PressureGuard, VentLatch
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Valves = NDArray[np.int8]


class BoxState:
    """The parts of the box, and what it knows and says of itself; see `PneumaticBox`."""

    def __init__(
        self,
        settings: BoxSettings,
        calibrations: Sequence[ChannelCalibration],
        volumes: VolumeModel | None = None,
    ) -> None:
        n = len(settings.channels)
        if len(calibrations) != n:
            raise ValueError(f"calibrations must be {n}, one a channel, got {len(calibrations)}")
        self.settings = settings
        self.latch = VentLatch()
        self.guard = PressureGuard(np.array(settings.pressure_limits))
        self.observer = MassObserver(calibrations, settings.ambient)
        self.enabled = settings.start_enabled
        self.openings: NDArray[np.int64] = np.zeros(n, dtype=np.int64)  # of the valves, so far
        self.pressures: Floats = np.full(n, settings.ambient)  # absolute, offsets taken off [Pa]
        self.supply = settings.ambient  # absolute [Pa]
        self.notes: list[str] = []  # warnings for the user, oldest first
        self._faults = FaultWatch(settings.channels, settings)
        self._timing = PulseTiming(n, settings.shortest_pulse, settings.shortest_pause)
        self._bank = ControllerBank(settings.control_modes)
        self._view = BoxView(
            observer=self.observer,
            volume_model=volumes
            or make_volume_model(settings.volume_model, settings.hand, settings.rest_volumes),
            rest_volumes=np.array(settings.rest_volumes),
            ambient=settings.ambient,
            gas=GAS_CONSTANT * settings.temperature,
            shortest_pulse=settings.shortest_pulse,
        )
        self._known = KnownMasses(settings, self.observer, self._view.volume_model, self.notes)
        self._intake = CommandIntake(settings)
        self._calibrating = CalibrationSession(settings.channels)
        self.leak_model = False  # whether leaked air is taken off the estimates
        self._take_leaks(calibrations)
        self._closed: Valves = np.zeros(n, dtype=np.int8)
        self._venting: Valves = np.full(n, -1, dtype=np.int8)
        self._restart()

    def _restart(self) -> None:
        """Begin anew: no setpoints, valves closed, sensors to be averaged first."""
        self.time = math.nan
        self.sensors_sound = False
        self._intake.drop()
        self._calibrating.abort("the box began anew")
        self._timing.restart()
        self._known.restart()
        self._faults.begin()
        self.observer.switch(self._closed, self.pressures, self.supply)

    def _take_leaks(self, calibrations: Sequence[ChannelCalibration]) -> None:
        self._leak = np.array([c.leak.conductance for c in calibrations])  # [kg/(s Pa)]

    def set_calibrations(self, calibrations: Sequence[ChannelCalibration]) -> None:
        """Use other coefficients from the next pulses on; raises ValueError for another number."""
        self.observer.set_calibrations(calibrations)
        self._take_leaks(calibrations)

    @property
    def setpoints(self) -> Setpoints:
        """Setpoints of the channels over time, in the unit of each one's mode."""
        return self._intake.setpoints

    @property
    def modes(self) -> tuple[str, ...]:
        """Control modes of the channels now (n,)."""
        return self._bank.modes

    @property
    def ready(self) -> bool:
        """Whether the sensors have been averaged, so that control can begin."""
        return self._known.ready

    @property
    def empty(self) -> Flags:
        """Channels known to be at ambient pressure since their outlet was last open (n,)."""
        return self._known.empty

    @property
    def offsets(self) -> Floats:
        """Offsets found of the channel sensors (n,) [Pa]."""
        return self._known.offsets

    @property
    def drift_bound(self) -> Floats:
        """How far the estimated masses may be off, two standard deviations (n,) [kg]."""
        return self._known.drift_bound

    @property
    def drift_correction(self) -> bool:
        """Whether masses are weighed against what pressures and free volumes tell; settable.

        For a hand that stands in free posture whenever its pressures stand still.
        """
        return self._known.drift_correction

    @drift_correction.setter
    def drift_correction(self, on: bool) -> None:
        self._known.drift_correction = on

    @property
    def calibration(self) -> CalibrationRun | None:
        """The calibration started last, None before the first one."""
        return self._calibrating.run

    @property
    def volume(self) -> Floats:
        """Volumes above those at rest, by `V = m R_s T/p_abs` of the estimated mass (n,) [m3]."""
        return self._view.volume_at(self.pressures) - self._view.rest_volumes

    @property
    def gauge(self) -> Floats:
        """Gauge pressures of the channels (n,) [Pa]."""
        return self.pressures - self.settings.ambient

    @property
    def valves(self) -> Valves:
        """The valves commanded last (n,): +1 inflate, -1 deflate, 0 closed."""
        return self._timing.valves
