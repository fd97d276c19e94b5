"""Shape of a hand from its joints against PyBullet, and its angle sensors."""

from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.kinematics import TipSensors
from pneuflex_sim.pictures.skin import HandSkin
from pneuflex_sim.urdf import joint_names, joint_orientations, joint_positions, write_urdf
from softhand_model.model_file import Model, load_model


@pytest.fixture
def bent_hand(simulate, mass_for_pressure):
    simulation = simulate(step=0.005)
    masses = mass_for_pressure(simulation, [25e3, 15e3, 30e3, 20e3])
    for k in range(300):
        simulation.set_air_masses(masses * min(1, k / 100))
        simulation.step()
    return simulation


def world_of(simulation, point):
    place, turn = simulation.wrist_pose()
    return place + Rotation.from_quat(turn).apply(point)


def test_fingertips_agree_with_pybullets_own_kinematics(bent_hand):
    layout = bent_hand.bodies.layout
    tips = bent_hand.fingertips()
    assert list(tips) == ["thumb", "index", "middle", "ring", "little"]
    for body, base in zip(layout.bodies, bent_hand.bodies.ids, strict=True):
        for name in set(body.chains) & set(tips):
            link = layout.chain_joints[name].stop - 1 - body.joints.start
            state = pybullet.getLinkState(
                base,
                link,
                computeForwardKinematics=1,
                physicsClientId=bent_hand.engine.world.client,
            )
            turn = Rotation.from_quat(state[5])
            tip = np.array(state[4]) + turn.apply(layout.chain_tips[name])
            np.testing.assert_allclose(world_of(bent_hand, tips[name][0]), tip, atol=2e-6)


def test_robot_model_has_every_link_once_and_leads_to_the_same_tip(bent_hand):
    layout, q = bent_hand.bodies.layout, bent_hand.bodies.q
    robot = ElementTree.fromstring(write_urdf(layout))
    links = [link.get("name") for link in robot.iter("link")]
    joints = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    assert len(links) == len(set(links)) == len(joints) + 1
    angles = dict(zip(joint_names(layout), joint_positions(q), strict=True))
    frame, link = np.eye(4), layout.names[layout.chain_joints["thumb"].stop - 1]
    while link != "wrist":
        joint = joints[link]
        frame = joint_transform(joint, angles) @ frame
        link = joint.find("parent").get("link")
    tip = frame @ np.append(layout.chain_tips["thumb"], 1)
    np.testing.assert_allclose(tip[:3], bent_hand.fingertips()["thumb"][0], atol=1e-6)


def joint_transform(joint, angles):
    """Homogeneous transform of one URDF joint at its angle."""
    frame, origin = np.eye(4), joint.find("origin")
    frame[:3, 3] = [float(number) for number in origin.get("xyz").split()]
    rpy = [float(number) for number in origin.get("rpy").split()]
    turn = Rotation.from_euler("xyz", rpy)
    if joint.get("type") == "revolute":
        axis = np.array([float(number) for number in joint.find("axis").get("xyz").split()])
        turn = turn * Rotation.from_rotvec(axis * angles[joint.get("name")])
    frame[:3, :3] = turn.as_matrix()
    return frame


def test_joint_angles_and_orientations_are_inverse(bent_hand):
    q = bent_hand.bodies.q
    back = joint_orientations(joint_positions(q))
    np.testing.assert_allclose(np.abs(np.sum(q * back, axis=1)), 1, atol=1e-12)


def test_the_skin_ends_at_the_tip_and_encloses_the_rubber(bent_hand):
    q, skin = bent_hand.bodies.q, HandSkin(bent_hand.shape)
    for name, (tip, _) in bent_hand.fingertips().items():
        mesh = skin.actuator(name, q)
        assert np.linalg.norm(mesh.vertices[-1] - tip) < 0.012
        assert 5e-6 < mesh.volume < 40e-6  # outward faces, and the size of a finger [m3]
        assert (f"{name}_strut" in skin.parts(q)) == (name != "thumb")


LAGGING = """
format: softhand-model/1
base: pneuflex
effects:
  - {name: angle_offset, parameters: {offset: 0.1}}
  - {name: angle_sensor_lag, parameters: {time_constant: 0.2}}
"""


@pytest.fixture
def lagging(tmp_path):
    path = tmp_path / "lagging.yaml"
    path.write_text(LAGGING, encoding="utf-8")
    return path


def test_sensor_follows_a_ramp_late_and_reads_its_offset(lagging):
    """rate*(t - tau*(1 - exp(-t/tau))) + offset."""
    sensors = TipSensors(load_model(lagging))
    assert sensors.readings({"finger": 0.0}) == {"finger": pytest.approx(0.1)}
    for step in range(1, 501):
        sensors.step(1e-3, {"finger": 2.0 * step * 1e-3})
    exact = 2.0 * (0.5 - 0.2 * (1 - np.exp(-0.5 / 0.2))) + 0.1
    assert sensors.readings({"finger": 1.0}) == {"finger": pytest.approx(exact)}
    sensors.reset()
    assert sensors.readings({"finger": 0.0}) == {"finger": pytest.approx(0.1)}


def test_without_effects_the_readings_are_the_true_angles():
    sensors = TipSensors(Model())
    assert not sensors.active
    assert sensors.readings({"finger": 0.7}) == {"finger": 0.7}


def test_simulated_finger_is_read_through_its_sensor(simulate, hold_pressure, lagging):
    simulation = simulate(hand="single_finger", scene="stand", step=0.002, model=lagging)
    true = []
    original = simulation.tip_sensors.step

    def noted(dt, angles):
        true.append(angles["finger"])
        original(dt, angles)

    simulation.tip_sensors.step = noted
    hold_pressure(simulation, [10e3], 0.6)
    saved = simulation.save()
    follows = 0.0
    for before, angle in zip([0.0, *true], true, strict=False):
        left = np.exp(-0.01)
        rate = (angle - before) / 0.01
        follows = angle - rate * (1 - left) + left * (follows - before)
    assert simulation.read_tip_angles()["finger"] == pytest.approx(follows + 0.1, rel=1e-9)
    assert simulation.tip_angles()["finger"] == true[-1]
    before = simulation.read_tip_angles()
    hold_pressure(simulation, [20e3], 0.1)
    assert simulation.read_tip_angles() != before
    simulation.restore(saved)
    assert simulation.read_tip_angles() == before
