"""The URDF read by others: urdfdom, which robot_state_publisher reads it with, and PyBullet."""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.commands import hand as hand_command
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.urdf import joint_names, joint_positions, write_urdf
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

GRIPPER = str(Path(__file__).parents[2] / "examples/three_finger_gripper/gripper.yaml")
HANDS = ["rbo_hand_1", "rbo_hand_1_split", "rbo_hand_2", "single_finger", GRIPPER]


def layout_of(hand):
    return build_layout(load_hand(hand), 5, load_model(None))


def numbers(element, name):
    return np.array([float(text) for text in element.get(name).split()])


@pytest.mark.parametrize("hand", HANDS)
def test_the_parser_of_robot_state_publisher_accepts_it_as_one_tree_from_the_wrist(hand, tmp_path):
    path, layout = tmp_path / "hand.urdf", layout_of(hand)
    path.write_text(write_urdf(layout))
    check = shutil.which("check_urdf", path=str(Path(sys.executable).parent))
    found = subprocess.run([check, str(path)], capture_output=True, text=True, timeout=30)
    assert (found.returncode, found.stderr) == (0, "")
    root, children = re.search(r"root Link: (\w+) has (\d+) child", found.stdout).groups()
    assert (root, int(children)) == ("wrist", len(layout.bodies))
    seen = set(re.findall(r"child\(\d+\):\s+(\w+)", found.stdout))
    assert set(layout.names) < seen
    assert len(seen) == 3 * len(layout.names) + len(layout.bodies)


@pytest.mark.parametrize("hand", HANDS)
def test_moving_joints_are_those_of_joint_states_and_hold_all_angles_within_limits(hand):
    layout = layout_of(hand)
    robot = ElementTree.fromstring(write_urdf(layout))
    joints = robot.findall("joint")
    assert {joint.get("type") for joint in joints} == {"fixed", "revolute"}
    moving = [joint for joint in joints if joint.get("type") == "revolute"]
    assert [joint.get("name") for joint in moving] == joint_names(layout)
    turned = Rotation.random(len(layout.names), np.random.default_rng(3)).as_quat()
    for joint, angle in zip(moving, joint_positions(turned), strict=True):
        limit = joint.find("limit")
        assert float(limit.get("lower")) < angle < float(limit.get("upper"))
        assert min(float(limit.get("effort")), float(limit.get("velocity"))) > 0
        assert np.linalg.norm(numbers(joint.find("axis"), "xyz")) == pytest.approx(1.0)


@pytest.mark.parametrize("hand", HANDS)
def test_every_segment_has_its_mass_and_an_inertia_that_a_body_can_have(hand):
    layout = layout_of(hand)
    robot = ElementTree.fromstring(write_urdf(layout))
    bodies = {link.get("name"): link.find("inertial") for link in robot.findall("link")}
    mass = [float(bodies[name].find("mass").get("value")) for name in layout.names]
    np.testing.assert_allclose(mass, layout.mass, rtol=1e-5)
    for name in layout.names:
        inertia = bodies[name].find("inertia")
        x, y, z = (float(inertia.get(key)) for key in ("ixx", "iyy", "izz"))
        assert min(x, y, z) > 0 and 2 * max(x, y, z) <= x + y + z
        assert all(float(inertia.get(key)) == 0 for key in ("ixy", "ixz", "iyz"))


@pytest.mark.parametrize("hand", ["rbo_hand_1", "rbo_hand_2"])
def test_links_are_where_the_simulated_ones_are(hand, simulate, mass_for_pressure, tmp_path, capfd):
    simulation = simulate(hand=hand, scene="stand", step=0.005)
    gauge = np.linspace(10e3, 25e3, len(simulation.channels))
    masses = mass_for_pressure(simulation, gauge)
    for k in range(200):
        simulation.set_air_masses(masses * min(1, k / 100))
        simulation.step()
    layout, path = simulation.bodies.layout, tmp_path / "hand.urdf"
    path.write_text(write_urdf(layout))
    told = dict(zip(joint_names(layout), joint_positions(simulation.bodies.q), strict=True))
    shown = shown_links(path, told)
    capfd.readouterr()  # PyBullet tells of links without mass
    rest = shown_links(path, dict.fromkeys(told, 0.0))
    place, turn = simulation.wrist_pose()
    upright = Rotation.from_quat(turn).inv()
    moved = []
    for body, base in zip(layout.bodies, simulation.bodies.ids, strict=True):
        for link, name in enumerate(layout.names[body.joints]):
            state = pybullet.getLinkState(
                base,
                link,
                computeForwardKinematics=1,
                physicsClientId=simulation.engine.world.client,
            )
            position, orientation = shown[name]
            np.testing.assert_allclose(
                upright.apply(np.array(state[4]) - place), position, atol=1e-6
            )
            off = (upright * Rotation.from_quat(state[5])).inv() * Rotation.from_quat(orientation)
            assert off.magnitude() < 1e-5
            moved.append(np.linalg.norm(np.array(position) - rest[name][0]))
    assert max(moved) > 0.02  # the hand was bent


def shown_links(path, angles):
    """Position [m] and quaternion of each link by name, as PyBullet reads the URDF."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        robot = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
        links = {}
        for joint in range(pybullet.getNumJoints(robot, physicsClientId=client)):
            info = pybullet.getJointInfo(robot, joint, physicsClientId=client)
            links[info[12].decode()] = joint
            if info[1].decode() in angles:
                angle = angles[info[1].decode()]
                pybullet.resetJointState(robot, joint, angle, physicsClientId=client)
        return {
            name: pybullet.getLinkState(
                robot, link, computeForwardKinematics=1, physicsClientId=client
            )[4:6]
            for name, link in links.items()
        }
    finally:
        pybullet.disconnect(client)


def test_the_command_writes_what_the_simulator_publishes(tmp_path, capsys):
    path = tmp_path / "hand.urdf"
    assert hand_command.main(["urdf", "rbo_hand_2", "-o", str(path)]) == 0
    assert path.read_text().strip() == write_urdf(layout_of("rbo_hand_2"))
    assert hand_command.main(["urdf", "rbo_hand_9"]) == 2
    assert "rbo_hand_2" in capsys.readouterr().err
