"""Made-up courses of observations: a grasp from the table to the end of the hold, and what may go
wrong on the way. The wrist follows a simple plan, the object is where the course says.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from grasp_strategies.pose import Pose
from grasp_strategies.scene import Observation

STEP = 0.01  # [s]
HAND = frozenset({"index", "thumb", "palm_plate"})
TABLE, GRIP = frozenset({"table"}), frozenset({"index", "thumb"})
REST = 0.0325  # height of the object's centre on the table [m]
LIFT = 0.14  # of the wrist [m]
PLAN = (("approach", 0.5), ("close", 0.5), ("lift", 1.0), ("steady", 0.3), ("hold", 1.1))  # [s]
START = Pose(np.array([0.02, -0.01, REST]), np.array([0.0, 0.0, 0.0, 1.0]))
WRIST = Rotation.from_euler("xyz", [0.2, 2.3, 0.6]).as_quat()


@dataclass(frozen=True)
class Moment:
    """One observation of a course: phase, time [s] since that phase began, what was seen."""

    phase: str
    elapsed: float
    observation: Observation


def gripped():
    """A grasp as it should be: the object lies, is gripped, and follows the wrist."""
    moments, time = [], 0.0
    for phase, duration in PLAN:
        for elapsed in np.arange(1, round(duration / STEP) + 1) * STEP:
            rise = LIFT * min(elapsed, 1.0) if phase == "lift" else 0.0
            rise = LIFT if phase in ("steady", "hold") else rise
            time += STEP
            moments.append(Moment(phase, float(elapsed), _seen(time, rise, phase)))
    return moments


def _seen(time, rise, phase):
    touching = {"approach": TABLE, "close": TABLE | GRIP}.get(phase, GRIP)
    return Observation(
        time=float(time),
        wrist_position=np.array([-0.03, 0.0, 0.12 + rise]),
        wrist_orientation=WRIST,
        wrist_force=np.zeros(3),
        object_position=START.position + [0.0, 0.0, rise],
        object_orientation=START.orientation,
        air_mass=np.zeros(2),
        pressure=np.zeros(2),
        touching=touching,
    )


FIRST = _seen(0.0, 0.0, "approach")


def changed(moments, phase, begin, end, change):
    """The course with `change(observation, elapsed)` in a phase from `begin` to `end` [s]."""
    return [
        replace(moment, observation=change(moment.observation, moment.elapsed - begin))
        if moment.phase == phase and begin - 1e-9 <= moment.elapsed <= end + 1e-9
        else moment
        for moment in moments
    ]


def after(moments, phase, begin, change):
    """The course with `change(observation, elapsed)` from a time [s] in a phase to the end."""
    first = next(i for i, m in enumerate(moments) if m.phase == phase and m.elapsed >= begin - 1e-9)
    since = moments[first].observation.time
    return moments[:first] + [
        replace(moment, observation=change(moment.observation, moment.observation.time - since))
        for moment in moments[first:]
    ]


def shifted(x=0.0, y=0.0, z=0.0):
    """A change: the object is displaced in the axes of the wrist [m]."""

    def change(seen, elapsed):
        at = seen.object_in_wrist + [x, y, z]
        pose = seen.wrist.compose(Pose(at, START.orientation))
        return replace(seen, object_position=pose.position)

    return change


def turned(angle, axis="x"):
    """A change: the object is turned by an angle [deg] in the hand."""
    turn = Rotation.from_euler(axis, angle, degrees=True)

    def change(seen, elapsed):
        now = turn * Rotation.from_quat(seen.object_orientation)
        return replace(seen, object_orientation=now.as_quat())

    return change


def lifted(height):
    """A change: the wrist and the object in it are up by a height [m]."""

    def change(seen, elapsed):
        down = np.array([0.0, 0.0, seen.object_position[2] - REST - height])
        return replace(
            seen,
            wrist_position=seen.wrist_position - down,
            object_position=seen.object_position - down,
        )

    return change


def touched_by(*bodies):
    """A change: other bodies touch the object as well."""
    return lambda seen, elapsed: replace(seen, touching=seen.touching | set(bodies))


def lying(x=0.0, y=0.0, height=REST, turn=None, touching=TABLE):
    """A change: the object lies on the table, displaced by x, y [m], its centre at a height [m],
    turned by a rotation.
    """

    def change(seen, elapsed):
        place = np.array([START.position[0] + x, START.position[1] + y, height])
        rotation = START.orientation if turn is None else turn.as_quat()
        return replace(
            seen, object_position=place, object_orientation=rotation, touching=frozenset(touching)
        )

    return change


def falling(seen, elapsed):
    """A change: the object falls freely from where it is, until it lies."""
    height = max(REST, seen.object_position[2] - 0.5 * 9.81 * elapsed**2)
    place = np.array([*seen.object_position[:2], height])
    touching = TABLE if height == REST else frozenset()
    return replace(seen, object_position=place, touching=touching)


def nowhere(seen, elapsed):
    """A change: the simulation has diverged."""
    return replace(seen, object_position=np.full(3, np.nan))
