"""What is said of the P5, and the section that is bent for it."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from softhand_model.hand import section
from thesis.frame import experiments
from thesis.p5 import p5
from thesis.p5.hull import Hull, Rubber, ring_invariant

NEO = Rubber(67e3)
THICK = Hull(0.009, 0.003, 0.0016)
MEASUREMENTS = Path(os.environ.get("SOFTHAND_MEASUREMENTS", "/nowhere"))


@pytest.mark.parametrize("name", experiments("p5"))
def test_the_experiment_gives_finite_figures_a_verdict_and_a_picture(name, check_small_run):
    check_small_run(name)


def test_the_model_file_alone_is_held_to_the_marker(small):
    _, report = small("p5")
    judged = [found for found in report.findings if found.met is not None]
    assert [found.what for found in judged] == [p5.SHIPPED]
    assert judged[0].met and 17.0 < judged[0].value < 18.0


def test_no_rubber_and_no_hull_with_its_own_modulus_meets_the_marker_alone(small):
    _, report = small("p5")
    alone = [
        f
        for f in report.findings
        if f.what.startswith(("Gent", "Yeoh with", "Ogden with", "ring, mod"))
    ]
    assert len(alone) == 6
    assert max(found.value for found in alone) < 12.0


def test_a_model_that_bends_too_far_falls_short(small):
    results, report = small("p5")
    bare = dict(results["candidates"])
    bare[p5.SHIPPED] = bare["bare model, 67 kPa"]
    assert report.verdict.startswith("holds")
    again = p5.report(results | {"candidates": bare}, p5.Parameters())
    assert again.verdict.startswith("falls short")


def test_the_ring_stiffens_the_thickest_wall_at_low_pressure_and_no_other(small):
    """The riddle of section 5.2.2, without a constant of its own."""
    walls = small("p5")[0]["walls"]
    for wall in ("2.5", "3.5"):
        assert walls[wall] == pytest.approx(np.ones(6), abs=0.015)
    assert walls["5.5"][0] > 1.12
    assert walls["5.5"][-1] < walls["5.5"][0] - 0.05


def test_a_thin_hull_is_a_membrane_in_pure_shear():
    thin = Hull(0.02, 0.0002, 0.0002)
    for curvature in (10.0, 60.0):
        ring, layers = thin.ring_pressure(curvature, NEO), thin.layered_pressure(curvature, 67e3)
        assert ring == pytest.approx(layers, rel=0.04)
    walls = section.small_strain_side_wall_ratio(0.02, 0.02, 0.0002, 0.0002)
    straight = float(2e-4 / 0.02 * 67e3 * 2.0 / walls * 2.0 * (4 * 0.02 * 1e-2))
    assert thin.layered_pressure(1e-2, 67e3) == pytest.approx(straight, rel=0.05)


def test_an_even_stretch_of_the_ring_keeps_the_rubbers_volume():
    """Far away from the mesh the ring is a tube; its wall's area falls with the stretch."""
    radius = np.linspace(0.5, 1.0, 201)
    middle, curvature = 1e6, 1e-6
    invariant = ring_invariant(curvature, radius[:, None], np.zeros(1), 1.0, middle)[:, 0]
    stretch = 1.0 + curvature * middle
    moved = np.sqrt(1.0 - (1.0 - radius**2) / stretch)
    around = moved / radius
    expected = stretch**2 + around**2 + (stretch * around) ** -2.0 - 3.0
    assert invariant == pytest.approx(expected, rel=1e-6)
    assert invariant[-1] == pytest.approx(stretch**2 + stretch**-2.0 - 2.0, rel=1e-5)


def test_pressure_of_the_ring_is_that_of_its_curvature():
    for rubber in (NEO, Rubber(84e3, 0.0724)):
        curvature = THICK.ring_curvature(150e3, rubber)
        assert THICK.ring_pressure(curvature, rubber) == pytest.approx(150e3, rel=1e-6)


def test_passive_layer_leaves_the_stated_chamber():
    height = 0.009
    hull = Hull(height, 0.003, p5.floor())
    assert hull.chamber * 0.120 == pytest.approx(1.6e-6)
    assert 0.001 < p5.floor() < 0.002


@pytest.mark.skipif(not MEASUREMENTS.is_dir(), reason="no folder of measurements")
@pytest.mark.parametrize("stretch", p5.SILICONE)
def test_the_silicones_constants_are_those_of_the_measurement(stretch):
    file = MEASUREMENTS / "silicone_dragon_skin_10" / "pull.csv"
    pull = np.genfromtxt(file, delimiter=",", names=True)
    part = pull[(pull["stretch"] > 1.0) & (pull["stretch"] < stretch)]
    along = part["stretch"]
    invariant, neo = along**2 + 2.0 / along - 3.0, along - along**-2.0

    def excess(guess):
        return 1e3 * guess[0] * (1.0 + 2.0 * guess[1] * invariant) * neo - part["stress"]

    found = least_squares(excess, (50.0, 0.05), x_scale=(10.0, 0.01)).x
    modulus, c2 = p5.SILICONE[stretch]
    assert 1e3 * found[0] == pytest.approx(modulus, rel=0.002)
    assert found[1] == pytest.approx(c2, rel=0.005)
