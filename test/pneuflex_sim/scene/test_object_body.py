"""Objects in PyBullet, without a hand: at rest, on a slope, turning by their inertia, yielding."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.mesh import box, write_meshes
from pneuflex_sim.scene.object_body import ObjectBody
from pneuflex_sim.scene.objects import ObjectDescription, load_object, load_objects
from pneuflex_sim.scene.scenes import USUAL_ROLLING, Table, build_scene, load_scene
from pneuflex_sim.world import World

G = 9.80665
STEPS = (0.001, 0.002, 0.005)
OBJECTS = tuple(load_objects())
WOODEN = ObjectDescription("block", "box", {"size": (0.06, 0.06, 0.02)}, 0.2, "cardboard")


class Rig:
    """A scene and an object in a world of their own."""

    def __init__(self, described, scene, step, gravity=G):
        if isinstance(described, str):
            described = load_object(described)
        friction = load_friction()
        self.world, self.step = World(step), step
        self.client = self.world.client
        pybullet.setGravity(0, 0, -gravity, physicsClientId=self.client)
        self.fixed = {}
        if scene is not None:
            self.fixed = build_scene(scene, friction, described.material, self.client)
        self.body = ObjectBody(described, friction.towards_hand(described.material), self.world)

    def lay(self, x=0.0, y=0.0, height=None, rpy=None):
        """Put the object in its place, or elsewhere."""
        described = self.body.description
        height = described.rest_height if height is None else height
        self.body.put(np.array([x, y, height]), described.rpy if rpy is None else rpy)
        return self

    def run(self, duration):
        """Way (3,) [m] of the object and angle [rad] that it turned."""
        (before, turn_before) = self.body.pose()
        for _ in range(round(duration / self.step)):
            pybullet.stepSimulation(physicsClientId=self.client)
        after, turn = self.body.pose()
        turned = Rotation.from_quat(turn_before).inv() * Rotation.from_quat(turn)
        return after - before, turned.magnitude()

    def velocity(self):
        """Velocity (3,) [m/s] and angular velocity (3,) [rad/s]."""
        found = pybullet.getBaseVelocity(self.body.id, physicsClientId=self.client)
        return np.array(found[0]), np.array(found[1])


@pytest.fixture
def rig():
    """Make rigs; all are closed at the end of the test."""
    made = []

    def make(described, scene=None, step=0.002, **more):
        made.append(Rig(described, scene, step, **more))
        return made[-1]

    yield make
    for one in made:
        one.world.close()


# -------------------------------------------------------------------- at rest
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("scene", ["table", "edge"])
@pytest.mark.parametrize("name", OBJECTS)
def test_every_object_lies_still_in_its_place(rig, name, scene, step):
    way, turned = rig(name, load_scene(scene), step).lay().run(0.6)
    soft = load_object(name).compliance
    sinks = load_object(name).mass * G / soft.stiffness if soft else 0.0
    assert np.abs(way[:2]).max() < 1e-4 and way[2] == pytest.approx(-sinks, abs=3e-5)
    assert turned < 0.005


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("inclination", [40, 60, 90, 120])
@pytest.mark.parametrize("name", ["cylinder", "marker"])
def test_a_cylinder_lies_still_in_the_corner_of_a_wall(rig, name, inclination, step):
    scene = load_scene("wall").inclined(inclination)
    reach = load_object(name).rest_height * math.tan(math.radians(inclination) / 2)
    one = rig(name, scene, step).lay(scene.wall.distance - reach)
    way, turned = one.run(0.5)
    assert np.abs(way).max() < 1e-4 and turned < 0.005
    # the wall stands where it is said to: pushed into the corner, the cylinder stays
    push = 0.3 * one.body.mass * G
    for _ in range(round(0.2 / step)):
        place = one.body.pose()[0].tolist()
        pybullet.applyExternalForce(
            one.body.id, -1, [push, 0, 0], place, pybullet.WORLD_FRAME, physicsClientId=one.client
        )
        pybullet.stepSimulation(physicsClientId=one.client)
    assert abs(one.body.pose()[0][0] - scene.wall.distance + reach) < 5e-4
    points = pybullet.getContactPoints(bodyA=one.body.id, physicsClientId=one.client)
    assert "wall" in {one.fixed[point[2]] for point in points if point[9] > 0}


@pytest.mark.parametrize("step", STEPS)
def test_a_block_stays_on_the_edge_as_long_as_its_centre_does(rig, step):
    scene = load_scene("edge")
    way, turned = rig(WOODEN, scene, step).lay(scene.table.edge + 0.004).run(1.0)
    assert np.abs(way).max() < 1e-4 and turned < 0.005
    way, _ = rig(WOODEN, scene, step).lay(scene.table.edge - 0.004).run(1.0)
    assert way[2] < -0.1


# -------------------------------------------------------------------- friction
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("material", ["cardboard", "latex", "polyolefin"])
def test_a_block_slides_on_a_slope_from_the_angle_of_friction_of_the_pair_on(rig, material, step):
    block = replace(WOODEN, material=material)
    angle = math.degrees(math.atan(load_friction().pair(material, "wood")))
    for inclination in (angle - 1.0, angle + 3.0):
        scene = replace(load_scene("wall").inclined(inclination), table=None)
        slope = math.radians(inclination)
        upwards = np.array([math.cos(slope), 0, math.sin(slope)])
        place = np.array([scene.wall.distance, 0, 0]) + 0.3 * upwards
        place += 0.01 * np.array(scene.wall.normal)
        one = rig(block, scene, step).lay(place[0], 0.0, place[2], (0.0, -slope, 0.0))
        one.run(0.3)
        begin = one.velocity()[0] @ upwards
        one.run(1.0)  # while it slides it rattles on one contact: the mean counts
        end = one.velocity()[0] @ upwards
        if inclination < angle:
            assert abs(end) < 1e-3
        else:
            felt = math.tan(slope) - (begin - end) / 1.0 / (G * math.cos(slope))
            assert felt == pytest.approx(math.tan(math.radians(angle)), rel=0.03)


def test_a_table_that_one_coefficient_cannot_describe_stands_there_twice(rig):
    smooth = replace(load_scene("table"), table=Table("wood", rolling_resistance=0.0))
    assert len(rig("cylinder", smooth).fixed) == 1  # 0.6*0.6 is its pair with wood
    one = rig("water_balloon", load_scene("table"))
    assert set(one.fixed.values()) == {"table"} and len(one.fixed) == 2
    one.lay().run(0.2)
    points = pybullet.getContactPoints(bodyA=one.body.id, physicsClientId=one.client)
    assert len({point[2] for point in points}) == 1


# -------------------------------------------------------------------- mass and inertia
@pytest.mark.parametrize("name", [name for name in OBJECTS if name != "tissue"])
def test_a_torque_turns_an_object_by_its_inertia(rig, name):
    one = rig(name, gravity=0.0, step=0.0001)
    one.body.set_mass(0.25)
    one.lay(height=1.0, rpy=(0.3, -0.5, 0.8))
    turn = Rotation.from_quat(one.body.pose()[1]).as_matrix()
    inertia = turn @ (0.25 * one.body.description.geometry.solid.inertia) @ turn.T
    torque = np.array([1e-5, -2e-5, 3e-5])
    pybullet.applyExternalTorque(
        one.body.id, -1, torque.tolist(), pybullet.WORLD_FRAME, physicsClientId=one.client
    )
    one.run(one.step)
    gained = one.velocity()[1] / one.step
    np.testing.assert_allclose(gained, np.linalg.solve(inertia, torque), rtol=2e-3)


@pytest.fixture
def skewed(tmp_path):
    """A box of 20 x 50 x 110 mm as a mesh whose axes are not the box's, and its turn."""
    turn = Rotation.from_euler("xyz", (0.4, -0.7, 1.1))
    mesh = box((0.02, 0.05, 0.11), np.zeros(3)).moved(np.array([0.1, 0.0, 0.3]), turn.as_matrix())
    path = tmp_path / "skewed.stl"
    write_meshes(path, {"box": mesh})
    return ObjectDescription("skewed", "mesh", {"file": str(path)}, 0.3, "paper"), turn


def test_a_mesh_off_its_principal_axes_turns_by_its_inertia_and_keeps_its_own_axes(rig, skewed):
    described, turn = skewed
    one = rig(described, gravity=0.0, step=0.0001).lay(height=1.0, rpy=(0.2, 0.1, -0.4))
    laid = Rotation.from_euler("xyz", (0.2, 0.1, -0.4))
    angle = (Rotation.from_quat(one.body.pose()[1]).inv() * laid).magnitude()
    assert angle < 1e-6
    axes = (laid * turn).as_matrix()
    squares = np.array([0.02, 0.05, 0.11]) ** 2
    inertia = axes @ np.diag(0.3 * (squares.sum() - squares) / 12) @ axes.T
    torque = np.array([1e-5, -2e-5, 3e-5])
    pybullet.applyExternalTorque(
        one.body.id, -1, torque.tolist(), pybullet.WORLD_FRAME, physicsClientId=one.client
    )
    one.run(one.step)
    gained = one.velocity()[1] / one.step
    np.testing.assert_allclose(gained, np.linalg.solve(inertia, torque), rtol=1e-3)


def test_a_mesh_rests_where_its_corners_touch(rig, skewed):
    described, turn = skewed
    flat = replace(described, rpy=tuple(turn.inv().as_euler("xyz")))
    assert flat.rest_height == pytest.approx(0.055, abs=1e-6)
    upright = rig(flat, load_scene("table")).lay()
    way, turned = upright.run(0.5)
    assert np.abs(way).max() < 5e-5 and turned < 0.005


def test_masses_of_the_strips_of_a_tissue_add_up(rig):
    one = rig("tissue")
    one.body.set_mass(0.002)
    links = [
        pybullet.getDynamicsInfo(one.body.id, k, physicsClientId=one.client)[0]
        for k in one.body.links
    ]
    assert len(links) == 5 and sum(links) == pytest.approx(0.002)


def test_a_weight_of_its_own_pulls_like_gravity(rig):
    for name in ("cylinder", "tissue"):
        one = rig(name, gravity=0.0).lay(height=1.0)
        for _ in range(100):
            one.body.pull_down(G)
            pybullet.stepSimulation(physicsClientId=one.client)
        assert one.velocity()[0][2] == pytest.approx(-0.2 * G, rel=1e-3)


# -------------------------------------------------------------------- compliance
@pytest.mark.parametrize("step", STEPS)
def test_the_balloon_yields_by_its_stiffness(rig, step):
    one = rig("water_balloon", load_scene("table"), step).lay()
    one.run(1.0)
    before = one.body.pose()[0]
    for _ in range(round(1.0 / step)):
        place = one.body.pose()[0].tolist()
        pybullet.applyExternalForce(
            one.body.id, -1, [0, 0, -5.0], place, pybullet.WORLD_FRAME, physicsClientId=one.client
        )
        pybullet.stepSimulation(physicsClientId=one.client)
    points = pybullet.getContactPoints(bodyA=one.body.id, physicsClientId=one.client)
    assert len(points) == 1
    assert (before - one.body.pose()[0])[2] == pytest.approx(5.0 / 1000.0, rel=0.02)


@pytest.mark.parametrize("step", STEPS)
def test_the_tissue_hangs_limply_over_an_edge(rig, step):
    """More than the half of it lies on the table: a stiff plate would lie level."""
    scene = load_scene("edge")
    one = rig("tissue", scene, step).lay(scene.table.edge + 0.03)
    one.run(1.0)
    tip = pybullet.getLinkState(one.body.id, 3, physicsClientId=one.client)[0]
    assert tip[2] < -0.01
    assert one.body.pose()[0][0] > scene.table.edge


def test_a_tissue_that_was_folded_lies_as_at_first_when_it_is_put_again(rig):
    one = rig("tissue", load_scene("table")).lay()
    first = [pybullet.getJointState(one.body.id, k, physicsClientId=one.client) for k in range(4)]
    one.lay(height=0.2, rpy=(0.5, 0.4, 0.0)).run(1.0)
    one.lay()
    again = [pybullet.getJointState(one.body.id, k, physicsClientId=one.client) for k in range(4)]
    assert [state[:2] for state in first] == [state[:2] for state in again]


# -------------------------------------------------------------------- rolling
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("resistance", [0.0, USUAL_ROLLING])
@pytest.mark.parametrize("name, speed", [("marker", 1.5), ("tube", 1.0), ("cylinder", 1.0)])
def test_a_cylinder_rolls_on_and_only_its_rolling_resistance_brakes_it(
    rig, name, speed, resistance, step
):
    """A solid cylinder of radius r that rolls under a moment b m g slows down by 2/3 g b/r."""
    table = Table("wood", rolling_resistance=resistance)
    one = rig(name, replace(load_scene("table"), table=table), step).lay()
    radius = one.body.description.half_extents[0]
    pybullet.resetBaseVelocity(
        one.body.id, [speed, 0, 0], [0, speed / radius, 0], physicsClientId=one.client
    )
    way, _ = one.run(0.5)
    braking = 2.0 / 3.0 * G * resistance / radius
    assert abs(way[2]) < 3e-4
    assert way[0] == pytest.approx(0.5 * speed - 0.125 * braking, abs=0.01 * speed)
    velocity, spin = one.velocity()
    now = speed - 0.5 * braking
    np.testing.assert_allclose(velocity, [now, 0, 0], atol=0.03 * speed)
    np.testing.assert_allclose(spin, [0, now / radius, 0], atol=0.03 * speed / radius)


@pytest.mark.parametrize("degrees, rolls", [(1.1, False), (3.0, True)])
def test_a_marker_starts_to_roll_on_a_slope_of_its_resistance_over_its_radius(
    simulate, degrees, rolls
):
    """tan(1.35 deg) = 0.2 mm/8.5 mm; gravity is tilted instead of the table."""
    simulation = simulate(hand="single_finger", object="marker", step=0.002)
    tilt = np.radians(degrees)
    gravity = G * np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    for _ in range(100):
        simulation.step()
    start = simulation.object_pose()[0]
    pybullet.setGravity(*gravity, physicsClientId=simulation.engine.world.client)
    for _ in range(500):
        simulation.step()
    moved = abs(simulation.object_pose()[0][0] - start[0])
    expected = 0.5 * 2.0 / 3.0 * (gravity[0] + gravity[2] * USUAL_ROLLING / 0.0085)
    assert moved == pytest.approx(expected if rolls else 0.0, abs=2e-3)


@pytest.mark.parametrize("step", STEPS)
def test_a_marker_that_is_flung_and_spins_stays_on_the_table(rig, step):
    one = rig("marker", load_scene("table"), step).lay()
    pybullet.resetBaseVelocity(
        one.body.id, [-1.3, -0.05, 0], [0.6, -31.0, 8.0], physicsClientId=one.client
    )
    for _ in range(10):
        one.run(0.05)
        assert one.body.pose()[0][2] > one.body.description.rest_height - 1e-3
