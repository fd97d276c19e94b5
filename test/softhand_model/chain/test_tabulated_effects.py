"""Effects that only change the rubber's law are tabulated with the rest shape; others are not."""

import numpy as np
import pytest

from softhand_model.chain.chain import discretise
from softhand_model.chain.free_response import SegmentResponse, tabulates
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

EFFECTS = effect_classes()
FINGER = load_hand("single_finger").chain("finger")
SMOOTH = (
    "gent_stiffening",
    "yeoh_stiffening",
    "thick_wall",
    "side_wall_integral",
    "actuation_nonlinearity",
)
STEPWISE = (
    "dead_zone",
    "temperature_modulus",
    "hysteresis",
    "passive_layer_slack",
    "bend_twist_coupling",
)


def model(name):
    """With the usual values of the effect's parameters."""
    effect = EFFECTS[name]
    return Model(effects=(effect(**{p.name: p.usual() for p in effect.parameters}),))


@pytest.mark.parametrize("name", SMOOTH)
def test_table_and_stepwise_balance_agree(name):
    effects = model(name)
    chain = discretise(FINGER, 5, effects)
    response = SegmentResponse(load_actuator("P10.finger"), 5, effects)
    assert len(chain.rest_tables) == 1
    for pressure in (0.0, 1.0, 950.0, 31e3, 80e3, 200e3):
        found = chain.step(1e-3, [pressure], np.zeros((5, 3)))
        own = response.angles(1e-3, pressure, 293.15)
        np.testing.assert_allclose(found[:, 1], own, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", SMOOTH)
def test_slope_of_the_table_is_that_under_the_effect(name):
    chain = discretise(FINGER, 5, model(name))
    rise = chain.rest_rotation([30.1e3]) - chain.rest_rotation([29.9e3])
    slope = chain.rest_tables[0].slope(30e3)[BEND_AXIS::3]
    assert slope == pytest.approx(rise[:, 1] / 200.0, rel=1e-5)


@pytest.mark.parametrize("name", STEPWISE)
def test_what_remembers_or_holds_or_has_a_corner_is_not_tabulated(name):
    assert not tabulates(model(name))
    assert discretise(FINGER, 5, model(name)).rest_tables == ()


def test_an_effect_of_ones_own_is_asked_in_every_step():
    class Own(EFFECTS["yeoh_stiffening"]):
        """The same under another class."""

    assert not tabulates(Model(effects=(Own(c2=0.07),)))
