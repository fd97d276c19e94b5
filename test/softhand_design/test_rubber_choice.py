"""Choice of a rubber (3.3.3) against a search of height and wall by brute force."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from softhand_design.rubber_choice import choose, demand, highest, wall_for_stiffness
from softhand_model.hand.rubber import Rubber, load_rubbers

STEP = 2e-4  # of heights, relative


def requests(count, seed=5):
    random = np.random.default_rng(seed)
    curvatures = np.exp(random.uniform(np.log(20.0), np.log(600.0), count))
    stiffnesses = np.exp(random.uniform(np.log(1e-4), np.log(0.2), count))
    return [(float(k), float(b)) for k, b in zip(curvatures, stiffnesses, strict=True)]


def heights_that_do(rubber: Rubber, curvature: float, stiffness: float):
    """All heights of a fine grid at which the section neither stretches nor fills too far."""
    heights = np.exp(np.arange(np.log(1e-4), np.log(2.0), STEP))
    walls = stiffness / (2.0 * heights**3 * rubber.shear_modulus)
    stretch = 1.0 + curvature * heights
    return heights[(walls <= 0.5 * heights) & (stretch <= rubber.max_stretch)]


@pytest.mark.parametrize(("curvature", "stiffness"), requests(50))
def test_lowest_and_highest_actuator_are_those_of_a_search_by_brute_force(curvature, stiffness):
    for found in choose(curvature, stiffness):
        possible = heights_that_do(found.rubber, curvature, stiffness)
        if found.suits and found.highest.height > (1 + 2 * STEP) * found.lowest.height:
            assert found.lowest.height == pytest.approx(possible.min(), rel=1e-3)
            assert found.highest.height == pytest.approx(possible.max(), rel=1e-3)
        elif not found.suits:
            assert not len(possible)


def test_the_highest_actuator_needs_the_least_rubber():
    rubber = load_rubbers()["Dragon Skin 10"]

    def area(height):
        wall = wall_for_stiffness(4e-3, height, rubber.shear_modulus)
        return 3 * height * wall - 2 * wall**2

    found = next(one for one in choose(100.0, 4e-3) if one.rubber.name == rubber.name)
    least = minimize_scalar(
        area, bounds=(found.lowest.height, found.highest.height), method="bounded"
    )
    assert found.highest.rubber_per_length <= rubber.density * least.fun * (1 + 1e-3)
    assert found.lowest.rubber_per_length > found.highest.rubber_per_length


def of(name, *wish):
    return next(one for one in choose(*wish) if one.rubber.name == name)


@pytest.mark.parametrize(
    ("name", "wish", "words"),
    [
        ("Dragon Skin 10", (100.0, 4e-3, 0.010, 1.0), "height at least "),
        ("Dragon Skin 10", (100.0, 4e-3, 0.2, 1.0), "curvature at most "),
        ("Dragon Skin 30", (100.0, 4e-3, 0.02, 0.4), "curvature at most "),  # index too small too
        ("Dragon Skin 10", (1000.0, 4e-2, None, 1.0), "curvature at most "),
        ("Elastosil M4125", (100.0, 4e-3, None, 0.05), "share above "),
    ],
)
def test_a_bound_does_as_it_is_printed_and_a_little_less_does_not(name, wish, words):
    refused = of(name, *wish).refused
    assert words in refused
    bound = float(refused.split(words)[1].split()[0].rstrip(","))
    if words.startswith("share"):
        assert not of(name, 0.1, 1e-4, None, 0.999 * bound).suits
        assert of(name, 0.1, 1e-7, None, 1.01 * bound).suits
        return
    curvature, stiffness, height, share = wish
    for factor, suits in ((1.0, True), (1.001 if "most" in words else 0.999, False)):
        if words.startswith("height"):
            assert of(name, curvature, stiffness, 1e-3 * bound * factor, share).suits is suits
        else:
            assert of(name, bound * factor, stiffness, height, share).suits is suits


def test_index_and_demand_meet_where_lowest_and_highest_are_one():
    for found in choose(100.0, 4e-3):
        curvature = 100.0 * found.index / demand(100.0, 4e-3)
        assert highest(curvature, found.rubber.max_stretch) == pytest.approx(found.lowest.height)


def test_elastosil_in_place_of_dragon_skin_takes_half_of_the_rubber_not_a_third():
    skin, other = (load_rubbers()[name] for name in ("Dragon Skin 10", "Elastosil M4125"))
    heights = [highest(200.0, one.max_stretch) for one in (skin, other)]
    pairs = zip((skin, other), heights, strict=True)
    walls = [wall_for_stiffness(4e-3, height, one.shear_modulus) for one, height in pairs]
    assert heights[1] / heights[0] == pytest.approx(0.55)
    assert walls[1] / walls[0] == pytest.approx(0.90, abs=0.005)
    rubber = heights[0] * walls[0] / (heights[1] * walls[1])
    assert rubber == pytest.approx(2.0, abs=0.05)
