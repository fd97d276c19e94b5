"""One section: check values of chapter 3, and the same answers by energy, roots and quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from softhand_model.hand import section
from softhand_model.hand.rubber import strain_invariant

MODULUS = 67e3
SQUARE = {"height": 0.02, "width": 0.02, "wall": 0.002, "side_wall": 0.002}
OBLONG = {"height": 0.018, "width": 0.024, "wall": 0.0031, "side_wall": 0.0017}


@pytest.mark.parametrize("load", [-3.0, -0.2, 0.0, 1e-6, 0.3, 1.0, 2.5, 12.0, 1e4])
def test_free_stretch_is_the_positive_root_of_the_quartic(load):
    roots = np.roots([1.0, -load, 0.0, 0.0, -1.0])
    real = roots[np.abs(roots.imag) < 1e-9].real
    assert section.free_stretch(load) == pytest.approx(real[real > 0].max(), rel=1e-12)


def test_free_stretch_takes_arrays_of_any_shape():
    loads = np.linspace(0.0, 5.0, 12).reshape(3, 4)
    stretch = section.free_stretch(loads)
    assert stretch.shape == (3, 4)
    assert section.elastic_term(stretch) == pytest.approx(loads, abs=1e-13)


@pytest.mark.parametrize("shape", [SQUARE, OBLONG])
@pytest.mark.parametrize("curvature", [-5.0, 0.0, 12.0, 60.0])
def test_moment_is_the_gradient_of_the_energy(shape, curvature):
    """W = energy of the rubber - pressure times chamber volume, per length; M = -dW/dkappa."""
    pressure, step = 40e3, 1e-4
    walls = 2.0 / section.side_wall_ratio(**shape)

    def energy(kappa):
        rubber = MODULUS / 2 * strain_invariant(1 + kappa * shape["height"])
        volume = section.chamber_area(kappa, **shape)
        return walls * rubber * shape["width"] * shape["wall"] - pressure * volume

    gradient = (energy(curvature + step) - energy(curvature - step)) / (2 * step)
    moment = section.bending_moment(pressure, curvature, **shape, shear_modulus=MODULUS)
    assert moment == pytest.approx(-gradient, rel=1e-6)


@pytest.mark.parametrize("shape", [SQUARE, OBLONG])
def test_free_curvature_leaves_no_moment(shape):
    pressure = np.array([1e3, 30e3, 200e3])
    curvature = section.free_curvature(pressure, **shape, shear_modulus=MODULUS)
    moment = section.bending_moment(pressure, curvature, **shape, shear_modulus=MODULUS)
    scale = shape["height"] ** 2 * shape["width"] * pressure / 2
    assert np.abs(moment / scale).max() < 1e-12


@pytest.mark.parametrize("modulus", [20e3, 67e3, 500e3])
@pytest.mark.parametrize("wall", [0.001, 0.003, 0.006])
def test_straight_section_carries_pressure_whatever_the_rubber(modulus, wall):
    shape = {"height": 0.018, "width": 0.022, "wall": wall, "side_wall": 2 * wall}
    moment = section.bending_moment(25e3, 0.0, **shape, shear_modulus=modulus)
    assert moment == pytest.approx(0.018**2 * 0.022 * 25e3 / 2)


@pytest.mark.parametrize("curvature", [0.0, 8.0, 55.0])
def test_stiffness_is_the_slope_of_the_moment(curvature):
    step = 1e-4

    def moment(kappa):
        return section.bending_moment(40e3, kappa, **OBLONG, shear_modulus=MODULUS)

    slope = (moment(curvature + step) - moment(curvature - step)) / (2 * step)
    stiffness = section.bending_stiffness(curvature, **OBLONG, shear_modulus=MODULUS)
    assert stiffness == pytest.approx(-slope, rel=1e-7)


def test_rule_of_stiffness_lies_between_its_limits():
    """Without side walls it is half the straight section's, and twice the far bent one's."""
    bare = {**SQUARE, "side_wall": 0.0}
    rule = section.rule_stiffness(0.02, 0.002, MODULUS)
    straight, bent = section.bending_stiffness(np.array([0.0, 1e6]), **bare, shear_modulus=MODULUS)
    assert straight == pytest.approx(2 * rule)
    assert straight == pytest.approx(4 * 0.02**2 * 0.02 * MODULUS * 0.002)
    assert bent == pytest.approx(rule / 2)


def test_stiffness_grows_with_the_fourth_power_of_size():
    def stiffness(size):
        shape = {name: size * value for name, value in OBLONG.items()}
        return section.bending_stiffness(10.0 / size, **shape, shear_modulus=MODULUS)

    assert stiffness(1.7) / stiffness(1.0) == pytest.approx(1.7**4)


def test_rule_of_actuation_and_of_stiffness_agree():
    ratio = section.rule_actuation_ratio(0.003, MODULUS)
    eq_3_33 = 0.02**3 / (4.0 * ratio)
    assert eq_3_33 == pytest.approx(section.rule_stiffness(0.02, 0.003, MODULUS))


@pytest.mark.parametrize(
    ("pressure", "modulus", "degrees"), [(31e3, 73.7e3, 122.2), (31e3, 67e3, 141.2)]
)
def test_constant_section_bends_to_the_exact_tip_angle(pressure, modulus, degrees):
    curvature = section.free_curvature(pressure, **SQUARE, shear_modulus=modulus)
    assert np.degrees(curvature * 0.09) == pytest.approx(degrees, abs=0.05)


def test_printed_approximation_bends_to_its_own_tip_angle():
    curvature = section.free_curvature_printed(31e3, **SQUARE, shear_modulus=73.7e3)
    assert np.degrees(curvature * 0.09) == pytest.approx(124.4, abs=0.1)


@pytest.mark.parametrize(("relative_pressure", "error"), [(0.3, 0.084), (1.5, -0.012), (5.0, 0.12)])
def test_printed_nonlinearity_errs_as_tabulated(relative_pressure, error):
    """Exact secant with ratio 1: kappa*h/u with q(lambda) = 2*u."""
    stretch = brentq(lambda lam: lam - lam**-3 - 2 * relative_pressure, 1.0, 20.0)
    exact = (stretch - 1) / relative_pressure
    printed = section.printed_nonlinearity(relative_pressure)
    assert printed / exact - 1 == pytest.approx(error, abs=0.005)


def test_printed_nonlinearity_ends_above_two():
    assert section.printed_nonlinearity(1e9) == pytest.approx(2.232, abs=1e-3)
    assert section.printed_nonlinearity(0.0) == 0.5


@pytest.mark.parametrize(("wall", "ratio"), [(1e-9, 1.0), (0.1, 1.105)])
def test_side_wall_ratio_of_a_square(wall, ratio):
    assert section.side_wall_ratio(1.0, 1.0, wall, wall) == pytest.approx(ratio, abs=5e-4)


def test_side_wall_ratio_is_two_without_side_walls():
    assert section.side_wall_ratio(1.0, 1.0, 0.1, 0.0) == 2.0
    assert section.side_wall_ratio(0.004, 0.02, 0.005, 0.005) == 2.0
    assert section.side_wall_share(0.004, 0.02, 0.005, 0.005) == 0.0
    assert section.printed_side_wall_share(0.004, 0.005, 0.005) == 0.0
    assert section.side_wall_term(9.0, 0.004, 0.02, 0.005, 0.005) == 0.0
    assert section.chamber_area(0.0, 0.004, 0.02, 0.005, 0.005) == pytest.approx(-0.001 * 0.02)


@pytest.mark.parametrize(("wall", "printed", "proper"), [(0.1, 0.328, 0.486), (0.3, 0.120, 0.229)])
def test_side_wall_share_as_printed_and_done_properly(wall, printed, proper):
    assert section.printed_side_wall_share(1.0, wall, wall) == pytest.approx(printed, abs=7e-4)
    assert section.side_wall_share(1.0, 1.0, wall, wall) == pytest.approx(proper, abs=7e-4)


def test_printed_side_walls_lose_a_quarter_of_the_blocked_moment():
    """3.36 in the load with 3.29 in the stiffness gives 0.73 of h**2*z*p/2 at small load."""
    ratio = section.side_wall_ratio(1.0, 1.0, 0.1, 0.1)
    bare = section.bending_stiffness(0.0, 1.0, 1.0, 0.1, 0.0, 1.0)
    stiffness = bare * (1 + section.printed_side_wall_share(1.0, 0.1, 0.1))
    curvature = 1e-6 * ratio / (16 * 1.0 * 0.1)
    assert stiffness * curvature / (1e-6 / 2) == pytest.approx(0.73, abs=0.005)


@pytest.mark.parametrize("curvature", [0.0, 5.0, 70.0])
def test_side_wall_term_is_the_integral_over_the_walls(curvature):
    inner = OBLONG["height"] - OBLONG["wall"]
    integral, _ = quad(lambda y: y * section.elastic_term(1 + curvature * y), 0.0, inner)
    scale = 2 * OBLONG["side_wall"] / (OBLONG["height"] * OBLONG["width"] * OBLONG["wall"])
    assert section.side_wall_term(curvature, **OBLONG) == pytest.approx(scale * integral, abs=1e-15)


@pytest.mark.parametrize(("wall", "ratio"), [(1e-9, 1.2), (0.1, 1.346)])
def test_side_wall_ratio_at_small_strain(wall, ratio):
    """The closed form and the limit of the exact integral agree."""
    assert section.small_strain_side_wall_ratio(1.0, 1.0, wall, wall) == pytest.approx(
        ratio, abs=5e-4
    )
    strain = 1e-4
    term = section.side_wall_term(strain, 1.0, 1.0, wall, wall)
    assert 2 / (1 + term / section.elastic_term(1 + strain)) == pytest.approx(ratio, abs=1e-3)


def test_the_share_of_the_side_walls_is_the_limit_of_their_integral_in_any_section():
    strain = 1e-3  # [1/m]
    top = section.elastic_term(1 + strain * OBLONG["height"])
    share = section.side_wall_term(strain, **OBLONG) / top
    assert section.side_wall_share(**OBLONG) == pytest.approx(share, rel=1e-3)
    assert section.small_strain_side_wall_ratio(**OBLONG) == pytest.approx(
        2 / (1 + share), rel=1e-3
    )


def test_exact_side_walls_act_nearly_as_a_softer_rubber():
    """One factor on the modulus takes most of it, so data hardly tell them apart."""
    curvature = np.linspace(0.1, 70.0, 60)
    exact = section.elastic_term(1 + curvature * 0.02) + section.side_wall_term(curvature, **SQUARE)
    base = 2 / section.side_wall_ratio(**SQUARE) * section.elastic_term(1 + curvature * 0.02)
    factor = exact / base
    assert factor[0] == pytest.approx((1 + 0.486) / (1 + 0.81), abs=1e-3)
    assert 0.82 <= factor.min() < factor.max() < 0.90


@pytest.mark.parametrize("curvature", [0.01, 20.0, 90.0])
def test_chamber_holds_the_ring_sector_less_the_rubber(curvature):
    """Eq. 3.15: the section sweeps a sector between radii 1/kappa and 1/kappa + h."""
    h, z, d, side = (OBLONG[key] for key in ("height", "width", "wall", "side_wall"))
    radius = 1 / curvature
    sector = z * ((radius + h) ** 2 - radius**2) / (2 * radius)
    rubber = z * d + (h - d) * 2 * side
    area = section.chamber_area(curvature, **OBLONG)
    assert area == pytest.approx(sector - rubber, rel=1e-9)
    without = section.chamber_area(curvature, h, z, d, 0.0)
    assert without == pytest.approx(sector - z * d, rel=1e-9)


@pytest.mark.parametrize(("side_wall", "cubic_centimetres"), [(0.0, 6.48), (0.003, 2.16)])
def test_p5_chamber_volume(side_wall, cubic_centimetres):
    area = section.chamber_area(0.0, 9e-3, 9e-3, 3e-3, side_wall)
    assert area * 0.12 * 1e6 == pytest.approx(cubic_centimetres)


@pytest.mark.parametrize("pressure", [10e3, 46.3e3])
def test_rule_bends_alike_whatever_the_size_and_the_exact_form_does_not(pressure):
    heights = np.array([0.02, 0.0085])
    rule = pressure * section.rule_actuation_ratio(0.0055, MODULUS) * np.ones(2)
    exact = section.free_curvature(pressure, heights, heights, 0.0055, 0.0055, MODULUS)
    assert rule[0] == rule[1]
    assert exact[1] / exact[0] > 1.1
