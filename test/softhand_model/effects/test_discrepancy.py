"""The generic term: what its factor is, and that the elastic side grows whatever its values."""

from itertools import product

import numpy as np
import pytest

from softhand_model.bending.balance import grows
from softhand_model.effects import effect_classes
from softhand_model.effects.stages import SectionShape, Strain

DISCREPANCY = effect_classes()["discrepancy"]
NAMES = [parameter.name for parameter in DISCREPANCY.parameters]
SHAPE = SectionShape(np.full((1, 1, 1), 0.02), np.full((1, 1, 1), 0.02), 0.003, 0.003, 1.0, 67e3)


def factor(stretch, **values):
    effect = DISCREPANCY(**{**dict.fromkeys(NAMES, 0.0), **values})
    strain = Strain(np.asarray(stretch, float))
    return effect.stress(strain.elastic_term, strain, SHAPE, {}, 0.1) / strain.elastic_term


def test_it_is_the_only_effect_that_is_not_physics():
    assert [name for name, one in effect_classes().items() if not one.physical] == ["discrepancy"]


def test_with_no_values_it_does_nothing():
    np.testing.assert_allclose(factor([0.9, 1.2, 4.0]), 1.0)


def test_a_ramp_acts_between_its_stretches_and_stays():
    found = factor([1.02, 1.05, np.sqrt(1.05 * 1.12), 1.12, 2.5], a2=0.2)
    np.testing.assert_allclose(found, np.exp([0.0, 0.0, 0.1, 0.2, 0.2]))


@pytest.mark.parametrize("mode", ["pure_shear", "uniaxial", "linear"])
def test_the_elastic_side_grows_at_every_corner_of_the_bounds(mode):
    ends = [(parameter.low, parameter.high) for parameter in DISCREPANCY.parameters]
    corners = np.array(list(product(*ends)))
    effect = DISCREPANCY.in_lanes(dict(zip(NAMES, corners.T, strict=True)))
    assert grows([effect], SHAPE, mode).all()


def test_the_bounds_are_no_wider_than_growth_allows():
    """Beyond them by a third the side falls, so they do not give away much either."""
    for index, parameter in enumerate(DISCREPANCY.parameters):
        values = {name: np.zeros(1) for name in NAMES}
        values[NAMES[index]] = np.array([1.34 * parameter.low])
        modes = ("pure_shear", "uniaxial", "linear")
        stretch = np.geomspace(1.0005, 4.0, 4000).reshape(1, 1, -1)
        falls = []
        for mode in modes:
            strain = Strain(stretch, mode)
            stress = DISCREPANCY.in_lanes(values).stress(
                strain.elastic_term, strain, SHAPE, {}, 0.0
            )
            falls.append(bool((np.diff(stress[0, 0]) < 0.0).any()))
        assert any(falls), parameter.name
