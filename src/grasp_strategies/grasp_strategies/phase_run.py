"""What a phase means from where it begins: the way of wrist and air, and how long they take."""

from __future__ import annotations

import numpy as np

from grasp_strategies.motion import Motion, duration_at_speed
from grasp_strategies.pose import IDENTITY, Pose, heading, inverse
from grasp_strategies.scene import Array, Observation, masses_in_order
from grasp_strategies.strategy import Phase, Waypoint
from softhand_model.rotation import compose, from_rpy


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
            self.motion = Motion(
                commanded_pose, goal, _motion_duration(phase, commanded_pose, goal)
            )

    @property
    def least_duration(self) -> float:
        """Time until motion, ramp and stated duration are all over [s]."""
        moving = self.motion.duration if self.motion else 0.0
        return max(
            moving, self.phase.air_ramp if self.phase.air_mass else 0.0, self.phase.duration or 0.0
        )

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
    turn = IDENTITY if waypoint.rpy is None else from_rpy(waypoint.rpy)
    goal = frames[waypoint.frame].compose(Pose(np.array(waypoint.position), turn))
    return Pose(goal.position, commanded.orientation) if waypoint.rpy is None else goal


def _object_heading(orientation: Array, object_rpy: tuple[float, float, float] | None) -> Array:
    """Turn about the vertical from the orientation that waypoints suppose to the object's."""
    if object_rpy is None:
        return IDENTITY
    return heading(compose(orientation, inverse(from_rpy(object_rpy))))
