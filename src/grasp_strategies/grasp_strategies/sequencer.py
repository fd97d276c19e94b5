"""Runs a strategy on a scene: commands wrist and air, ends phases, heeds an abort, judges."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

import numpy as np

from grasp_strategies.failure import ABORTED, DIVERGED, SCENE_FAILED, TIMED_OUT, GraspWatch
from grasp_strategies.judge import GraspResult
from grasp_strategies.pose import IDENTITY, Motion, Pose, duration_at_speed, heading, inverse
from grasp_strategies.scene import Array, Observation, Scene, SceneError, masses_in_order
from grasp_strategies.strategy import Phase, Strategy, Waypoint
from softhand_model.documents.quoted import listed, quoted, shortened
from softhand_model.numerics.rotations import compose, from_rpy

CONTROL_STEP = 0.01  # [s]
VENT, HOLD = "vent", "hold"
ABORT_ACTIONS = (VENT, HOLD)
DONE, FAILED = "done", "failed"  # what `on_phase` gets after the last phase; or ABORTED


class PhaseRun:
    """One phase from where it begins: its motion, its ramp of the air and their times [s]."""

    def __init__(
        self,
        phase: Phase,
        object_rpy: tuple[float, float, float] | None,
        seen: Observation,
        commanded_pose: Pose,
        commanded_air: Array,
        channels: tuple[str, ...],
    ) -> None:
        self.phase, self.start = phase, seen.time
        self.air_goal = masses_in_order(phase.air_mass, channels, commanded_air)
        self._air_start = commanded_air
        self.motion: Motion | None = None
        if phase.wrist is not None:
            goal = goal_pose(phase.wrist, seen, commanded_pose, object_rpy)
            duration = _motion_duration(phase, commanded_pose, goal)
            self.motion = Motion(commanded_pose, goal, duration)

    @property
    def least_duration(self) -> float:
        """Time until motion, ramp and stated duration are all over [s]."""
        moving = self.motion.duration if self.motion else 0.0
        ramp = self.phase.air_ramp if self.phase.air_mass else 0.0
        return max(moving, ramp, self.phase.duration or 0.0)

    def air_at(self, elapsed: float) -> Array:
        """Commanded air masses (channels,) [kg] at a time [s] since the phase began."""
        ramp = self.phase.air_ramp
        if elapsed >= ramp:
            return self.air_goal
        return self._air_start + (elapsed / ramp) * (self.air_goal - self._air_start)


def _motion_duration(phase: Phase, start: Pose, goal: Pose) -> float:
    if phase.speed is None:
        return phase.duration or 0.0
    return duration_at_speed(start, goal, phase.speed, phase.turn_speed)


def goal_pose(
    waypoint: Waypoint,
    seen: Observation,
    commanded: Pose,
    object_rpy: tuple[float, float, float] | None,
) -> Pose:
    """Pose in the world of a waypoint, by what is seen and commanded when its phase begins."""
    frames = {
        "environment": Pose(np.zeros(3), IDENTITY),
        "wrist": commanded,
        "wrist_level": Pose(commanded.position, IDENTITY),
        "object": Pose(seen.object_position, _object_heading(seen.object_orientation, object_rpy)),
    }
    orientation = IDENTITY if waypoint.rpy is None else from_rpy(waypoint.rpy)
    goal = frames[waypoint.frame].compose(Pose(np.array(waypoint.position), orientation))
    return Pose(goal.position, commanded.orientation) if waypoint.rpy is None else goal


def _object_heading(orientation: Array, object_rpy: tuple[float, float, float] | None) -> Array:
    """Rotation about the vertical from the orientation that waypoints suppose to the object's."""
    if object_rpy is None:
        return IDENTITY
    return heading(compose(orientation, inverse(from_rpy(object_rpy))))


class _Aborted(Exception):
    """The abort flag was seen."""


class _PhaseTimedOut(Exception):
    """No end condition of a phase came true in time."""


class Sequencer:
    """One run of one strategy.

    `options` switches optional phases on; `control_step` [s] is the time between two commands;
    `on_phase` is told each phase's name and at the end `done`, `aborted` or `failed`; `abort` may
    be set by any thread at any time, and `abort_action` says what then happens to the air: `vent`
    opens every outlet, `hold` keeps what the channels contain. Raises ValueError for an unknown
    option, channel, action or a control step that is not positive.
    """

    def __init__(
        self,
        scene: Scene,
        strategy: Strategy,
        *,
        options: Iterable[str] = (),
        control_step: float = CONTROL_STEP,
        on_phase: Callable[[str], None] = lambda name: None,
        abort: threading.Event | None = None,
        abort_action: str = VENT,
    ) -> None:
        self._scene, self._strategy = scene, strategy
        self._options = frozenset(options)
        self._control_step = control_step
        self._on_phase = on_phase
        self._abort = abort or threading.Event()
        self._abort_action = abort_action
        self._phase = ""
        self._check()

    def _check(self) -> None:
        unknown = self._options - self._strategy.options
        if unknown:
            raise ValueError(
                f"options: expected some of {sorted(self._strategy.options)}, "
                f"got {quoted(sorted(unknown))}"
            )
        if not self._control_step > 0:
            raise ValueError(
                f"control_step: expected a number above 0 [s], got {self._control_step!r}"
            )
        if self._abort_action not in ABORT_ACTIONS:
            raise ValueError(
                f"abort_action: expected one of {', '.join(ABORT_ACTIONS)}, "
                f"got {self._abort_action!r}"
            )
        for phase in self._strategy.phases:
            foreign = sorted(set(phase.air_mass) - set(self._scene.channels))
            if foreign:
                raise ValueError(
                    f"strategy {shortened(self._strategy.name)}: phase {shortened(phase.name)}: "
                    f"air_mass: expected "
                    f"channels of the hand ({', '.join(self._scene.channels)}), "
                    f"got {listed(foreign)}"
                )

    def run(self) -> GraspResult:
        """Run all phases and judge; an abort, a time-out or a failing scene ends the run early."""
        try:
            first = self._scene.observe()
        except SceneError as error:
            self._on_phase(FAILED)
            return GraspResult.not_begun(str(error))
        self._grasp = GraspWatch(self._strategy, self._scene.hand_bodies, first)
        self._observed, self._commanded_air = first, first.air_mass
        self._commanded_pose = first.wrist
        return self._run_phases()

    def _run_phases(self) -> GraspResult:
        try:
            for phase in self._strategy.phases:
                if phase.option is None or phase.option in self._options:
                    self._run_phase(phase)
        except _Aborted:
            reason, safe = abort_scene(self._scene, self._abort_action)
            reason = f"aborted in phase {self._phase}: {reason}"
            return self._stop(ABORTED, ABORTED, reason, safe)
        except _PhaseTimedOut as timed_out:
            return self._stop(FAILED, TIMED_OUT, str(timed_out))
        except SceneError as error:
            # in process and over ROS alike it is the simulator's sentence that tells
            cause = DIVERGED if DIVERGED in str(error) else SCENE_FAILED
            return self._stop(FAILED, cause, f"phase {self._phase}: {error}")
        self._on_phase(DONE)
        return self._grasp.result()

    def _stop(self, ending: str, cause: str, reason: str, safe: bool = True) -> GraspResult:
        self._on_phase(ending)
        return self._grasp.result().stopped(reason, safe, phase=self._phase, cause=cause)

    # ---------------------------------------------------------------- one phase
    def _run_phase(self, phase: Phase) -> None:
        self._phase = phase.name
        self._raise_if_aborted()
        self._on_phase(phase.name)
        run = PhaseRun(
            phase,
            self._strategy.object_rpy,
            self._observed,
            self._commanded_pose,
            self._commanded_air,
            self._scene.channels,
        )
        self._grasp.watch(
            self._observed, phase.name
        )  # the hold counts from the instant at which its phase begins
        while True:
            self._command(run, self._scene.time - run.start)
            self._scene.step(self._control_step)
            self._raise_if_aborted()
            self._observed = self._scene.observe()
            self._grasp.watch(self._observed, phase.name)
            if self._ended(run):
                break
        if not phase.until:  # to the goal itself, however long the last step was
            self._command(run, run.least_duration)

    def _command(self, run: PhaseRun, elapsed: float) -> None:
        if run.motion is not None:
            self._commanded_pose = run.motion.at(elapsed)
            self._scene.command_wrist(
                self._commanded_pose.position, self._commanded_pose.orientation
            )
        if run.phase.air_mass:
            wanted = run.air_at(elapsed)
            if elapsed == 0 or not np.array_equal(wanted, self._commanded_air):
                self._scene.command_air(wanted)
            self._commanded_air = wanted

    def _raise_if_aborted(self) -> None:
        if self._abort.is_set():
            raise _Aborted

    def _ended(self, run: PhaseRun) -> bool:
        phase, elapsed = run.phase, self._observed.time - run.start
        if not phase.until:
            return elapsed > run.least_duration - 1e-9
        quantities = self._quantities(run)
        if any(condition.holds(quantities[condition.quantity]) for condition in phase.until):
            return True
        if phase.time_out is None or elapsed < phase.time_out:
            return False
        if phase.next_on_time_out:
            return True
        raise _PhaseTimedOut(_time_out_sentence(phase, quantities))

    def _quantities(self, run: PhaseRun) -> dict[str, float]:
        """The quantities of end conditions now, in the units of `strategy.QUANTITIES`."""
        seen = self._observed
        return {
            "contact_force": float(np.linalg.norm(seen.wrist_force)),
            "height": self._grasp.judge.rise(seen),
            "air_mass_error": float(np.max(np.abs(run.air_goal - seen.air_mass), initial=0.0)),
            "pressure": float(np.max(seen.pressure, initial=0.0)),
        }


def _time_out_sentence(phase: Phase, quantities: dict[str, float]) -> str:
    wanted = " or ".join(map(str, phase.until))
    got = ", ".join(f"{c.quantity} {quantities[c.quantity]:.3g}" for c in phase.until)
    return f"phase {phase.name}: expected {wanted} within {phase.time_out:g} s, got {got}"


def abort_scene(scene: Scene, action: str) -> tuple[str, bool]:
    """Vent, or hold the air as it is; the wrist stays where it was commanded.

    Returns a text about it and whether it was done.
    """
    try:
        if action == VENT:
            scene.vent()
            return "vented", True
        scene.command_air(scene.observe().air_mass)
        return "holds", True
    except SceneError as error:
        return f"could not {action}: {error}", False
