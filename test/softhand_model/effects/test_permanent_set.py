"""Permanent set: what stays at rest, and that it belongs to the specimen."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.bending.balance import SteppedBalance
from softhand_model.effects import effect_classes
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain

SHAPE = SectionShape(*(np.full((1, 1, 1), size) for size in (0.02, 0.02, 0.003, 0.003, 0.9, 6e4)))


@pytest.mark.parametrize("mode", ["pure_shear", "equibiaxial"])
def test_a_share_of_the_largest_strain_stays_at_rest(mode):
    stepped = SteppedBalance(StagedEffects([effect_classes()["permanent_set"](share=0.1)]), mode)
    peaks, rests = [], []
    for load in (0.0, 0.5, 0.0, 0.9, 0.0, 0.4, 0.0):
        stretch = float(stepped.stretch(np.full((1, 1, 1), load), SHAPE, 0.1)[0, 0, 0])
        (peaks if load else rests).append(stretch)
    largest = np.maximum.accumulate([1.0, *peaks])
    assert np.array(rests) == pytest.approx(1.0 + 0.1 * (largest - 1.0), abs=1e-6)


def test_a_stretched_rubber_is_longer_by_its_set():
    """q(lambda/lam_rest) = load, solved by bisection."""
    stepped = SteppedBalance(StagedEffects([effect_classes()["permanent_set"](share=0.1)]))
    high, low = (
        float(stepped.stretch(np.full((1, 1, 1), load), SHAPE, 0.1)[0, 0, 0]) for load in (1.5, 0.7)
    )
    rest = 1.0 + 0.1 * (high - 1.0)
    assert low == pytest.approx(rest * brentq(lambda x: x - x**-3 - 0.7, 1.0, 2.0), rel=1e-6)


def test_a_strip_that_is_shorter_than_at_rest_hangs_slack():
    effect, memory = effect_classes()["permanent_set"](share=0.1), {}
    stresses = []
    for stretch in (1.0, 2.0, 1.3, 1.05, 1.0):
        strain = Strain(np.full((1, 1, 1), stretch), "uniaxial")
        stresses.append(effect.stress(strain.elastic_term, strain, SHAPE, memory, 0.1).item())
        effect.remember(strain.elastic_term, strain, SHAPE, memory, 0.1)
    expected = [x - x**-2 for x in (1.0, 2.0 / 1.1, 1.3 / 1.1, 1.0, 1.0)]
    assert stresses == pytest.approx(expected, abs=1e-12)
