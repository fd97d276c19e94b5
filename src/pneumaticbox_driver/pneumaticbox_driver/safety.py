"""Safety of the box: pressure limits, missing sensor samples and the latched vent."""

import math

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves, some
from softhand_common.documents.quoted import shortened

RELIEF_END = 0.97  # of the limit; the outlet closes again below it
BURST_MARGIN = 1.2  # of the limit; above it relief has failed
SAMPLE_SILENCE_LIMIT = 0.25  # without a sensor sample, node time [s]
WALL_SILENCE_LIMIT = 2.0  # likewise in wall time, without a simulation [s]


def text_of(error: BaseException) -> str:
    """Text of an error, or its type if asking for the text raises another error.

    Errors of boards are not ours: a `__str__` that raises must end no thread.
    """
    try:
        return str(error)
    except BaseException:  # noqa: BLE001 whatever it is, the error itself is what matters
        return f"{type(error).__name__} without a text"


def one_line(error: BaseException) -> str:
    """Type and text of an error, shortened to 200 characters.

    >>> one_line(OSError("no such device"))
    'OSError: no such device'
    """
    return f"{type(error).__name__}: {shortened(text_of(error))}"


class VentLatch:
    """Stores the reasons for which the outlets must stay open, until `release`.

    >>> latch = VentLatch()
    >>> latch.set("no sensors"); latch.set("no sensors"); latch.reasons
    ['no sensors']
    """

    def __init__(self) -> None:
        self.reasons: list[str] = []

    def set(self, reason: str) -> None:
        """Add a reason; the first ten are kept."""
        if reason not in self.reasons and len(self.reasons) < 10:
            self.reasons.append(reason)

    def release(self) -> None:
        """Clear all reasons; only a reset by the user may do this."""
        self.reasons.clear()

    def __bool__(self) -> bool:
        return bool(self.reasons)


class PressureGuard:
    """Keeps each channel below its pressure limit.

    Above the limit the outlet opens until the pressure is 3 % below it, and the channel is not
    inflated again before it gets a lower setpoint or a new command: otherwise control and relief
    would alternate. At 20 % above the limit the relief has failed, and the box vents.

    Args:
        limits: gauge pressure limits (n,) [Pa].
    """

    def __init__(self, limits: Floats) -> None:
        self.limits, self._burst = limits, BURST_MARGIN * limits
        self.restart()

    def restart(self) -> None:
        """Clear all marks after a reset of the box."""
        n = len(self.limits)
        self.relieving: Flags = np.zeros(n, dtype=bool)
        self.blocked: Flags = np.zeros(n, dtype=bool)
        self._blocked_at: Floats = np.full(n, np.nan)  # setpoint that led over the limit

    def apply(self, pressures: Floats, setpoints: Floats, valves: Valves) -> Valves:
        """Return `valves` (n,), changed where the limits require it.

        Args:
            pressures: channel pressures (n,) [Pa].
            setpoints: setpoints of the channels, NaN for none (n,).
            valves: valves that control wants (n,).
        """
        over = pressures > self.limits
        if some(over):
            self._blocked_at = np.where(over & ~self.blocked, setpoints, self._blocked_at)
            self.relieving |= over
            self.blocked |= over
        if not some(self.blocked):
            return valves
        self.relieving &= pressures > RELIEF_END * self.limits
        self.blocked &= self.relieving | ~(setpoints < self._blocked_at)
        held = np.where(self.blocked & (valves > 0), 0, valves)
        return np.where(self.relieving, -1, held).astype(np.int8)

    def burst(self, pressures: Floats) -> int | None:
        """Index of the first channel whose relief has failed; None for none."""
        beyond = pressures > self._burst
        return int(np.argmax(beyond)) if some(beyond) else None

    def unblock(self, channels: tuple[int, ...]) -> None:
        """Allow these channels, which have new commands, to be inflated again."""
        self.blocked[list(channels)] = self.relieving[list(channels)]


class SampleWatch:
    """Detects that sensor samples are missing, after the first sample."""

    def __init__(self) -> None:
        self._node_time = self._wall_time = math.nan  # of the last sample [s]

    def note(self, node_time: float, wall_time: float) -> None:
        """Note a sample at this node time [s] and monotonic wall time [s].

        A node time of 0 means that no tick of simulated time has arrived; the jump to the first
        tick is not taken for missing samples.
        """
        self._node_time = node_time if node_time > 0 else math.nan
        self._wall_time = wall_time

    @property
    def started(self) -> bool:
        """Whether there has been a sample."""
        return not math.isnan(self._wall_time)

    def silence(self, node_time: float, wall_time: float, simulated: bool) -> str | None:
        """The error at these times [s] if samples are missing, else None.

        Args:
            node_time: time of the node's clock, simulated or not.
            wall_time: monotonic wall time.
            simulated: whether node time is that of a simulation, which may be paused or slow
                without a fault.
        """
        if not self.started:
            return None
        silent, wall = node_time - self._node_time, wall_time - self._wall_time
        if silent > SAMPLE_SILENCE_LIMIT:
            return f"no sensor sample for {SAMPLE_SILENCE_LIMIT * 1e3:.0f} ms"
        if wall > WALL_SILENCE_LIMIT and not simulated:
            return f"no sensor sample for {WALL_SILENCE_LIMIT:.0f} s of wall time"
        return None
