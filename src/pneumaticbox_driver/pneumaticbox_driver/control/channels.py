"""Control of all channels, each in its own mode, within the limits of slow valves."""

from collections.abc import Callable, Sequence

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves, same
from pneumaticbox_driver.control.interface import BoxView, Controller
from pneumaticbox_driver.control.mass import (
    MassController,
    MassFlowController,
    rehearse_mass_control,
)
from pneumaticbox_driver.control.pulsewise import Pressure, PulsewiseController, Volume
from pneumaticbox_driver.modes import check_mode
from softhand_common.numerics.compiled import compiled


class ControlError(RuntimeError):
    """The controller of a `mode` has failed; `channels` are the indices of its channels."""

    def __init__(self, mode: str, channels: list[int]) -> None:
        super().__init__(f"controller of mode {mode}")
        self.mode, self.channels = mode, channels


class TimeController:
    """Commands the valves of the schedule: +1 inflate, -1 deflate; closed for 0 and without a
    setpoint.
    """

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,)."""
        return np.nan_to_num(view.setpoints).astype(np.int8)


CONTROLLERS: dict[str, Callable[[], Controller]] = {
    "mass": MassController,
    "mass_flow": MassFlowController,
    "pressure": lambda: PulsewiseController(Pressure()),
    "volume": lambda: PulsewiseController(Volume()),
    "time": TimeController,
}
# the setpoint (n,) that keeps the present state, from averaged pressures (n,) [Pa]
PRESENT: dict[str, Callable[[BoxView, Floats], Floats]] = {
    "mass": lambda view, steady_abs: view.observer.mass,
    "pressure": lambda view, steady_abs: steady_abs - view.ambient,
    "volume": lambda view, steady_abs: view.volume_at(steady_abs) - view.rest_volumes,
}


class ChannelControl:
    """One controller per used mode, which computes the valves of the channels in its mode.

    `modes` (n,) are the present ones of the channels.

    Args:
        modes: modes of the channels at the start (n,).

    Raises:
        ValueError: a mode that does not exist.
    """

    def __init__(self, modes: Sequence[str]) -> None:
        self.modes: tuple[str, ...] = ()
        self._controllers: dict[str, Controller] = {}
        self._masks: dict[str, Flags] = {}
        self._closed: Valves = np.zeros(len(modes), dtype=np.int8)
        self.switch(modes)
        rehearse_mass_control(len(modes))

    def switch(self, modes: Sequence[str]) -> None:
        """Change the modes (n,); raises ValueError for an unknown one and then changes nothing."""
        before = self._controllers
        controllers = {
            mode: before.get(mode) or CONTROLLERS[check_mode(mode).name]() for mode in modes
        }
        self.modes, self._controllers = tuple(modes), controllers
        self._masks = {mode: np.array([m == mode for m in modes]) for mode in controllers}

    def restart(self) -> None:
        """Clear the state of the controllers after a reset of the box."""
        self._controllers = {}
        self.switch(self.modes)

    @property
    def saturated(self) -> Flags:
        """Channels whose target cannot be reached below the pressure limit (n,)."""
        flags = self._closed != 0
        for mode, controller in self._controllers.items():
            if isinstance(controller, PulsewiseController) and len(controller.saturated):
                flags = flags | (self._masks[mode] & controller.saturated)
        return flags

    def update(self, view: BoxView) -> Valves:
        """Return the wanted valves (n,): +1 inflate, -1 deflate, 0 closed.

        Raises:
            ControlError: a controller has failed; `__cause__` is its error.
        """
        wanted, setpoints = self._closed, view.setpoints
        alone = len(self._controllers) == 1
        for mode, controller in self._controllers.items():
            view.mine = self._masks[mode]
            view.setpoints = setpoints if alone else np.where(view.mine, setpoints, np.nan)
            try:
                found = controller.update(view)
                wanted = found if alone else np.where(view.mine, found, wanted)
            except Exception as error:
                raise ControlError(mode, np.flatnonzero(view.mine).tolist()) from error
        return wanted


class PulseTiming:
    """Keeps a valve open for the shortest pulse and closed for the shortest pause.

    A pulse shorter than the delays of the valve (20-40 ms) may move no air at all, and a pulse
    after too short a pause begins before the last one has ended: equation 4.1 holds for neither.
    Between inflation and deflation there is always a pause.

    Args:
        channels: number of channels.
        shortest_pulse: smallest time for which a valve is open [s].
        shortest_pause: smallest time for which it is closed [s].
    """

    def __init__(self, channels: int, shortest_pulse: float, shortest_pause: float) -> None:
        self._pulse, self._pause = shortest_pulse, shortest_pause
        self._switched: Floats = np.full(channels, -np.inf)  # when each valve switched last [s]
        # compile or load the kernel before the first sample
        closed: Valves = np.zeros(channels, dtype=np.int8)
        self.follow(0.0, closed, closed + np.int8(1))

    def follow(self, time: float, valves: Valves, wanted: Valves) -> Valves:
        """Return the valves to command at `time` [s].

        Args:
            time: time of the sample [s].
            valves: valves commanded until now (n,).
            wanted: valves that control wants (n,).
        """
        if same(wanted, valves):
            return valves
        followed = np.empty_like(valves)
        keep_timing(time, self._switched, (self._pulse, self._pause), valves, wanted, followed)
        return followed

    def note(self, time: float, changed: Flags) -> None:
        """Note that the valves of the channels `changed` (n,) are switched at `time` [s]."""
        self._switched[changed] = time

    def restart(self) -> None:
        """Clear the switching times, for a clock that was set back."""
        self._switched[:] = -np.inf


@compiled
def keep_timing(
    time: float,
    switched: Floats,
    shortest: tuple[float, float],
    valves: Valves,
    wanted: Valves,
    followed: Valves,
) -> None:
    """Write the valves of `PulseTiming.follow` into `followed` (n,).

    `switched` (n,) is when the valves switched last [s], `shortest` pulse and pause [s].
    """
    pulse, pause = shortest
    for i in range(len(valves)):
        is_open = valves[i] != 0
        followed[i] = valves[i]
        if time - switched[i] >= (pulse if is_open else pause) - 1e-6:
            followed[i] = 0 if is_open and wanted[i] != valves[i] else wanted[i]
