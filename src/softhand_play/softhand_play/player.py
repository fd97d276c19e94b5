"""A simulation in a thread of its own, that keeps the pace of the clock if it can."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue

import numpy as np
from numpy.typing import NDArray

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.scene import SceneError
from grasp_strategies.sequencer import DONE, FAILED
from grasp_strategies.trials import StartedScene, TrialSettings
from pneuflex_sim.simulation import Simulation
from softhand_play.shots import INTERVAL, Shot, Stage, Track, World, look, stage_of

Array = NDArray[np.float64]

SPAN = 20.0  # simulated time that is kept for the plots [s]
LATE = 0.2  # wall time behind the pace from which the pace is given up [s]
MEASURED = 1.0  # wall time over which the speed is measured [s]
NAP = 0.02  # of the thread while it has nothing to do [s]
FASTEST = 1000.0  # times real time: as fast as it can


class _PlayedScene(InProcessScene):
    """A scene that is looked at after each step, which is the same, bit for bit, as without."""

    def __init__(self, simulation: Simulation, passed: Callable[[Simulation], None]) -> None:
        super().__init__(simulation)
        self._passed = passed

    def step(self, duration: float) -> None:
        super().step(duration)
        self._passed(self.simulation)


class _Start(StartedScene):
    """The start of a world whose scene is looked at."""

    def __init__(self, settings: TrialSettings, passed: Callable[[Simulation], None]) -> None:
        self._passed = passed
        super().__init__(settings)

    def _build(self) -> None:
        super()._build()
        self.scene = _PlayedScene(self.scene.simulation, self._passed)


class Pace:
    """Keeps simulated time behind wall time: `speed` 0.25 is slow motion."""

    def __init__(self) -> None:
        self.speed, self.measured = 1.0, 1.0
        self.anchor(0.0)

    def anchor(self, simulated: float) -> None:
        """Count from now on."""
        self._wall, self._simulated = time.perf_counter(), simulated
        self._since = self._wall, simulated

    def wait(self, simulated: float) -> None:
        """Sleep until a simulated time [s] is due."""
        now = time.perf_counter()
        ahead = (simulated - self._simulated) / self.speed - (now - self._wall)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -LATE:
            self._wall, self._simulated = now, simulated
        wall, before = self._since
        if now - wall > MEASURED:
            self.measured = (simulated - before) / (now - wall)
            self._since = now, simulated

    @property
    def is_slow(self) -> bool:
        """Whether the simulation falls behind."""
        return self.measured < 0.9 * min(self.speed, 1.0)


class Source(ABC):
    """What a page shows and commands: a simulation, or nodes that run.

    Args:
        tell: gets a sentence about what cannot be, or what came out.

    keeps_pace: whether its speed can be chosen.
    """

    keeps_pace = False

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self.pace = Pace()
        self.paused = self.is_running = self.is_building = False
        self.phase = ""
        self.now: Track | None = None  # the last seconds; another one after each new start
        self.track: Track | None = None  # a run that has ended
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._work, name="source", daemon=True)

    @property
    def shots(self) -> Sequence[Shot]:
        """The instants of the last seconds; none before the start."""
        return () if self.now is None else self.now.shots

    def _begin(self, stage: Stage, shot: Shot) -> None:
        """Forget what was before a first instant."""
        self.now = Track(deque([shot], maxlen=round(SPAN / INTERVAL)), stage)

    @abstractmethod
    def _work(self) -> None:
        """The thread, until `_closing` is set."""

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()


class Player(Source):
    """Runs a world: freely, by commands, or by its strategy.

    Args:
        world: that it begins with.
        tell: as a `Source` has it.
    """

    keeps_pace = True

    def __init__(self, world: World, tell: Callable[[str], None]) -> None:
        super().__init__(tell)
        self.world = world
        self.stops_at_phases = False
        self.result: GraspResult | None = None
        self._recorded: list[Shot] | None = None
        self._jobs: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._abort = threading.Event()
        self._start: _Start | None = None
        self._wanted = world
        self.play(world)
        self._thread.start()

    # ---------------------------------------------------------------- commands
    def play(self, world: World) -> None:
        """Take another world; a strategy that runs is aborted. One that cannot be is told, and the
        old one stays.
        """
        self._wanted = world
        self._abort.set()
        self._jobs.put(lambda: self._build(world))

    def run_strategy(self, world: World) -> None:
        """From the start of a world, run its strategy."""
        self.play(world)
        self._jobs.put(lambda: self._run(world))

    def reset(self) -> None:
        """Go back to the start."""
        self._abort.set()
        self._jobs.put(self._reset)

    def abort(self) -> None:
        """End the strategy that runs: the air is let out."""
        self._abort.set()

    def command_pressures(self, pressures: Array) -> None:
        """Gauge pressures (channels,) [Pa] to reach, NaN to leave a channel as it is; nothing while
        a strategy runs.
        """
        self._command(lambda scene: scene.command_pressure(pressures))

    def command_masses(self, masses: Array) -> None:
        """Air masses (channels,) [kg above rest] to reach, otherwise as `command_pressures`."""
        self._command(lambda scene: scene.command_air(masses))

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Target pose of the wrist: position (3,) [m], quaternion (4,)."""
        self._command(lambda scene: scene.command_wrist(position, orientation))

    def close(self) -> None:
        """Abort and end the thread."""
        self._closing.set()
        self._abort.set()
        super().close()

    # ---------------------------------------------------------------- the thread
    def _command(self, act: Callable[[InProcessScene], None]) -> None:
        if not self.is_running:
            self._jobs.put(lambda: act(self._start.scene) if self._start else None)

    def _work(self) -> None:
        while not self._closing.is_set():
            try:
                self._next()
            except (ValueError, TypeError, KeyError, RuntimeError, OSError) as error:
                self._tell(str(error))
                if isinstance(error, SceneError):
                    self._reset()
        self._start = None

    def _next(self) -> None:
        try:
            self._jobs.get_nowait()()
        except Empty:
            if self._start is None or self.paused:
                time.sleep(NAP)
                self.pace.anchor(self._start.scene.time if self._start else 0.0)
            else:
                self._start.scene.step(0.5 * INTERVAL)

    def _build(self, world: World) -> None:
        if world is not self._wanted:
            return
        self.is_building = True
        try:
            start = _Start(world.settings, self._passed)
            start.place(world.placement)
            if world.settings.early_end:
                _ = start.empty_course  # which takes a trial
        finally:
            self.is_building = False
        self._start, self.world = start, world
        self._anew(start, stage_of(start.scene.simulation))

    def _reset(self) -> None:
        if self._start is not None and self.now is not None:
            self._start.place(self.world.placement)
            self._anew(self._start, self.now.stage)

    def _anew(self, start: _Start, stage: Stage) -> None:
        self.phase = ""
        self.pace.anchor(0.0)
        self._begin(stage, look(start.scene.simulation))

    def _run(self, world: World) -> None:
        """Run the strategy, unless its world could not be built or another one is wanted by now."""
        self._abort.clear()
        start, now = self._start, self.now
        superseded = not self.world is world is self._wanted or self._closing.is_set()
        if start is None or now is None or superseded:
            return
        if now.stage.object is None:
            raise ValueError(f"scene: expected one with an object, got {now.stage.scene.name}")
        shots: list[Shot] = []
        self._recorded = shots
        self.is_running, self.paused, self.result = True, False, None
        try:
            result = start.run(world.placement, on_phase=self._enter, abort=self._abort)
        finally:
            self._recorded, self.is_running = None, False
        ending = f"{result.outcome}: {result.reason}"
        if shots:
            self.track = Track(shots, now.stage, ending)
        self.result = result
        self._tell(f"{ending}; the map has: {world.known}" if world.known else ending)

    def _enter(self, phase: str) -> None:
        if self.stops_at_phases and self.phase and phase not in (DONE, FAILED):
            self.paused = True
        self.phase = phase

    def _passed(self, simulation: Simulation) -> None:
        """After each step: look, keep the pace, stand still while paused."""
        time_now = simulation.time
        if self.now is not None and time_now > self.now.shots[-1].time + INTERVAL - 1e-6:
            shot = look(simulation, self.phase)
            self.now.shots.append(shot)
            if self._recorded is not None:
                self._recorded.append(shot)
        self.pace.wait(time_now)
        while self.paused and self.is_running and not self._abort.is_set():
            time.sleep(NAP)
            self.pace.anchor(time_now)
