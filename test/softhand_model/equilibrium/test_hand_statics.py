"""Statics of a hand: against a cantilever, against the simulator at rest, and their convergence."""

import numpy as np
import pytest
from held_hand import held, settled_tips

from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import (
    ActuatorScatter,
    Crosstalk,
    MountTilt,
)
from softhand_model.effects.hand_parts import PalmStiffness, StrutStiffness, TipMass
from softhand_model.effects.load import STANDARD_GRAVITY, Gravity
from softhand_model.equilibrium.hand_statics import HandBody, settled_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model

PRESSURES = np.array([25e3, 20e3, 15e3, 25e3])
RPY = (0.3, 1.2, -0.4)
EFFECTS = (
    ActuatorScatter.at(actuator="index")(modulus_factor=0.8),
    ActuatorScatter.at(actuator="palm_outer")(modulus_factor=1.2),
    MountTilt.at(chain="palm")(roll=0.1, pitch=0.1, yaw=-0.1),
    Crosstalk.at(**{"from": "a", "to": "b"})(share=0.2),
)

PARTS = (
    StrutStiffness(factor=0.4),
    PalmStiffness(factor=1.7),
    TipMass.at(chain="index")(mass=0.01),
    TipMass.at(chain="thumb")(mass=0.005),
)
OF_ACTUATORS = ("yeoh_stiffening", "thick_wall", "section_rounding", "dead_zone", "pressure_offset")


def usual(name):
    """An effect of actuators at usual values of its parameters."""
    kind = effect_classes()[name]
    return kind(**{parameter.name: parameter.usual(0.7) for parameter in kind.parameters})


CASES = {"base": (), "effects": EFFECTS, "parts": PARTS} | {
    name: (usual(name),) for name in OF_ACTUATORS
}


def body_of(hand, chains, segments, model=Model()):  # noqa: B008 (never changed)
    """Chains in series under a model."""
    return HandBody(hand, {name: discretise(hand.chain(name), segments, model) for name in chains})


def tips(hand, segments, effects=(), pressures=PRESSURES, rpy=RPY):
    """Fingertips (3,) [m] by name in the statics."""
    down = rotate(from_rpy(rpy) * [-1.0, -1.0, -1.0, 1.0], [0.0, 0.0, -STANDARD_GRAVITY])
    model, found = Model(effects=effects), {}
    for body, shape in settled_hand(hand, model, segments, pressures[:, None], down[None]):
        chains = [name for name in body.joints if name in hand.tips]
        found |= {name: body.point(shape, name, 1.0, np.zeros(3))[0] for name in chains}
    return found


@pytest.mark.parametrize("effects", CASES.values(), ids=CASES)
def test_the_simulated_hand_comes_to_rest_there(effects):
    hand = load_hand("rbo_hand_2")
    simulation = held(Model(effects=(Gravity(mass_scale=1.0), *effects)), RPY)
    simulated = settled_tips(simulation, PRESSURES, longest=12.0)
    for name, place in tips(hand, 5, effects).items():
        assert place == pytest.approx(simulated[name], abs=1e-7)
    if effects:
        moved = max(
            np.abs(tips(hand, 5)[name] - tips(hand, 5, effects)[name]).max() for name in simulated
        )
        assert moved > 0.5e-3  # [m]


@pytest.mark.parametrize("name", ["rbo_hand_2", "rbo_hand_1"])
def test_error_falls_with_the_square_of_the_segments(name):
    hand = load_hand(name)
    pressures = PRESSURES[: len(hand.channels)]
    fine, *coarser = (tips(hand, n, pressures=pressures) for n in (80, 40, 20, 10))
    errors = [max(np.abs(one[tip] - fine[tip]).max() for tip in hand.tips) for one in coarser]
    assert errors[1] < 0.15e-3  # [m], the segments of the lab
    assert errors[1] / errors[0] == pytest.approx(5.0, rel=0.1)  # (1/20**2 - 1/80**2) over 1/40**2
    assert errors[2] / errors[1] == pytest.approx(4.2, rel=0.1)


def test_a_light_finger_sags_like_a_tapered_cantilever():
    hand = load_hand("single_finger")
    finger = hand.chain("finger").actuators["finger"]
    body = body_of(hand, ("finger",), 160)
    pull = 1e-3 * STANDARD_GRAVITY
    shape = body.settle(np.zeros((1, 1)), np.array([[pull, 0.0, 0.0]]))
    sag = (
        body.point(shape, "finger", 1.0, np.zeros(3))[0]
        - body.point(body.settle(np.zeros((1, 1)), np.zeros((1, 3))), "finger", 1.0, np.zeros(3))[0]
    )
    x = np.linspace(0.0, finger.length, 2001)[:-1]
    weight = pull * np.gradient([finger.mass_between(0.0, end) for end in x], x)
    step = x[1] - x[0]
    beyond = step * np.cumsum((weight * x)[::-1])[::-1] - x * step * np.cumsum(weight[::-1])[::-1]
    stiffness = finger.stiffness(x)
    whole = np.sum(beyond / stiffness * (finger.length - x)) * step
    assert np.linalg.norm(sag) == pytest.approx(whole, rel=2e-2)


def test_weight_that_springs_cannot_carry_is_said():
    hand = load_hand("single_finger")
    body = body_of(hand, ("finger",), 5, load_model())
    with pytest.raises(RuntimeError, match="no equilibrium under their weight"):
        body.settle(np.zeros((1, 1)), np.array([[3e4, 0.0, 2e4]]))


def test_a_marker_within_a_segment_lies_on_the_arc():
    hand = load_hand("single_finger")
    body = body_of(hand, ("finger",), 20)
    shape = body.settle(np.full((1, 1), 30e3), np.zeros((1, 3)))
    fine = body_of(hand, ("finger",), 160)
    exact = fine.settle(np.full((1, 1), 30e3), np.zeros((1, 3)))
    offset = np.array([5e-3, 2e-3, 0.0])
    for at in (0.0, 0.33, 0.5, 0.71, 1.0):
        place, truth = (
            one.point(s, "finger", at, offset) for one, s in ((body, shape), (fine, exact))
        )
        assert place == pytest.approx(truth, abs=0.15e-3)


def test_markers_lie_on_straight_chains():
    hand = load_hand("rbo_hand_2")
    body = body_of(hand, ("palm", "thumb"), 4)
    shape = body.settle(np.zeros((3, 1)), np.zeros((1, 3)))
    with pytest.raises(ValueError, match="expected one on a straight chain, got the arcs of palm"):
        body.point(shape, "palm", 1.0, np.zeros(3))
