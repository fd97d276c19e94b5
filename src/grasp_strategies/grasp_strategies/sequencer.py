"""Runs a strategy on a scene: commands wrist and air, ends phases, handles an abort, judges."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

import numpy as np

from grasp_strategies.judging.failure import ABORTED, DIVERGED, SCENE_FAILED, TIMED_OUT, GraspWatch
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.pose import (
    IDENTITY_QUATERNION,
    Motion,
    Pose,
    duration_at_speed,
    heading,
    inverse,
)
from grasp_strategies.scene import AirTarget, Array, Observation, Scene, SceneError
from grasp_strategies.strategy import Phase, Strategy, Waypoint
from softhand_common.documents.quoted import listed, quoted, shortened
from softhand_common.numerics.rotations import compose, from_rpy

CONTROL_STEP = 0.01  # [s]
TIME_TOLERANCE = 1e-9  # [s]
VENT_ACTION, HOLD_ACTION = "vent", "hold"
ABORT_ACTIONS = (VENT_ACTION, HOLD_ACTION)
AIR_QUANTITIES = ("air_mass_error", "pressure_error", "pressure")  # count once the ramp is over
PHASE_DONE, PHASE_FAILED = "done", "failed"  # what `on_phase` gets after the last phase; or ABORTED


class PhaseRun:
    """One phase as it runs, from its first observation: its motion, its air ramp, and their times
    [s].
    """

    def __init__(
        self,
        phase: Phase,
        object_rpy: tuple[float, float, float] | None,
        seen: Observation,
        commanded_pose: Pose,
        commanded_air: AirTarget,
        channels: tuple[str, ...],
    ) -> None:
        self.phase, self.start, self.start_force = phase, seen.time, seen.wrist_force
        self.air_goal = commanded_air.changed(phase.air_mass, phase.pressure, channels)
        self._air_start = commanded_air.start(self.air_goal, seen)
        self.motion: Motion | None = None
        if phase.wrist is not None:
            goal = goal_pose(phase.wrist, seen, commanded_pose, object_rpy)
            pivot = np.array(phase.wrist.pivot)
            duration = _motion_duration(phase, commanded_pose, goal, pivot)
            self.motion = Motion(commanded_pose, goal, duration, pivot if pivot.any() else None)

    @property
    def ramp(self) -> float:
        """Duration of the air ramp [s]."""
        return self.phase.air_ramp

    @property
    def least_duration(self) -> float:
        """Time until motion, ramp and stated duration are all over [s]."""
        moving, phase = self.motion.duration if self.motion else 0.0, self.phase
        return max(moving, self.ramp, phase.duration or 0.0, phase.release or 0.0)

    def air_at(self, elapsed: float) -> AirTarget:
        """Commanded air at a time [s] since the phase began."""
        if elapsed >= self.ramp - TIME_TOLERANCE:
            return self.air_goal
        return self._air_start.towards(self.air_goal, elapsed / self.ramp)


def _motion_duration(phase: Phase, start: Pose, goal: Pose, pivot: Array) -> float:
    if phase.speed is None:
        return phase.duration or 0.0
    return duration_at_speed(start, goal, phase.speed, phase.turn_speed, pivot)


def goal_pose(
    waypoint: Waypoint,
    seen: Observation,
    commanded: Pose,
    object_rpy: tuple[float, float, float] | None,
) -> Pose:
    """Pose of the wrist in the world at a waypoint, given the observation and the commanded pose at
    the start of its phase.
    """
    pivot = np.array(waypoint.pivot)
    commanded = commanded.shifted(pivot)
    frames = {
        "environment": Pose(np.zeros(3), IDENTITY_QUATERNION),
        "wrist": commanded,
        "wrist_level": Pose(commanded.position, IDENTITY_QUATERNION),
        "object": Pose(seen.object_position, _object_heading(seen.object_orientation, object_rpy)),
    }
    orientation = IDENTITY_QUATERNION if waypoint.rpy is None else from_rpy(waypoint.rpy)
    goal = frames[waypoint.frame].compose(Pose(np.array(waypoint.position), orientation))
    if waypoint.rpy is None:
        goal = Pose(goal.position, commanded.orientation)
    return goal.shifted(-pivot)


def _object_heading(orientation: Array, object_rpy: tuple[float, float, float] | None) -> Array:
    """Rotation about the vertical from the orientation that waypoints assume to the object's."""
    if object_rpy is None:
        return IDENTITY_QUATERNION
    return heading(compose(orientation, inverse(from_rpy(object_rpy))))


class _Aborted(Exception):
    """The abort flag was seen."""


class _PhaseTimedOut(Exception):
    """No end condition of a phase became true in time."""


class _Decided(Exception):
    """The remaining phases cannot change the verdict."""


class Sequencer:
    """One run of one strategy.

    Args:
        scene: the scene in which it runs.
        strategy: the strategy that is run.
        options: names of the optional phases to run.
        control_step: time between two commands [s].
        on_phase: called with each phase's name, and at the end with `done`, `aborted` or `failed`.
        abort: event that ends the run; any thread may set it at any time.
        abort_action: what an abort does with the air: `vent` opens every outlet, `hold` keeps it.
        decided: called after each control step; if it returns a text, the run ends early with this
            text as its reason.

    Raises:
        ValueError: an unknown option, channel or action, or a control step that is not positive.
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
        abort_action: str = VENT_ACTION,
        decided: Callable[[GraspWatch], str] | None = None,
    ) -> None:
        self._decided = decided
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
            for key, commands in (("air_mass", phase.air_mass), ("pressure", phase.pressure)):
                self._check_channels(f"phase {shortened(phase.name)}: {key}", commands)

    def _check_channels(self, place: str, commands: Iterable[str]) -> None:
        foreign = sorted(set(commands) - set(self._scene.channels))
        if foreign:
            raise ValueError(
                f"strategy {shortened(self._strategy.name)}: {place}: expected channels of the "
                f"hand ({', '.join(self._scene.channels)}), got {listed(foreign)}"
            )

    def run(self) -> GraspResult:
        """Run all phases and judge; an abort, a time-out or a failing scene ends the run early.

        An abort that came before the end of the run is obeyed even if the run noticed it only after
        its end.
        """
        result = self._begin_and_run()
        if result.cause == ABORTED or not self._abort.is_set():
            return result
        done, safe = abort_scene(self._scene, self._abort_action)
        return result.stopped(f"{result.reason}; aborted: {done}", safe, self._phase, ABORTED)

    def _begin_and_run(self) -> GraspResult:
        try:
            first = self._scene.observe()
        except SceneError as error:
            self._on_phase(PHASE_FAILED)
            return GraspResult.not_begun(str(error))
        self._grasp = GraspWatch(self._strategy, self._scene.hand_bodies, first)
        self._observed = first
        self._commanded_air = AirTarget(first.air_mass, np.full_like(first.air_mass, np.nan))
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
            return self._stop(ABORTED, reason, ABORTED, safe)
        except _PhaseTimedOut as timed_out:
            return self._stop(PHASE_FAILED, str(timed_out), TIMED_OUT)
        except _Decided as sure:
            if not self._grasp.result().gripped:
                return self._stop(PHASE_FAILED, f"phase {self._phase}: {sure}")
        except SceneError as error:
            # in process and over ROS alike it is the simulator's sentence that tells
            cause = DIVERGED if DIVERGED in str(error) else SCENE_FAILED
            return self._stop(PHASE_FAILED, f"phase {self._phase}: {error}", cause)
        self._on_phase(PHASE_DONE)
        return self._grasp.result()

    def _stop(self, ending: str, reason: str, cause: str = "", safe: bool = True) -> GraspResult:
        """The result of a run that ended early; without a cause, the judge's."""
        self._on_phase(ending)
        return self._grasp.result().stopped(reason, safe, self._phase, cause)

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
        self._hand_over(phase)
        while True:
            self._command(run, self._scene.time - run.start)
            self._scene.step(self._control_step)
            self._raise_if_aborted()
            self._observed = self._scene.observe()
            self._grasp.watch(self._observed, phase.name)
            self._raise_if_decided()
            if self._ended(run):
                break
        self._finish(run)

    def _hand_over(self, phase: Phase) -> None:
        """Hold the object out to the hand, or release it, as the phase says."""
        if phase.held_out is not None:
            held = phase.held_out
            self._scene.hold_object(np.array(held.position), np.array(held.orientation))
        if phase.release is not None:
            self._scene.release_object(phase.release)

    def _finish(self, run: PhaseRun) -> None:
        """Command the exact goals, however long the last step was; after a phase that a condition
        ended, only the air goal if its ramp is over.
        """
        if not run.phase.conditional:
            self._command_wrist(run, run.least_duration)
        self._command_air(run, self._observed.time - run.start)

    def _command(self, run: PhaseRun, elapsed: float) -> None:
        self._command_wrist(run, elapsed)
        self._command_air(run, elapsed)

    def _command_wrist(self, run: PhaseRun, elapsed: float) -> None:
        if run.motion is not None:
            self._commanded_pose = run.motion.at(elapsed)
            self._scene.command_wrist(
                self._commanded_pose.position, self._commanded_pose.orientation
            )

    def _command_air(self, run: PhaseRun, elapsed: float) -> None:
        before, wanted = self._commanded_air, run.air_at(elapsed)
        first = elapsed == 0
        if run.phase.air_mass and (first or not _same(wanted.masses, before.masses)):
            self._scene.command_air(wanted.masses)
        if run.phase.pressure and (first or not _same(wanted.pressures, before.pressures)):
            self._scene.command_pressure(wanted.pressures)
        self._commanded_air = wanted

    def _raise_if_aborted(self) -> None:
        if self._abort.is_set():
            raise _Aborted

    def _raise_if_decided(self) -> None:
        reason = self._decided(self._grasp) if self._decided else ""
        if reason:
            raise _Decided(reason)

    def _ended(self, run: PhaseRun) -> bool:
        phase, elapsed = run.phase, self._observed.time - run.start
        if not phase.conditional:
            return elapsed > run.least_duration - TIME_TOLERANCE
        quantities = self._quantities(run)
        ramp_over = elapsed > run.ramp - TIME_TOLERANCE
        for condition in phase.until:
            counts = ramp_over or condition.quantity not in AIR_QUANTITIES
            if counts and condition.holds(quantities[condition.quantity]):
                return True
        if phase.until_touching and phase.until_touching <= self._observed.touching:
            return True
        if phase.time_out is None or elapsed < phase.time_out:
            return False
        if phase.next_on_time_out:
            return True
        raise _PhaseTimedOut(_time_out_sentence(phase, quantities, self._observed.touching))

    def _quantities(self, run: PhaseRun) -> dict[str, float]:
        """The quantities of end conditions now, in the units of `strategy.QUANTITIES`."""
        seen, goal = self._observed, run.air_goal
        return {
            "contact_force": float(np.linalg.norm(seen.wrist_force - run.start_force)),
            "height": self._grasp.judge.rise(seen),
            "air_mass_error": _largest_error(goal.masses, seen.air_mass),
            "pressure_error": _largest_error(goal.pressures, seen.pressure),
            "pressure": float(np.max(seen.pressure, initial=0.0)),
        }


def _same(first: Array, second: Array) -> bool:
    return bool(np.array_equal(first, second, equal_nan=True))


def _largest_error(goal: Array, seen: Array) -> float:
    """Greatest deviation of the channels that have a goal; 0 without one."""
    return float(np.max(np.abs(goal - seen)[~np.isnan(goal)], initial=0.0))


def _time_out_sentence(phase: Phase, quantities: dict[str, float], touching: frozenset[str]) -> str:
    wanted, got = (
        [str(c) for c in phase.until],
        [f"{c.quantity} {quantities[c.quantity]:.3g}" for c in phase.until],
    )
    if phase.until_touching:
        wanted.append(f"touching {', '.join(sorted(phase.until_touching))}")
        got.append(f"touching {', '.join(sorted(touching)) or 'nothing'}")
    return (
        f"phase {phase.name}: expected {' or '.join(wanted)} within {phase.time_out:g} s, "
        f"got {', '.join(got)}"
    )


def abort_scene(scene: Scene, action: str) -> tuple[str, bool]:
    """Vent, or hold the air as it is; the wrist stays at its commanded pose.

    Returns a text for the user, and whether the action was carried out.
    """
    try:
        if action == VENT_ACTION:
            scene.vent()
            return "vented", True
        scene.command_air(scene.observe().air_mass)
        return "holds", True
    except SceneError as error:
        return f"could not {action}: {error}", False
