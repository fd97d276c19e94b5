"""A single joint under a moment: balance by finite rotations, and its derivative by differences."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.equilibrium import joint_balance as module
from softhand_model.equilibrium.joint_springs import JointSprings, springs_of

STIFFNESS = np.array([[0.8, 1.1, 0.9], [2.0, 2.5, 1.5]])  # (joints, points) [N m/rad]
REST = np.array([[0.2, -0.3, 0.5], [0.1, 0.4, -0.2]])
MOMENT = np.array([[0.3, -0.5, 0.7], [0.4, 0.6, -0.8], [-0.2, 0.5, 0.6]])  # (3, points) [N m]
MOMENT = 1.5 * MOMENT  # rotations of up to two thirds of a turn


def progressive(bend, rest, points):
    """Factor on the stiffness in bending: each point its own, growing with the bend."""
    turned = bend - rest
    return 1.0 + (0.1 + 0.05 * points) * turned**2 + 0.02 * turned**3


KINDS = {
    "linear": {},
    "sideways": {"sideways": np.array([[1.6, 0.7], [2.2, 0.5]])},
    "coupled": {"coupling": np.array([0.2, -0.3, 0.1])},
    "factor": {"factor": progressive},
    "rubber": {"stretching": np.array([0.9, 0.6])},
    "rubber in one joint": {"stretching": np.array([0.9, 0.0])},
    "all": {
        "sideways": np.array([[1.6, 0.7], [2.2, 0.5]]),
        "coupling": np.array([0.2, -0.3, 0.1]),
        "factor": progressive,
        "stretching": np.array([0.9, 0.6]),
    },
}


def springs(kind):
    return JointSprings(STIFFNESS, REST, np.arange(3), **KINDS[kind])


def rotations(given, joint, moment):
    """Rotation vectors (3, points) [rad] of a joint under moments (3, points) [N m]."""
    arrays = given.arrays()
    found = [module.joint_rotation(arrays, joint, n, tuple(m)) for n, m in enumerate(moment.T)]
    return np.transpose(found)


def compliances(given, joint, moment):
    """Their derivatives (3, 3, points) by the moment."""
    arrays, turned = given.arrays(), rotations(given, joint, moment)
    found = [
        module.compliance(arrays, joint, n, tuple(turned[:, n]), tuple(moment[:, n]))
        for n in range(moment.shape[1])
    ]
    return np.moveaxis(found, 0, -1)


def elastic(kind, joint, point, rotation):
    """K*e [N m] of one point, written out."""
    more = KINDS[kind]
    x, y, z = rotation
    lateral, twist = more["sideways"][joint] if "sideways" in more else (1.0, 1.0)
    rest, bending = REST[joint, point], y
    gain = more["stretching"][joint] if "stretching" in more else 0.0
    if gain:
        here, there = 1 + gain * (rest + y), 1 + gain * rest
        bending = ((here - here**-3) - (there - there**-3)) / (2 * gain)
    if "factor" in more:
        bending *= 1.0 + (0.1 + 0.05 * point) * y**2 + 0.02 * y**3
    coupling = more["coupling"][point] if "coupling" in more else 0.0
    return STIFFNESS[joint, point] * np.array(
        [lateral * x + coupling * z, bending, twist * z + coupling * x]
    )


def spins(rotation, step=1e-6):
    """Small rotations (3, 3) in the rest frame by a change of each component of the vector."""
    ends = [
        [Rotation.from_rotvec(rotation + sign * step * axis) for sign in (1, -1)]
        for axis in np.eye(3)
    ]
    return np.array([(more * less.inv()).as_rotvec() / (2 * step) for more, less in ends])


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_the_elastic_moment_does_the_work_of_the_moment_in_every_small_rotation(kind, joint):
    found = rotations(springs(kind), joint, MOMENT)
    for point in range(3):
        rotation = found[:, point]
        work = spins(rotation) @ MOMENT[:, point]
        assert elastic(kind, joint, point, rotation) == pytest.approx(work, abs=1e-8)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_the_compliance_is_the_derivative_of_the_rotation_by_the_moment(kind, joint):
    """To the first order in the rotation, in which the search needs it."""
    given, moment, step = springs(kind), 0.02 * MOMENT, 1e-6
    compliance = compliances(given, joint, moment)
    assert compliance.shape == (3, 3, 3)
    for k, axis in enumerate(np.eye(3)):
        push = step * axis[:, None]
        more, less = (rotations(given, joint, moment + sign * push) for sign in (1, -1))
        assert compliance[:, k] == pytest.approx((more - less) / (2 * step), rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("kind", ["factor", "rubber", "sideways"])
def test_in_the_bending_plane_the_compliance_is_exact_however_far_it_bends(kind):
    given, moment, step = springs(kind), np.array([[0.0] * 3, [0.9, -0.4, 1.3], [0.0] * 3]), 1e-5
    found = compliances(given, 0, moment)
    push = step * np.array([[0.0], [1.0], [0.0]])
    more, less = (rotations(given, 0, moment + sign * push) for sign in (1, -1))
    assert found[1, 1] == pytest.approx(((more - less) / (2 * step))[1], rel=1e-5)


def test_a_spring_alike_about_all_axes_turns_about_the_moment():
    given = springs("linear")
    assert given.isotropic
    assert rotations(given, 1, MOMENT) == pytest.approx(MOMENT / STIFFNESS[1])
    assert not any(springs(kind).isotropic for kind in KINDS if kind != "linear")


def test_points_can_be_taken_out():
    every, some = springs("all"), springs("all").take(np.array([2, 0]))
    found = rotations(some, 0, MOMENT[:, [2, 0]])
    assert found == pytest.approx(rotations(every, 0, MOMENT)[:, [2, 0]], abs=1e-12)
    assert springs("linear").take(np.array([1])).coupling is None


def test_a_factor_may_jump_at_rest_and_stays_far_from_it():
    given = JointSprings(STIFFNESS, REST, np.arange(3), factor=jumping)
    arrays = given.arrays()
    for bend, factor in ((-3.0, 0.5), (-0.4, 0.5), (-1e-7, 0.5), (0.0, 1.0), (0.73, 1.73**4)):
        moment, _ = module.bending(arrays, 1, 2, bend)
        assert moment == pytest.approx(bend * factor, rel=1e-6)
    moment, tangent = module.bending(arrays, 0, 1, 2.5)
    assert (moment, tangent) == pytest.approx((2.5 * 3.0**4, 3.0**4))


def jumping(bend, rest, points):
    return np.where(bend < rest, 0.5, (1.0 + bend - rest) ** 4)


def chain(stiffness, stretching):
    return SimpleNamespace(stiffness=np.array(stiffness), stretching=np.array(stretching))


def test_springs_of_a_chain_are_its_stiffness_times_the_modulus():
    given = springs_of(
        chain([[3.0, 2.0, 1.0], [4.0, 4.0, 6.0]], [0.5, 0.0]), REST, np.array([1.0, 1.5, 2.0])
    )
    assert given.stiffness == pytest.approx(np.array([[2.0, 3.0, 4.0], [4.0, 6.0, 8.0]]))
    assert given.sideways == pytest.approx(np.array([[1.5, 0.5], [1.0, 1.5]]))
    assert given.stretching == pytest.approx([0.5, 0.0])
    assert given.points.tolist() == [0, 1, 2]


def test_springs_of_a_chain_that_are_alike_and_linear_are_isotropic():
    given = springs_of(chain([[2.0, 2.0, 2.0], [3.0, 3.0, 3.0]], [0.0, 0.0]), REST)
    assert given.isotropic
    assert given.stiffness == pytest.approx(np.array([[2.0] * 3, [3.0] * 3]))


def test_the_derivative_of_the_balance_is_exact_to_the_first_order():
    """What the search and the compliance are drawn from, against differences near no rotation."""
    step = 1e-5
    for turn, moment in zip(1e-3 * MOMENT.T[::-1], MOMENT.T, strict=True):
        slope = np.array(module.pulled_slope(tuple(turn), tuple(moment)))
        for k, axis in enumerate(np.eye(3)):
            ends = (turn + sign * step * axis for sign in (1, -1))
            more, less = (np.array(module.pulled(tuple(end), tuple(moment))) for end in ends)
            assert slope[:, k] == pytest.approx((more - less) / (2 * step), abs=5e-6)
