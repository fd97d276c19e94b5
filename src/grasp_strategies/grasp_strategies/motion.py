"""Smooth motion of the wrist between two poses."""

from __future__ import annotations

from dataclasses import dataclass

from grasp_strategies.pose import Pose, angle_between, slerp

PEAK_TO_MEAN = (
    1.875  # greatest over mean speed of a minimum-jerk motion: the derivative of its course at 1/2
)


def minimum_jerk(fraction: float) -> float:
    """Course of a rest-to-rest motion of least jerk, 10 s^3 - 15 s^4 + 6 s^5, held outside 0..1.

    Source: Flash and Hogan, J. Neuroscience 5 (1985), 1688.

    >>> [minimum_jerk(s) for s in (-1.0, 0.0, 0.5, 1.0, 2.0)]
    [0.0, 0.0, 0.5, 1.0, 1.0]
    """
    s = min(1.0, max(0.0, fraction))
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


@dataclass(frozen=True)
class Motion:
    """Minimum-jerk motion of the position and slerp along the same course, in `duration` [s]."""

    start: Pose
    goal: Pose
    duration: float

    def at(self, elapsed: float) -> Pose:
        """Pose `elapsed` [s] after the start; the goal from `duration` on."""
        course = minimum_jerk(elapsed / self.duration) if self.duration > 0 else 1.0
        position = self.start.position + course * (self.goal.position - self.start.position)
        return Pose(position, slerp(self.start.orientation, self.goal.orientation, course))


def duration_at_speed(start: Pose, goal: Pose, speed: float, turn_speed: float) -> float:
    """Duration [s] so that neither speed [m/s] nor turning [rad/s] is exceeded at its greatest."""
    distance = float(sum((goal.position - start.position) ** 2) ** 0.5)
    turn = angle_between(start.orientation, goal.orientation)
    return PEAK_TO_MEAN * max(distance / speed, turn / turn_speed)
