"""A single joint under a moment: balance by finite rotations, and its derivative by differences."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softhand_model.equilibrium import joint_springs as module
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
    found = springs(kind).rotation(joint, MOMENT)
    for point in range(3):
        rotation = found[:, point]
        work = spins(rotation) @ MOMENT[:, point]
        assert elastic(kind, joint, point, rotation) == pytest.approx(work, abs=1e-8)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_the_compliance_is_the_derivative_of_the_rotation_by_the_moment(kind, joint):
    """To the first order in the rotation, in which the search needs it."""
    given, moment, step = springs(kind), 0.02 * MOMENT, 1e-6
    compliance = given.compliance(joint, given.rotation(joint, moment), moment)
    assert compliance.shape == (3, 3, 3)
    for k, axis in enumerate(np.eye(3)):
        push = step * axis[:, None]
        more, less = (given.rotation(joint, moment + sign * push) for sign in (1, -1))
        assert compliance[:, k] == pytest.approx((more - less) / (2 * step), rel=1e-3, abs=1e-4)


@pytest.mark.parametrize("kind", ["factor", "rubber", "sideways"])
def test_in_the_bending_plane_the_compliance_is_exact_however_far_it_bends(kind):
    given, moment, step = springs(kind), np.array([[0.0] * 3, [0.9, -0.4, 1.3], [0.0] * 3]), 1e-5
    found = given.compliance(0, given.rotation(0, moment), moment)
    push = step * np.array([[0.0], [1.0], [0.0]])
    more, less = (given.rotation(0, moment + sign * push) for sign in (1, -1))
    assert found[1, 1] == pytest.approx(((more - less) / (2 * step))[1], rel=1e-5)


@pytest.mark.parametrize("kind", ["sideways", "all"])
def test_few_evaluations_lead_to_the_last_digit(kind, monkeypatch):
    calls = []
    plain = JointSprings._elastic
    monkeypatch.setattr(
        JointSprings, "_elastic", lambda *given: calls.append(given) or plain(*given)
    )
    springs(kind).rotation(0, 0.2 * MOMENT)
    assert len(calls) <= 12


def test_a_spring_alike_about_all_axes_turns_about_the_moment():
    given = springs("linear")
    assert given.isotropic
    assert given.rotation(1, MOMENT) == pytest.approx(MOMENT / STIFFNESS[1])
    assert not any(springs(kind).isotropic for kind in KINDS if kind != "linear")


@pytest.mark.parametrize(
    ("sideways", "shares"),
    [
        (None, (1.0, 1.0)),
        ([[1.6, 0.7], [2.2, 1.5]], (0.7, 1.0)),
        ([[0.4, 3.0], [0.9, 0.8]], (0.4, 0.8)),
    ],
)
def test_the_softest_axis_may_be_any_of_the_three(sideways, shares):
    given = JointSprings(
        STIFFNESS, REST, np.arange(3), sideways=None if sideways is None else np.array(sideways)
    )
    assert given.softest == pytest.approx(STIFFNESS * np.array(shares)[:, None])


def test_points_can_be_taken_out():
    every, some = springs("all"), springs("all").take(np.array([2, 0]))
    found = some.rotation(0, MOMENT[:, [2, 0]])
    assert found == pytest.approx(every.rotation(0, MOMENT)[:, [2, 0]], abs=1e-12)
    assert springs("linear").take(np.array([1])).coupling is None


def test_the_rest_angle_comes_as_sine_and_cosine():
    sine, cosine = springs("linear").rest_sine_cosine(1)
    assert sine == pytest.approx(np.sin(REST[1])) and cosine == pytest.approx(np.cos(REST[1]))


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
    moment, step = MOMENT, 1e-5
    slope = module._slope_of_transposed_jacobian(1e-3 * MOMENT[:, ::-1], moment)
    for k, axis in enumerate(np.eye(3)):
        ends = (1e-3 * MOMENT[:, ::-1] + sign * step * axis[:, None] for sign in (1, -1))
        more, less = (module._transposed_jacobian(end, moment) for end in ends)
        assert slope[:, k] == pytest.approx((more - less) / (2 * step), abs=5e-6)
