"""A bag of a hand of this suite with made-up places of its fingertips."""

import numpy as np
from synthetic_bag import SyntheticBag, T, header, joint_state

from softhand_common.numerics.rotations import from_rpy

CHANNELS = ["a", "b", "c", "d"]
TIPS, RATE = 5, 50.0  # of RBO Hand 2; [Hz]
PALM_UP, PALM_DOWN = (0.0, 0.0, 0.0), (0.0, 3.0, 0.0)
FIST, POINT = [60e3, 60e3, 40e3, 0.0], [60e3, 0.0, 40e3, 0.0]
OPEN = [0.0] * 4


def place_of(tip, pressures, rpy):
    """A made-up place [m] of a tip that goes with all pressures and with the wrist's attitude."""
    return 0.1 * tip + 1e-6 * np.array(pressures[:3]) + 1e-3 * np.array(rpy)


def turn_message(rpy):
    return T["geometry_msgs/msg/Quaternion"](*map(float, from_rpy(rpy)))


def pose_message(place, rpy=PALM_UP):
    point = T["geometry_msgs/msg/Point"](*map(float, place))
    return T["geometry_msgs/msg/Pose"](point, turn_message(rpy))


def recorded(folder, sequence, hold=1.0, move=0.5, joints=(), forces=()):
    """A bag with poses (pressures, rpy), each held for `hold` [s] after a ramp of `move` [s].

    forces: on the wrist along z in each pose [N]; empty: not recorded.
    """
    bag, time, last = SyntheticBag(folder), 5.0, OPEN
    if joints:
        angles = joint_state(time, joints, [0.0] * len(joints))
        bag.write("/hand/joint_states", time, angles)
    for number, (pressures, rpy) in enumerate(sequence):
        for step in range(round((hold + move) * RATE)):
            share = min(1.0, step / (move * RATE))
            now = [(1.0 - share) * a + share * b for a, b in zip(last, pressures, strict=True)]
            bag.tick(time)
            bag.write("/pneumaticbox/state", time, joint_state(time, CHANNELS, OPEN, now))
            tips = [pose_message(place_of(tip, now, rpy)) for tip in range(TIPS)]
            bag.write(
                "/hand/fingertips",
                time,
                T["geometry_msgs/msg/PoseArray"](header(time, "wrist"), tips),
            )
            wrist = T["geometry_msgs/msg/PoseStamped"](header(time), pose_message([0, 0, 0], rpy))
            bag.write("/wrist/pose", time, wrist)
            if forces:
                vector = T["geometry_msgs/msg/Vector3"]
                load = T["geometry_msgs/msg/Wrench"](
                    vector(0.0, 0.0, forces[number]), vector(0.0, 0.0, 0.0)
                )
                stamped = T["geometry_msgs/msg/WrenchStamped"](header(time), load)
                bag.write("/wrist/wrench", time, stamped)
            time += 1.0 / RATE
        last = pressures
    bag.close()
    return folder


def touching(folder, rows, results=(), rate=RATE, rpy=PALM_UP):
    """A bag with one row (force along z [N], height of wrist and of object [m], mass [kg] and
    pressure [Pa] of all channels) for each sample, from 5 s on; an object whose height is None is
    not recorded. results: (time [s], strategy) of grasps that ended. rpy [rad]: of the wrist.
    """
    bag, vector = SyntheticBag(folder), T["geometry_msgs/msg/Vector3"]
    for number, (force, wrist, thing, mass, pressure) in enumerate(rows):
        time = 5.0 + number / rate
        bag.tick(time)
        state = joint_state(time, CHANNELS, [mass] * 4, [pressure] * 4)
        bag.write("/pneumaticbox/state", time, state)
        array = T["geometry_msgs/msg/PoseArray"](
            header(time, "wrist"), TIPS * [pose_message([0] * 3)]
        )
        bag.write("/hand/fingertips", time, array)
        stamped = T["geometry_msgs/msg/PoseStamped"]
        bag.write("/wrist/pose", time, stamped(header(time), pose_message([0, 0, wrist], rpy)))
        if thing is not None:
            bag.write(
                "/scene/object_pose", time, stamped(header(time), pose_message([0.01, 0, thing]))
            )
        load = T["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, force), vector(0.1 * force, 0.0, 0.0))
        bag.write("/wrist/wrench", time, T["geometry_msgs/msg/WrenchStamped"](header(time), load))
    for seconds, name in results:
        status = T["diagnostic_msgs/msg/DiagnosticStatus"](0, f"sequencer: {name}", "", "", [])
        kind = T["diagnostic_msgs/msg/DiagnosticArray"]
        bag.write("/grasp/result", seconds, kind(header(seconds), [status]))
    bag.close()
    return folder
