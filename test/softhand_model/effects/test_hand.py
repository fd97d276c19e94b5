"""Effects of a hand: their places, and what a model file says of them."""

import numpy as np
import pytest
from held_hand import held, settled_tips

from softhand_common.numerics.rotations import rotate
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import (
    ActuatorScatter,
    ChannelGain,
    ChannelOffset,
    Crosstalk,
    MountTilt,
    RestBend,
    altered,
    at_places,
    pressure_offsets,
    pressure_shares,
)
from softhand_model.effects.load import Gravity
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model

HAND = load_hand("rbo_hand_2")
DOWN = np.array([[0.0, 0.0, -9.81]])
LEAK = Crosstalk.at(**{"from": "a", "to": "c"})


def model_of(tmp_path, entry):
    (tmp_path / "m.yaml").write_text(
        f"format: softhand-model/1\nbase: pneuflex\neffects:\n  - {entry}\n"
    )
    return load_model(tmp_path / "m.yaml")


def test_every_place_is_a_candidate_of_its_own():
    placed = at_places(HAND, effect_classes())
    assert "actuator_scatter[palm_outer]" in placed
    assert placed["crosstalk[d>b]"].where == {"from": "d", "to": "b"}
    assert not {"actuator_scatter", "mount_tilt", "crosstalk"} & placed.keys()
    assert placed["mount_tilt[thumb]"] is MountTilt.at(chain="thumb")


def test_pressure_of_a_channel_acts_in_another():
    shares = pressure_shares(HAND, [LEAK(share=0.25)])
    acting = dict(zip(HAND.actuator_names, shares @ [8.0, 1.0, 2.0, 3.0], strict=True))
    assert (acting["thumb"], acting["palm_inner"], acting["palm_outer"]) == (4.0, 4.0, 3.0)
    assert acting["index"] == 1.0


def test_less_pressure_acts_than_a_sensor_with_a_large_gain_reads():
    shares = pressure_shares(HAND, [ChannelGain.at(channel="c")(gain=1.25)])
    acting = dict(zip(HAND.actuator_names, shares @ [8.0, 1.0, 2.0, 3.0], strict=True))
    assert (acting["thumb"], acting["palm_inner"], acting["palm_outer"]) == (1.6, 1.6, 3.0)


READ, ACTING = [20e3, 5e3, 10e3, 10e3], [20e3, 5e3, (10e3 - 1.5e3) / 1.15, 10e3]  # [Pa]
OFF = (ChannelGain.at(channel="c")(gain=1.15), ChannelOffset.at(channel="c")(offset=1.5e3))


def test_a_sensor_with_a_wrong_zero_and_scale_reads_other_pressures_than_act():
    """A sensor that reads 1.15 p + 1.5 kPa."""
    felt = np.array(READ) - pressure_offsets(HAND, OFF)
    acting = pressure_shares(HAND, OFF) @ felt
    assert acting == pytest.approx(pressure_shares(HAND, []) @ ACTING)


@pytest.mark.parametrize("more", [(), ("tube_lag",)], ids=["tables", "models"])
def test_a_sensor_that_is_off_acts_alike_in_simulator_and_statics(more):
    lag = tuple(effect_classes()[name](time_constant=0.01) for name in more)
    weight = Gravity(mass_scale=1.0)
    found = settled_tips(held(Model(effects=(weight, *lag, *OFF))), READ)
    expected = settled_tips(held(Model(effects=(weight, *lag))), ACTING)
    for name, place in found.items():
        assert place == pytest.approx(expected[name], abs=1e-7)
    still = []
    for effects, pressures in ((OFF, READ), ((), ACTING)):
        rows = settled_hand(HAND, Model(effects=effects), 5, np.array([pressures]).T, DOWN)
        places = np.concatenate([shape.places[0] for _, shape in rows])
        still.append(places)
    assert still[0] == pytest.approx(still[1], abs=1e-9)


@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_a_finger_bent_at_rest_is_an_arc(angle):
    """Without pressure and weight the tip is where an arc of the finger's length has it."""
    bent = Model(effects=(RestBend.at(actuator="index")(angle=angle),))
    none, tips = np.zeros((len(HAND.channels), 1)), []
    for model in (bent, Model()):
        bodies = settled_hand(HAND, model, 40, none, np.zeros((1, 3)))
        ((body, shape),) = [one for one in bodies if "index" in one[0].joints]
        base, frame = body.placed(shape, "index", 0.0)
        tips.append(body.placed(shape, "index", 1.0)[0][0] - base[0])
    tips = [frame[0].T @ tip for tip in tips]  # along the straight finger
    length = HAND.chain("index").actuators["index"].length
    arc = length / angle * np.array([1.0 - np.cos(angle), 0.0, np.sin(angle)])
    assert tips[0] == pytest.approx(arc, abs=2e-5)
    assert tips[1] == pytest.approx([0.0, 0.0, length], abs=1e-6)


def test_a_finger_bent_at_rest_hangs_alike_in_simulator_and_statics():
    model = Model(effects=(Gravity(mass_scale=1.0), RestBend.at(actuator="index")(angle=0.3)))
    found = settled_tips(held(model), READ)["index"]
    bodies = settled_hand(HAND, model, 5, np.array([READ]).T, DOWN)
    (still,) = [
        body.point(shape, "index", 1.0, np.zeros(3))[0]
        for body, shape in bodies
        if "index" in body.joints
    ]
    assert found == pytest.approx(still, abs=1e-4)


def test_a_tilt_turns_the_chain_about_its_own_axes():
    askew = altered(HAND, [MountTilt.at(chain="thumb")(roll=0.0, pitch=0.0, yaw=0.2)])
    before, after = (hand.chain("thumb").mount.quaternion for hand in (HAND, askew))
    assert rotate(after, [0.0, 0.0, 1.0]) == pytest.approx(rotate(before, [0.0, 0.0, 1.0]))
    turned = rotate(before, [np.cos(0.2), np.sin(0.2), 0.0])
    assert rotate(after, [1.0, 0.0, 0.0]) == pytest.approx(turned)


def test_a_model_file_says_where(tmp_path):
    entry = "{name: crosstalk, where: {from: a, to: c}, parameters: {share: 0.25}}"
    (effect,) = model_of(tmp_path, entry).effects
    assert type(effect) is LEAK and effect.values == {"share": 0.25}


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{name: crosstalk, parameters: {share: 0.25}}", "where: expected from, to, got none"),
        ("{name: mount_tilt, where: {actuator: thumb}}", "where: expected chain, got actuator"),
        (
            "{name: gravity, where: {chain: thumb}, parameters: {mass_scale: 1}}",
            "expected no key `where`",
        ),
    ],
)
def test_a_place_that_is_missing_or_meaningless_is_said(tmp_path, entry, message):
    with pytest.raises(ValueError, match=message):
        model_of(tmp_path, entry)


def test_a_place_that_a_hand_lacks_is_said():
    with pytest.raises(ValueError, match="expected a place of rbo_hand_2 .*, got pinky"):
        held(Model(effects=(ActuatorScatter.at(actuator="pinky")(modulus_factor=0.8),)))


@pytest.mark.parametrize("more", [(), ("tube_lag",)], ids=["tables", "models"])
def test_crosstalk_in_the_simulator_is_a_higher_pressure(more):
    lag = tuple(effect_classes()[name](time_constant=0.01) for name in more)
    weight = Gravity(mass_scale=1.0)
    leaking = held(Model(effects=(weight, *lag, LEAK(share=0.25))))
    tight = held(Model(effects=(weight, *lag)))
    found = settled_tips(leaking, [20e3, 5e3, 10e3, 10e3])
    expected = settled_tips(tight, [20e3, 5e3, 15e3, 10e3])
    for name, place in found.items():
        assert place == pytest.approx(expected[name], abs=1e-7)
