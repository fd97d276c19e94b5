"""Collision hulls of the links, and which chains of a hand meet which."""

import dataclasses
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.hand.collision import ENVIRONMENT_GROUP, collides_with, collision_groups
from pneuflex_sim.hand.layout import build_layout
from softhand_model.chain.hulls import COLLISION_MARGIN, collision_hulls
from softhand_model.chain.outline import ChainOutline, hull_section
from softhand_model.hand.hand import hand_names, load_hand
from softhand_model.model_file import Model

LENGTH, HEIGHT = 0.090, 0.020  # of a P10 finger [m]


def dilated(piece, normals):
    """Support heights (n,) [m] of a piece with the engine's margin around each point."""
    return (piece @ normals.T).max(axis=0) + COLLISION_MARGIN


@pytest.mark.parametrize("segments", [5, 10, 15])
def test_dilated_pieces_have_height_and_width_of_the_profiles_at_both_ends(segments):
    chain = load_hand("single_finger").chain("finger")
    edge = LENGTH / segments
    for k, piece in enumerate(collision_hulls(chain, segments)):
        start, stop = (k + 0.5) * edge, min((k + 1.5) * edge, LENGTH)
        taper = 1.0 - 0.925 * start / LENGTH
        height, width = 0.020 * taper ** (1 / 3), 0.020 * taper ** (1 / 8)
        back, side, front = dilated(piece, np.array([[-1.0, 0, 0], [0, 1, 0], [1, 0, 0]]))
        assert back == pytest.approx(height, abs=2.5e-4)  # the back is a polygon within a curve
        assert side == pytest.approx(width / 2, abs=1e-4)
        assert front == pytest.approx(0.0, abs=1e-12)
        assert piece[:, 2].max() == pytest.approx(
            stop - start - COLLISION_MARGIN * (k == segments - 1)
        )
        assert piece[:, 2].min() == pytest.approx(0.0, abs=1e-15)


def sphere(count=400):
    """Points (count, 3) on a unit sphere."""
    z = np.linspace(-1 + 1 / count, 1 - 1 / count, count)
    angle = np.pi * (1 + 5**0.5) * np.arange(count)
    return np.column_stack(
        [np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z]
    )


@pytest.mark.parametrize("segments", [5, 10])
def test_erosion_and_margin_reproduce_the_surface(segments):
    """Every face of the surface is met within 0.05 mm, edges lose at most the margin."""
    chain = load_hand("single_finger").chain("finger")
    outline = ChainOutline(chain, segments)
    for bone, piece in enumerate(collision_hulls(chain, segments), 1):
        ends = outline.range(bone)
        sharp = np.vstack(
            [
                np.column_stack([outline.outlines(place, hull_section())[0], np.full(10, lift)])
                for place, lift in zip(ends, (0.0, ends[1] - ends[0]), strict=True)
            ]
        )
        faces = np.unique(ConvexHull(sharp).equations.round(6), axis=0)
        sides = faces[np.abs(faces[:, 2]) < 0.9]
        lost = -sides[:, 3] - dilated(piece, sides[:, :3])
        assert np.abs(lost).max() < 5e-5
        round_about = sphere()
        gap = (sharp @ round_about.T).max(axis=0) - dilated(piece, round_about)
        ahead = round_about[:, 2] > 0 if bone < segments else np.zeros(len(gap), bool)
        assert gap[~ahead & (round_about[:, 2] > 0)].max(initial=0.0) < COLLISION_MARGIN
        assert (
            gap.min() > -1.05 * COLLISION_MARGIN
        )  # over a joint the piece reaches on by the margin


def test_volume_of_the_pieces_is_that_of_the_actuator_between_first_joint_and_tip():
    chain = load_hand("single_finger").chain("finger")
    x = np.linspace(0.1 * LENGTH, LENGTH, 2001)
    finger = chain.actuators["finger"]
    unit = ConvexHull(hull_section()).volume
    exact = unit * trapezoid(finger.height(x) * finger.width(x), x)
    ball = COLLISION_MARGIN * sphere(60)
    total = 0.0
    for piece in collision_hulls(chain, 5):
        whole = ConvexHull((piece[:, None] + ball).reshape(-1, 3))
        area = ConvexHull(piece[np.abs(piece[:, 2]) < 1e-12][:, :2]).volume
        total += (
            whole.volume - 2 * COLLISION_MARGIN * area
        )  # neighbours overlap by the margin on each side
    assert total == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("name", hand_names())
def test_every_link_of_every_hand_has_a_piece_of_few_vertices(name):
    for chain in load_hand(name).chains:
        for segments in (1, 3, 5, 15):
            pieces = collision_hulls(chain, segments)
            assert len(pieces) == segments + (chain.strut is not None)
            assert max(len(piece) for piece in pieces) <= 20


def test_pieces_of_the_palm_lie_between_the_arcs_inner_and_outer_edge():
    chain = load_hand("rbo_hand_2").chain("palm")
    piece = collision_hulls(chain, 5)[1]
    middle, angle = 0.050, np.pi / 10
    # centre of the arc in the link's frame: to the side that the arc turns to, half a chord ahead
    centre = np.array([chain.turn * middle * np.cos(angle / 2), middle * np.sin(angle / 2)])
    distance = np.linalg.norm(piece[:, 1:] - centre, axis=1)
    assert distance.max() == pytest.approx(0.075 - COLLISION_MARGIN, abs=1e-5)
    assert distance.min() == pytest.approx(0.025 + COLLISION_MARGIN, abs=1e-5)


def test_a_thin_tip_counts_as_6_mm_thick_behind_the_passive_layer():
    chain = load_hand("single_finger").chain("finger")
    thin = dataclasses.replace(
        chain.actuators["finger"], height=lambda x: 0.02 * (1.0 - np.asarray(x) / LENGTH)
    )
    chain = dataclasses.replace(chain, actuators={"finger": thin})
    tip = collision_hulls(chain, 5)[-1]
    assert dilated(tip, np.array([[1.0, 0, 0]])) == pytest.approx(0.0, abs=1e-12)
    at_tip = tip[tip[:, 2] > 0.005]
    assert np.ptp(at_tip[:, 0]) + 2 * COLLISION_MARGIN == pytest.approx(0.006, abs=4e-4)


@pytest.mark.parametrize(("side", "worst"), [(1.0, 2e-5), (-1.0, 2.5e-4)])
def test_a_cylinder_across_a_finger_touches_at_the_height_of_its_outline(simulate, side, worst):
    """A fixed cylinder is brought near to the passive layer or to the back of the third link."""
    simulation = simulate(hand="single_finger", scene="stand", step=0.002)
    client, radius, gap = simulation.engine.world.client, 0.015, 0.002
    place, edge = 0.054, LENGTH / 5  # above a joint: the thickest part of a tapered piece
    height = 0.0 if side > 0 else 0.020 * (1.0 - 0.925 * (place - edge / 2) / LENGTH) ** (1 / 3)
    base = np.array(simulation.scene.wrist_position)
    turn = Rotation.from_euler("x", np.pi / 2).as_quat()
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_CYLINDER, radius=radius, height=0.1, physicsClientId=client
    )
    at = base + [side * (height + gap + radius), 0.0, place - edge / 2]
    cylinder = pybullet.createMultiBody(
        0, shape, -1, at.tolist(), turn.tolist(), physicsClientId=client
    )
    points = pybullet.getClosestPoints(
        simulation.bodies.ids[0], cylinder, 0.01, physicsClientId=client
    )
    assert min(point[8] for point in points) == pytest.approx(gap, abs=worst)
    pressed = at - [side * (gap + 0.0005), 0.0, 0.0]
    pybullet.resetBasePositionAndOrientation(
        cylinder, pressed.tolist(), turn.tolist(), physicsClientId=client
    )
    pybullet.setCollisionFilterGroupMask(
        cylinder, -1, ENVIRONMENT_GROUP, -1, physicsClientId=client
    )
    simulation.step()
    touching = pybullet.getContactPoints(cylinder, physicsClientId=client)
    assert min(point[8] for point in touching) == pytest.approx(-0.0005, abs=worst + 1e-4)


GRIPPER = Path(__file__).parents[3] / "examples/three_finger_gripper/gripper.yaml"


def groups_of(hand):
    """Collision group by chain."""
    layout = build_layout(load_hand(hand), 3, Model())
    found = {}
    for body in layout.bodies:
        groups = collision_groups(layout, body)
        for chain in body.chains:
            joints = layout.chain_joints[chain]
            own = set(groups[joints.start - body.joints.start : joints.stop - body.joints.start])
            (found[chain],) = own
    return found


def meeting(hand):
    """Pairs of chains that meet, by the rule of Bullet: each is in the other's mask."""
    groups = groups_of(hand)
    return {
        frozenset((one, other))
        for one, other in combinations(groups, 2)
        if groups[one] & collides_with(groups[other]) and groups[other] & collides_with(groups[one])
    }


def test_in_rbo_hand_2_the_thumb_meets_every_finger_and_nothing_else_meets():
    fingers = ("index", "middle", "ring", "little")
    assert meeting("rbo_hand_2") == {frozenset(("thumb", finger)) for finger in fingers}


@pytest.mark.parametrize("hand", ["rbo_hand_1", "rbo_hand_1_split", "single_finger"])
def test_fingers_side_by_side_do_not_meet(hand):
    assert meeting(hand) == set()


def test_fingers_that_face_each_other_meet():
    fingers = ("front", "left", "right")
    assert meeting(GRIPPER) == {frozenset(pair) for pair in combinations(fingers, 2)}


def test_all_chains_meet_objects():
    assert all(collides_with(group) & 1 for group in groups_of("rbo_hand_2").values())
