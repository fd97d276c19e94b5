"""Lateral and torsional stiffness of a section against quadrature and a solved stress function."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from softhand_model.chain.segments import cut_chain
from softhand_model.hand import joint_stiffness as side_stiffness
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.hand.section import bending_stiffness, side_wall_share
from thesis.chapter_3_and_5.planar import Stop, equilibrium, linear_springs, planar_finger

G = 67e3  # [Pa]
SIZES = [(0.020, 0.020, 0.002, 0.002), (0.009, 0.009, 0.003, 0.003), (0.018, 0.024, 0.001, 0.002)]


def middles(length, count):
    return (np.arange(count) + 0.5) * length / count


class Fibres:
    """Walls cut into fibres along the actuator, of rubber that neither shrinks nor swells and that
    the thread holds at its width: stretches (u, 1/u, 1), energy G/2*(u**2 + u**-2 + 1 - 3).
    """

    def __init__(self, size, offsets=(0.0,), cells=240):
        height, width, wall, side_wall = size
        up, off = np.meshgrid(middles(height, cells), middles(width, cells) - width / 2)
        rubber = (up > height - wall) | (np.abs(off) > width / 2 - side_wall)
        self.up = np.tile(np.where(up > height - wall, height, up)[rubber], len(offsets))
        self.off = np.concatenate([off[rubber] + offset for offset in offsets])
        self.area = height * width / cells**2

    def energy(self, bend, sway):
        stretches = np.stack([u := 1 + bend * self.up + sway * self.off, 1 / u, np.ones_like(u)])
        return G / 2 * self.area * np.sum((stretches**2).sum(axis=0) - 3)

    def stiffness(self, bend, axis):
        """Second derivative [N m2] of the energy in bending (0) or sideways (1) at a curvature."""
        step = 0.05 * np.eye(2)[axis]
        there, here, back = (
            self.energy(*(np.array([bend, 0.0]) + k * step)) for k in (1.0, 0.0, -1.0)
        )
        return (there - 2 * here + back) / 0.05**2


def base_stiffness(springs, actuator):
    """Stiffness (3,) [N m2] of the first of many segments: next to the base."""
    return springs.stiffness(actuator, 500)[0] * actuator.length / 500


@pytest.mark.parametrize("size", SIZES)
def test_straight_fibres_resist_both_bendings_with_one_modulus(size):
    """4*G of 3.24: in bending with the side walls integrated, sideways with the second moment."""
    fibres = Fibres(size)
    integrated = bending_stiffness(0.0, *size[:3], 0.0, G) * (1 + side_wall_share(*size))
    assert fibres.stiffness(0.0, 0) == pytest.approx(integrated, rel=0.02)
    lateral = side_stiffness.lateral_stiffness(*size, 4 * G)
    assert fibres.stiffness(0.0, 1) == pytest.approx(lateral, rel=0.01)


@pytest.mark.parametrize(("bending", "half"), [("curvature", 1.0), ("rule", 0.5)])
def test_lateral_springs_are_of_the_rubber_of_the_springs_in_bending(bending, half):
    """Straight, a P10's base has the fibres' energy sideways by 3.24, half of it by the rule."""
    springs = SpringModel(bending, lateral="section")
    lateral = base_stiffness(springs, load_actuator("P10.finger"))[0]
    assert lateral == pytest.approx(half * Fibres(SIZES[0]).stiffness(0.0, 1), rel=0.01)


def test_two_moduli_are_the_least_of_the_rubber_up_to_a_stretch_of_176_and_not_beyond():
    fibres, rule = Fibres(SIZES[0]), side_stiffness.lateral_stiffness(*SIZES[0], 2 * G)
    stretch = np.array([1.35, 1.75, 1.77])
    found = [fibres.stiffness((u - 1) / 0.02, 1) / rule for u in stretch]
    assert found[0] == pytest.approx(1.31, abs=0.01)
    assert found[1] > 1.0 > found[2]


@pytest.mark.parametrize(("bending", "half"), [("curvature", 1.0), ("rule", 0.5)])
def test_a_pair_resists_sideways_about_its_common_middle(bending, half):
    """Fibres of both P5 of a finger of RBO Hand 1, 11 mm apart: 4.6 times twice the one."""
    chain = replace(load_hand("rbo_hand_1").chain("middle"), web=None)
    springs, edge = SpringModel(bending, lateral="section"), 0.120 / 10
    found = cut_chain(chain, 10, springs).stiffness[:, 0] * edge
    pair = Fibres(SIZES[1], (-0.0055, 0.0055)).stiffness(0.0, 1)
    assert found == pytest.approx(half * pair, rel=0.01)
    one = springs.stiffness(load_actuator("P5"), 10)[:, 0] * edge
    assert found / (2 * one) == pytest.approx(4.6, abs=0.05)


def test_shares_of_a_pair_are_those_of_its_actuators_unless_the_section_is_asked_for():
    chain = replace(load_hand("rbo_hand_1").chain("middle"), web=None)
    one = SpringModel(lateral=0.3).stiffness(load_actuator("P5"), 10)
    assert cut_chain(chain, 10, SpringModel(lateral=0.3)).stiffness == pytest.approx(2 * one)


@pytest.mark.parametrize("pressure", [20e3, 40e3])
def test_side_walls_make_a_blocked_finger_push_harder_than_the_rule_alone(pressure):
    """Springs of 3.26 with 2/ratio against 3.26 written out, both at the free curvature."""
    finger, edge = load_actuator("P10.finger"), 0.09 / 10
    x = (np.arange(10) + 0.5) * edge
    alone = 2 * G * finger.wall(0.0) * 0.02**3 * (1 - x / 0.09) / edge
    chain = cut_chain(load_hand("single_finger").chain("finger"), 10)
    rest = finger.free_curvature(pressure, x) * edge
    stop = Stop((-1.0, 0.0), -0.015)
    force, plain = (
        equilibrium(planar_finger(chain), linear_springs(k, rest), stop=stop).tip_force
        for k in (chain.stiffness[:, 1], alone)
    )
    assert force / plain == pytest.approx(1.71, abs=0.02)


@pytest.mark.parametrize("size", SIZES)
def test_second_moments_agree_with_a_sum_over_the_area_of_the_walls(size):
    height, width, wall, side_wall = size
    y = middles(width, 1200)[:, None] - width / 2
    up = middles(height, 900)[None]
    rubber = (up > height - wall) | (np.abs(y) > width / 2 - side_wall)
    about_middle = np.sum(y**2 * rubber) * height * width / (1200 * 900)
    assert side_stiffness.lateral_second_moment(*size) == pytest.approx(about_middle, rel=2e-3)


def test_without_side_walls_the_top_alone_resists_as_a_strip_on_edge():
    modulus = 67e3
    lateral = side_stiffness.lateral_stiffness(0.02, 0.02, 0.002, 0.0, modulus)
    assert lateral == pytest.approx(modulus * 0.002 * 0.02**3 / 12)
    assert side_stiffness.twist_stiffness(0.02, 0.02, 0.002, 0.0, modulus) == 0.0


def torsion_of_a_box(height, width, wall, cells):
    """Torsion constant of a hollow box [m4], all walls alike: Prandtl's stress function f with
    laplace f = -2, zero outside and one constant in the hole, which adds f times twice its area.
    """
    step = wall / cells
    rows, columns = round(height / step), round(width / step)
    inside = np.zeros((rows - 1, columns - 1), bool)
    inside[cells - 1 : rows - cells, cells - 1 : columns - cells] = True  # hole with its border
    number = np.full((rows + 1, columns + 1), -1)
    number[1:-1, 1:-1] = np.where(inside, 0, np.cumsum(~inside).reshape(inside.shape))
    unknowns = number.max() + 1
    here, there = [], []
    for shift in ((0, 1), (1, 0)):
        a = number[: rows + 1 - shift[0], : columns + 1 - shift[1]].ravel()
        b = number[shift[0] :, shift[1] :].ravel()
        here.append(a)
        there.append(b)
    a, b = np.concatenate(here), np.concatenate(there)
    area = np.bincount(number[1:-1, 1:-1].ravel(), minlength=unknowns).astype(float)
    area[0] = (rows - 2 * cells + 1) * (columns - 2 * cells + 1)  # to the middle of its neighbours
    weights = [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)]
    kept = [(p, q, np.full(p.size, w)) for p, q, w in weights]
    p, q, w = (np.concatenate(part) for part in zip(*kept, strict=True))
    use = (p >= 0) & (q >= 0)
    matrix = coo_matrix((w[use], (p[use], q[use])), (unknowns, unknowns)).tocsc()
    stress = spsolve(matrix, 2.0 * area * step**2)
    return 2.0 * float(stress @ area) * step**2


@pytest.mark.parametrize(("wall", "within"), [(0.0005, 0.015), (0.001, 0.03), (0.002, 0.06)])
def test_bredt_agrees_with_a_solved_stress_function_where_walls_are_thin(wall, within):
    """The box around the passive layer's middle is higher by half of that layer."""
    height = width = 0.02
    solved = torsion_of_a_box(height + wall / 2, width, wall, 4)
    found = side_stiffness.torsion_constant(height, width, wall, wall)
    assert found == pytest.approx(solved, rel=within)
    assert found < solved  # Bredt's shear flow is uniform through the wall


def test_thin_square_section_is_softer_sideways_and_in_twist_than_in_bending():
    """Thin walls, h = z: 2*G*d*h**3 times 7/12 sideways, 1/2 in twist; bending 4 with ratio 1."""
    height, wall, modulus = 1.0, 1e-4, 1.0
    unit = 2 * modulus * wall * height**3
    size = (height, height, wall, wall)
    assert side_stiffness.lateral_stiffness(*size, 2 * modulus) == pytest.approx(
        7 / 12 * unit, rel=1e-3
    )
    assert side_stiffness.twist_stiffness(*size, modulus) == pytest.approx(unit / 2, rel=1e-3)
    assert bending_stiffness(0.0, *size, modulus) == pytest.approx(4 * unit, rel=1e-3)


def test_bounds_of_the_derivation_for_a_thin_square():
    """2.3 times about the taut edge (parallel axis), 4/3 where the passive layer cannot shear."""
    wall = 1e-4
    second = side_stiffness.lateral_second_moment(1.0, 1.0, wall, wall)
    area = 3 * wall
    assert (second + area * 0.25) / second == pytest.approx(2.3, abs=0.02)
    rigid = 4.0 / (3.0 / wall)  # Bredt without the passive layer in the integral
    bredt = side_stiffness.torsion_constant(1.0, 1.0, wall, wall)
    assert rigid / bredt == pytest.approx(4 / 3, rel=1e-3)
