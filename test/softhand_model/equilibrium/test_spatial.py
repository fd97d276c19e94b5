"""A chain held at both ends against energies written independently, beams and the planar finger."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from softhand_model.chain.chain import discretise
from softhand_model.equilibrium.joint_springs import JointSprings
from softhand_model.equilibrium.spatial import HeldChain, Hold
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model
from thesis.chapter_3_and_5.planar import Stop, equilibrium, linear_springs, planar_finger

FINGER = load_hand("single_finger").chain("finger")


def chain_of(joints):
    return discretise(FINGER, joints, Model()).segments


def springs_of(chain, rest, points=1, **more):
    rest = np.asarray(rest, float).reshape(len(chain.mass), -1)
    rest = np.repeat(rest, points // rest.shape[1], axis=1)
    stiffness = np.repeat(chain.stiffness[:, 1:2], points, axis=1)
    return JointSprings(stiffness, rest, np.arange(points), **more)


def hold_of(springs, positions, rotations, gravity=None):
    positions = np.atleast_2d(positions)
    matrices = np.stack([rotation.as_matrix() for rotation in rotations])
    pulls = (
        None if gravity is None else np.repeat(np.reshape(gravity, (3, 1)), len(positions), axis=1)
    )
    return Hold(springs, positions.T.copy(), np.moveaxis(matrices, 0, -1).copy(), pulls)


def slack(bend, rest, points):
    return np.where(bend < rest, 0.5, 1.0)


class Oracle:
    """Poses and energy of the chain, joint by joint with scipy's rotations."""

    def __init__(
        self,
        chain,
        rest,
        coupling=0.0,
        below=1.0,
        gravity=(0.0, 0.0, 0.0),
        sideways=(1.0, 1.0),
        rubber=0.0,
    ):
        self.chain, self.rest, self.coupling, self.below = chain, rest, coupling, below
        self.gravity, self.sideways, self.rubber = np.array(gravity), sideways, rubber

    def tip(self, rotations):
        return self._walk(rotations)[:2]

    def _walk(self, rotations):
        place, turn, centers = np.zeros(3), Rotation.identity(), []
        for i, rotation in enumerate(rotations.reshape(-1, 3)):
            place = place + turn.apply(self.chain.offset[i])
            turn = (
                turn * Rotation.from_rotvec([0, self.rest[i], 0]) * Rotation.from_rotvec(rotation)
            )
            centers.append(place + turn.apply(self.chain.body_center[i]))
        return place + turn.apply(self.chain.tip_offset), turn, np.array(centers)

    def energy(self, rotations):
        total = 0.0
        lateral, twist = self.sideways
        for k, rest, (x, y, z) in zip(
            self.chain.stiffness[:, 1], self.rest, rotations.reshape(-1, 3), strict=True
        ):
            bending = y * y * (self.below if y < 0 else 1.0)
            if self.rubber:
                bending = self.of_rubber(rest, y)
            total += 0.5 * k * (lateral * x * x + bending + twist * z * z)
            total += k * self.coupling * x * z
        centers = self._walk(rotations)[2]
        return total - np.sum(self.chain.mass[:, None] * centers * self.gravity)

    def of_rubber(self, rest, turn):
        """Twice the integral of (q(u) - q(u_rest))/(2*s) over the bend, in closed form."""
        first, last = 1 + self.rubber * rest, 1 + self.rubber * (rest + turn)
        area = (last**2 + last**-2 - first**2 - first**-2) / 2
        return (area / self.rubber - (first - first**-3) * turn) / self.rubber

    def weight_moment(self, rotations):
        centers = self._walk(rotations)[2]
        return np.sum(np.cross(centers, self.chain.mass[:, None] * self.gravity), axis=0)

    def base_torque(self, place, turn, start):
        """Least energy under the pose, by a general optimiser; its multipliers are the wrench."""

        def gap(rotations):
            found = self.tip(rotations)
            return np.concatenate([(found[0] - place) * 10.0, (found[1] * turn.inv()).as_rotvec()])

        found = minimize(
            lambda rotations: 100.0 * self.energy(rotations),
            start,
            constraints={"type": "eq", "fun": gap},
            method="SLSQP",
            options={"ftol": 1e-15, "maxiter": 500},
        ).x
        push = self._multipliers(found, place, turn)
        weight = self.weight_moment(found)
        return push[3:] + np.cross(place, push[:3]) + weight

    def _multipliers(self, rotations, place, turn, step=1e-5):
        gradient, jacobian = [], []
        for shift in step * np.eye(len(rotations)):
            more, less = rotations + shift, rotations - shift
            gradient.append((self.energy(more) - self.energy(less)) / (2 * step))
            (a, ra), (b, rb) = self.tip(more), self.tip(less)
            jacobian.append(np.concatenate([a - b, (ra * rb.inv()).as_rotvec()]) / (2 * step))
        return np.linalg.lstsq(np.array(jacobian), np.array(gradient), rcond=None)[0]


CASES = {
    "plain": {},
    "coupled": {"coupling": 0.4},
    "slack": {"below": 0.5},
    "heavy": {"gravity": (0.0, -9.81, 0.0)},
    "softer sideways": {"sideways": (0.4, 0.25)},
    "rubber": {"rubber": 1.2},
    "rubber, softer sideways": {"rubber": 1.2, "sideways": (0.4, 0.25), "coupling": 0.1},
    "all": {"coupling": -0.3, "below": 0.5, "gravity": (3.0, 4.0, -8.0)},
}


@pytest.mark.parametrize("case", CASES)
def test_torque_is_that_of_the_least_energy_under_the_pose(case):
    joints, random = 5, np.random.default_rng(7)
    chain, rest = chain_of(joints), np.array([0.5, 0.45, 0.4, 0.35, 0.3])
    options = CASES[case]
    oracle = Oracle(chain, rest, **options)
    for _ in range(2):
        extra = 0.12 * random.normal(size=3) + 0.03 * random.normal(size=(joints, 3))
        place, turn = oracle.tip(extra.ravel())
        expected = oracle.base_torque(place, turn, extra.ravel())
        more = {"coupling": np.full(1, options.get("coupling", 0.0))}
        if "below" in options:
            more["factor"] = slack
        if "sideways" in options:
            more["sideways"] = np.tile(options["sideways"], (joints, 1))
        if "rubber" in options:
            more["stretching"] = np.full(joints, options["rubber"])
        springs = springs_of(chain, rest, **more)
        found = HeldChain(chain).base_load(hold_of(springs, place, [turn], options.get("gravity")))
        assert found.settled.all()
        assert found.torque[:, 0] == pytest.approx(expected, rel=2e-3, abs=3e-5)


def test_no_torque_where_the_chain_would_be_anyway():
    chain, rest = chain_of(10), np.full(10, 0.2)
    place, turn = Oracle(chain, rest).tip(np.zeros(30))
    found = HeldChain(chain).base_load(hold_of(springs_of(chain, rest), place, [turn]))
    assert np.abs(found.torque).max() < 1e-12
    assert np.abs(found.force).max() < 1e-10


def uniform(joints):
    chain = chain_of(joints)
    stiffness = np.full_like(chain.stiffness, 0.004 * joints / 0.09)
    return replace(chain, stiffness=stiffness)


@pytest.mark.parametrize(
    ("move", "turn", "torque"),
    [
        ((2e-6, 0, 0), (0, 0, 0), (0, 6 * 0.004 * 2e-6 / 0.09**2, 0)),
        ((0, 2e-6, 0), (0, 0, 0), (-6 * 0.004 * 2e-6 / 0.09**2, 0, 0)),
        ((0, 0, 0), (0, 1e-4, 0), (0, -2 * 0.004 * 1e-4 / 0.09, 0)),
        ((0, 0, 0), (1e-4, 0, 0), (-2 * 0.004 * 1e-4 / 0.09, 0, 0)),
        ((0, 0, 0), (0, 0, 1e-4), (0, 0, 0.004 * 1e-4 / 0.09)),
    ],
    ids=["sideways x", "sideways y", "bend", "tilt", "twist"],
)
def test_slightly_moved_tip_is_that_of_a_clamped_beam(move, turn, torque):
    """Textbook: 6*B*w/L**2 at the base for a shift w, 2*B*phi/L for a slope phi, B*phi/L twist."""
    chain = uniform(40)
    springs = springs_of(chain, np.zeros(40))
    hold = hold_of(springs, np.add((0, 0, 0.09), move), [Rotation.from_rotvec(turn)])
    found = HeldChain(chain).base_load(hold)
    scale = np.abs(torque).max()
    assert found.torque[:, 0] / scale == pytest.approx(np.array(torque) / scale, abs=2e-3)


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (-9.81, 0.0), (0.0, 9.81)])
def test_finger_against_a_wall_presses_as_in_the_plane(gravity):
    chain = chain_of(8)
    rest = discretise(FINGER, 8, Model()).rest_rotation([31e3])[:, 1]
    planar, springs = planar_finger(chain), linear_springs(chain.stiffness[:, 1], rest)
    stop = Stop((-1.0, 0.0), -0.02)
    pressed = equilibrium(planar, springs, gravity, stop)
    assert pressed.tip_force > 0.05
    place = np.array([pressed.tip[0], 0.0, pressed.tip[1]])
    turn = Rotation.from_rotvec([0, pressed.angles.sum(), 0])
    pull = (gravity[0], 0.0, gravity[1])
    found = HeldChain(chain).base_load(hold_of(springs_of(chain, rest), place, [turn], pull))
    oracle = Oracle(chain, rest, gravity=pull)
    off = np.zeros((8, 3))
    off[:, 1] = pressed.angles - rest
    push = np.array([-pressed.tip_force, 0.0, 0.0])
    expected = np.cross(place, push) + oracle.weight_moment(off.ravel())
    assert found.torque[:, 0] == pytest.approx(expected, rel=3e-3, abs=1e-9)
    assert found.force[:, 0] == pytest.approx(push + chain.mass.sum() * np.array(pull), abs=0.03)


def tip_wrench(held, springs, place, turn):
    found = held.base_load(hold_of(springs, place, [turn]))
    force, torque = found.force[:, 0], found.torque[:, 0]
    return np.concatenate([force, torque - np.cross(place, force)])


def test_stiffness_of_the_tip_is_reciprocal():
    """What a shift along i does to the force along j, a shift along j does to that along i."""
    chain, rest = chain_of(6), np.linspace(0.3, 0.1, 6)
    springs = springs_of(chain, rest, coupling=np.array([0.3]), factor=slack)
    held, oracle = HeldChain(chain), Oracle(chain, rest)
    extra = np.tile([0.05, -0.08, 0.04], 6) + 0.02 * np.sin(np.arange(18))
    place, turn = oracle.tip(extra)
    columns, step = [], 1e-5
    for axis in range(6):
        shift = step * np.eye(6)[axis]
        sides = [
            tip_wrench(
                held, springs, place + s * shift[:3], Rotation.from_rotvec(s * shift[3:]) * turn
            )
            for s in (1, -1)
        ]
        columns.append((sides[0] - sides[1]) / (2 * step))
    stiffness = np.array(columns).T
    # moments turn with the tip: half of their cross product is not symmetric
    moment = tip_wrench(held, springs, place, turn)[3:]
    stiffness[3:, 3:] += 0.5 * np.cross(np.eye(3), moment)
    scale = np.sqrt(np.outer(np.abs(np.diag(stiffness)), np.abs(np.diag(stiffness))))
    assert np.abs((stiffness - stiffness.T) / scale).max() < 1e-3
    assert np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0.0


def test_points_do_not_know_of_each_other():
    chain, random = chain_of(6), np.random.default_rng(2)
    rest = 0.1 + 0.2 * random.random((6, 12))
    poses = [Oracle(chain, rest[:, i]).tip(0.1 * random.normal(size=18)) for i in range(12)]
    places, turns = [pose[0] for pose in poses], [pose[1] for pose in poses]
    held = HeldChain(chain)
    together = held.base_load(hold_of(springs_of(chain, rest, 12), places, turns))
    assert together.settled.all()
    for i in range(12):
        alone = held.base_load(hold_of(springs_of(chain, rest[:, i]), places[i], [turns[i]]))
        assert together.torque[:, i] == pytest.approx(alone.torque[:, 0], rel=1e-8)


def test_pose_just_out_of_reach_takes_a_bounded_force():
    chain = chain_of(10)
    springs = springs_of(chain, np.zeros(10))
    beyond = hold_of(springs, [1e-3, 0.0, 0.0905], [Rotation.identity()])
    found = HeldChain(chain).base_load(beyond)
    assert found.settled[0]
    assert 0.5 < found.force[2, 0] < 10.0
    assert np.abs(found.torque).max() < 0.02


@pytest.mark.parametrize(("curl", "settled"), [(4.0, True), (9.0, True), (40.0, False)])
def test_a_chain_that_curls_up_carries_its_whole_bend_when_held_straight(curl, settled):
    """Not what is left of it after whole turns; a finger that no finger is, is not searched."""
    chain = uniform(10)
    hold = hold_of(springs_of(chain, np.full(10, curl / 10)), [0, 0, 0.09], [Rotation.identity()])
    found = HeldChain(chain).base_load(hold)
    assert found.settled[0] == settled
    assert found.torque[:, 0] == pytest.approx([0.0, -0.004 * curl / 0.09, 0.0], rel=1e-6, abs=1e-9)


def test_pose_far_away_is_not_called_settled():
    chain = chain_of(5)
    hold = hold_of(springs_of(chain, np.zeros(5)), [0.5, 0.0, 0.5], [Rotation.identity()])
    found = HeldChain(chain).base_load(hold)
    assert not found.settled[0]
    assert np.all(np.isfinite(found.torque))


def test_points_that_are_not_sought_keep_the_load_of_the_similar_hold():
    chain, places = chain_of(5), [[1e-3, 0.0, 0.089], [1.5e-3, 0.0, 0.089]]
    springs, turns = springs_of(chain, np.zeros(5), 2), [Rotation.identity()] * 2
    held = HeldChain(chain)
    known = held.base_load(hold_of(springs, places, turns))
    near = hold_of(springs, np.array(places) + [1e-4, 0.0, 0.0], turns)
    found = held.base_load(near, known, np.array([False, True]))
    assert known.settled.all() and found.settled.tolist() == [False, True]
    np.testing.assert_array_equal(found.wrench[:, 0], known.wrench[:, 0])
    np.testing.assert_allclose(found.wrench[:, 1], held.base_load(near).wrench[:, 1], rtol=1e-6)


def test_large_displacements_are_found():
    """Poses up to 40 mm and 80 degrees off, as when the tip is pushed about by hand."""
    chain, random = chain_of(10), np.random.default_rng(5)
    rest = 0.25 * random.random((1, 300)) * np.ones((10, 1))
    extra = 0.1 * (random.normal(size=(300, 1, 3)) + 0.5 * random.normal(size=(300, 10, 3)))
    poses = [Oracle(chain, rest[:, i]).tip(extra[i].ravel()) for i in range(300)]
    hold = hold_of(springs_of(chain, rest, 300), [p for p, _ in poses], [r for _, r in poses])
    found = HeldChain(chain).base_load(hold)
    assert np.mean(found.settled) > 0.99


def test_chain_of_arcs_is_refused():
    palm = discretise(load_hand("rbo_hand_2").chain("palm"), 4, Model())
    with pytest.raises(ValueError, match="straight at rest"):
        HeldChain(palm.segments)
