"""A simulation in a thread of its own, in real time if the machine is fast enough."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.scene import SceneError
from grasp_strategies.sequencer import PHASE_DONE, PHASE_FAILED
from pneuflex_sim.simulation import Simulation
from softhand_common.numerics.arrays import Array
from softhand_play.frames import (
    INTERVAL,
    Frame,
    StaticScene,
    Track,
    World,
    frame_of,
    static_scene_of,
)
from softhand_play.messages import Look, Report
from softhand_trials.trials import StartedScene, TrialSettings

HISTORY_SPAN = 20.0  # simulated time shown in the plots [s]
LARGEST_DELAY = 0.2  # wall time; a simulation that is later does not try to catch up [s]
PACE_WINDOW = 1.0  # wall time over which the speed is measured [s]
IDLE_SLEEP = 0.02  # between two checks for work [s]
FASTEST_PACE = 1000.0  # times real time, which means as fast as possible
# what wrong files and values raise
INPUT_ERRORS = (ArithmeticError, LookupError, OSError, RuntimeError, TypeError, ValueError)


class _PlayedScene(InProcessScene):
    """A scene that calls a function after each step; its results are the same bit for bit."""

    def __init__(self, simulation: Simulation, passed: Callable[[Simulation], None]) -> None:
        super().__init__(simulation)
        self._passed = passed

    def step(self, duration: float) -> None:
        super().step(duration)
        self._passed(self.simulation)


class _Start(StartedScene):
    """A started world whose scene calls a function after each step."""

    def __init__(self, settings: TrialSettings, passed: Callable[[Simulation], None]) -> None:
        self._passed = passed
        super().__init__(settings)

    def _build(self) -> None:
        super()._build()
        self.scene = _PlayedScene(self.scene.simulation, self._passed)


class Pace:
    """Lets simulated time pass at most `speed` times as fast as wall time; 0.25 is slow motion."""

    def __init__(self) -> None:
        self.speed, self.measured = 1.0, 1.0
        self.anchor(0.0)

    def anchor(self, simulated: float) -> None:
        """Measure from here: this simulated time [s] belongs to the present wall time."""
        self._wall, self._simulated = time.perf_counter(), simulated
        self._since = self._wall, simulated

    def wait(self, simulated: float) -> None:
        """Sleep until the wall time to which a simulated time [s] belongs."""
        now = time.perf_counter()
        ahead = (simulated - self._simulated) / self.speed - (now - self._wall)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -LARGEST_DELAY:
            self._wall, self._simulated = now, simulated
        wall, before = self._since
        if now - wall > PACE_WINDOW:
            self.measured = (simulated - before) / (now - wall)
            self._since = now, simulated

    @property
    def is_slow(self) -> bool:
        """Whether the simulation is slower than its speed demands."""
        return self.measured < 0.9 * min(self.speed, 1.0)


class Source(ABC):
    """What a page shows and commands: a simulation or running nodes.

    Args:
        report: function that is called with a sentence on an error or a result.

    Attributes:
        keeps_pace: whether the user can choose its speed.
    """

    keeps_pace = False

    def __init__(self, report: Report) -> None:
        self._report = report
        self.pace = Pace()
        self.paused = self.is_running = self.is_building = False
        self.phase = ""
        self.now: Track | None = None  # the last seconds; another one after each new start
        self.track: Track | None = None  # a run that has ended
        self.is_watched: Callable[[], bool] = lambda: True  # by a browser
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run_thread, name="source", daemon=True)

    @property
    def frames(self) -> Sequence[Frame]:
        """The frames of the last seconds; empty before the start."""
        return () if self.now is None else self.now.frames

    def _begin(self, static_scene: StaticScene, frame: Frame) -> None:
        """Start a new track with its first frame."""
        self.now = Track(deque([frame], maxlen=round(HISTORY_SPAN / INTERVAL)), static_scene)

    def _run_thread(self) -> None:
        """Run `_work`; an error that ends the thread is reported and then logged by Python."""
        try:
            self._work()
        except Exception as error:
            sentence = f"{type(error).__name__}: {error}"
            self._report(f"stopped: {sentence}; start softhand-play again", Look.ERROR)
            raise

    @abstractmethod
    def _work(self) -> None:
        """The body of the thread; returns after `_closing` has been set."""

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()


class Player(Source):
    """Simulates a world, moved by commands or by its strategy.

    Args:
        world: the first world.
        report: as in `Source`.
    """

    keeps_pace = True

    def __init__(self, world: World, report: Report) -> None:
        super().__init__(report)
        self.world = world
        self.stops_at_phases = False
        self.result: GraspResult | None = None
        self._recorded: list[Frame] | None = None
        self._jobs: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._abort = threading.Event()
        self._start: _Start | None = None
        self._wanted = world
        self.play(world)
        self._thread.start()

    # ---------------------------------------------------------------- commands
    def play(self, world: World) -> None:
        """Change to another world; a running strategy is aborted. If the new world cannot be
        built, the error is reported and the old world stays.
        """
        self._wanted = world
        self._abort.set()
        self._jobs.put(lambda: self._build(world))

    def run_strategy(self, world: World) -> None:
        """Run the strategy of a world from its start."""
        self.play(world)
        self._jobs.put(lambda: self._run(world))

    def reset(self) -> None:
        """Go back to the start of the simulated world."""
        self._abort.set()
        self._jobs.put(self._reset)

    def abort(self) -> None:
        """Abort the running strategy: the hand is vented."""
        self._abort.set()

    def command_pressures(self, pressures: Array) -> None:
        """Command gauge pressures (channels,) [Pa]; NaN leaves a channel as it is. Ignored while a
        strategy runs.
        """
        self._command(lambda scene: scene.command_pressure(pressures))

    def command_masses(self, masses: Array) -> None:
        """Command air masses (channels,) [kg above rest], otherwise as `command_pressures`."""
        self._command(lambda scene: scene.command_air(masses))

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Command a wrist pose: position (3,) [m], quaternion x, y, z, w (4,)."""
        self._command(lambda scene: scene.command_wrist(position, orientation))

    def close(self) -> None:
        """Abort a running strategy and end the thread."""
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
            except INPUT_ERRORS as error:
                self._report(str(error), Look.ERROR)
                if isinstance(error, SceneError):
                    self._reset()
        self._start = None

    def _next(self) -> None:
        try:
            self._jobs.get_nowait()()
        except Empty:
            if self._start is None or self.paused:
                time.sleep(IDLE_SLEEP)
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
                _ = start.empty_course  # simulates a trial and keeps its result for the run
        finally:
            self.is_building = False
        self._start, self.world = start, world
        self._anew(start, static_scene_of(start.scene.simulation))

    def _reset(self) -> None:
        if self._start is not None and self.now is not None:
            self._start.place(self.world.placement)
            self._anew(self._start, self.now.static_scene)

    def _anew(self, start: _Start, static_scene: StaticScene) -> None:
        self.phase = ""
        self.pace.anchor(0.0)
        self._begin(static_scene, frame_of(start.scene.simulation))

    def _run(self, world: World) -> None:
        """Run the strategy unless its world could not be built or another one is wanted by now."""
        self._abort.clear()
        start, now = self._start, self.now
        superseded = not self.world is world is self._wanted or self._closing.is_set()
        if start is None or now is None or superseded:
            return
        if now.static_scene.object is None:
            raise ValueError(
                f"scene: expected a scene with an object, got {now.static_scene.scene.name}"
            )
        frames: list[Frame] = []
        self._recorded = frames
        self.is_running, self.paused, self.result = True, False, None
        try:
            result = start.run(world.placement, on_phase=self._enter, abort=self._abort)
        finally:
            self._recorded, self.is_running = None, False
        ending = f"{result.outcome}: {result.reason}"
        if frames:
            self.track = Track(frames, now.static_scene, ending)
        self.result = result
        known = f"; the map has: {world.known_outcome}" if world.known_outcome else ""
        look = Look.SUCCESS if result.gripped else Look.ERROR
        self._report(f"{ending}{known}", look)

    def _enter(self, phase: str) -> None:
        if self.stops_at_phases and self.phase and phase not in (PHASE_DONE, PHASE_FAILED):
            self.paused = True
        self.phase = phase

    def _passed(self, simulation: Simulation) -> None:
        """After each step: take a frame if one is due, keep the pace, wait while paused."""
        time_now = simulation.time
        if self.now is not None and time_now > self.now.frames[-1].time + INTERVAL - 1e-6:
            frame = frame_of(simulation, self.phase)
            self.now.frames.append(frame)
            if self._recorded is not None:
                self._recorded.append(frame)
        self.pace.wait(time_now)
        while self.paused and self.is_running and not self._abort.is_set():
            time.sleep(IDLE_SLEEP)
            self.pace.anchor(time_now)
