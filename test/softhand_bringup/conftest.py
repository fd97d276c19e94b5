"""A synthetic grasp, shared by the tests of reading and of drawing."""

import numpy as np
import pytest
import synthetic_bag as synthetic

FINGER = [f"finger_{k}_{axis}" for k in range(2) for axis in "xyz"]  # joints of a single finger


@pytest.fixture
def grasp_bag(tmp_path):
    """Folder of a bag: 4 s, one channel filled from 1 s on, the object lifted by 0.1 m."""
    bag = synthetic.SyntheticBag(tmp_path / "bag")
    bag.say("/grasp/phase", 0.2, "idle")
    for seconds in np.arange(0.0, 4.001, 0.02):
        bag.tick(seconds)
        if abs(seconds - 1.0) < 1e-9:
            bag.say("/grasp/phase", seconds, "close")
            bag.write("/pneumaticbox/command", seconds, synthetic.command(0.0, ["a"], [2e-5], 1.0))
        if abs(seconds - 3.0) < 1e-9:
            bag.say("/grasp/phase", seconds, "lift")
        mass = 2e-5 * min(max(seconds - 1.0, 0.0), 1.0)
        state = synthetic.joint_state(seconds, ["a"], [mass], [1e9 * mass])
        bag.write("/pneumaticbox/state", seconds, state)
        height = 0.03 + 0.1 * max(seconds - 3.0, 0.0)
        bag.write("/scene/object_pose", seconds, synthetic.pose(seconds, (0.0, 0.0, height)))
        bent = [0.0, 0.1 * seconds, 0.0]
        joints = synthetic.joint_state(seconds, FINGER, [*bent, *bent])
        bag.write("/hand/joint_states", seconds, joints)
        bag.write("/wrist/pose", seconds, synthetic.pose(seconds, (0.0, 0.0, 0.3)))
    bag.close()
    return tmp_path / "bag"
