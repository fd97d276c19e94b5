"""A calibration inside the box: when it may begin, what it answers, and what ends it."""

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.calibration_run import CalibrationRun
from pneumaticbox_driver.recording import Sample
from pneumaticbox_driver.safety import PressureGuard

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
UNDER_WAY = ("running", "waiting")


class CalibrationSession:
    """Holds the calibration that has been started last; `run` is None before the first one.

    Args:
        channels: names of the box's channels.
    """

    def __init__(self, channels: tuple[str, ...]) -> None:
        self._channels = channels
        self.run: CalibrationRun | None = None

    @property
    def under_way(self) -> bool:
        """Whether a calibration answers the samples now."""
        return self.run is not None and self.run.state in UNDER_WAY

    def start(self, run: CalibrationRun) -> str:
        """Begin a calibration of all channels; returns a sentence.

        Raises:
            ValueError: one is under way already, or the run is for other channels.
        """
        self.refuse_under_way()
        if tuple(run.channels) != self._channels:
            expected = list(self._channels)
            raise ValueError(f"calibration: expected channels {expected}, got {list(run.channels)}")
        self.run = run
        return f"calibration has begun: {run.message}"

    def refuse_under_way(self) -> None:
        """Raise ValueError while a calibration is under way: it alone commands the valves."""
        if self.run is not None and self.run.state in UNDER_WAY:
            raise ValueError(f"a calibration is under way: {self.run.message}")

    def next(self) -> str:
        """Go on at another supply pressure; raises ValueError when nothing waits for it."""
        if self.run is None:
            raise ValueError("no calibration is under way: call pneumaticbox/calibrate first")
        return self.run.next()

    def answer(self, time: float, readings: Floats, guard: PressureGuard) -> Valves:
        """Valves (n,) that the calibration wants.

        Args:
            time: of the sample [s].
            readings: absolute pressures as the sensors gave them, supply last (n + 1,) [Pa].
            guard: of the pressure limits; where it relieves a channel, pulses are spoilt.
        """
        run = self.run
        if run is None:
            return np.zeros(len(self._channels), dtype=np.int8)
        if guard.relieving.any():
            name = self._channels[int(np.argmax(guard.relieving))]
            run.abort(f"channel {name} has reached its pressure limit: raise pressure_limits")
        return run.on_sample(Sample(time, readings[:-1], float(readings[-1])))

    def abort(self, reason: str) -> None:
        """End a calibration that is under way, without a result."""
        if self.run is not None:
            self.run.abort(reason)
