"""Lateral and torsional stiffness of a section against quadrature and a solved stress function."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from softhand_model import side_stiffness
from softhand_model.section import bending_stiffness

SIZES = [(0.020, 0.020, 0.002, 0.002), (0.009, 0.009, 0.003, 0.003), (0.018, 0.024, 0.001, 0.002)]


def middles(length, count):
    return (np.arange(count) + 0.5) * length / count


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
    assert lateral == pytest.approx(2 * modulus * 0.002 * 0.02**3 / 12)
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
    assert side_stiffness.lateral_stiffness(*size, modulus) == pytest.approx(
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
