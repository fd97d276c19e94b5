"""Hands by seven numbers: RBO Hand 2 among them, castable, refused where they cannot be built."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_design.mould.report import make_mould
from softhand_model.hand.hand import load_hand
from thesis.co_design import hands

HEAVY = {"finger_wall": 0.0035, "finger_height": 0.026, "finger_length": 0.11, "spread": 0.028}


def made(values, tmp_path):
    path = tmp_path / "hand.yaml"
    path.write_text(hands.hand_text(hands.SHIPPED | values), encoding="utf-8")
    return load_hand(path)


def nameless(hand):
    chains = [
        replace(chain, actuators={k: replace(part, name="") for k, part in chain.actuators.items()})
        for chain in hand.chains
    ]
    return replace(hand, name="", chains=tuple(chains))


def test_the_shipped_numbers_give_the_shipped_hand(tmp_path):
    ours, shipped = nameless(made({}, tmp_path)), nameless(load_hand("rbo_hand_2"))
    x = np.linspace(0.0, 0.09, 9)
    for mine, theirs in zip(ours.chains, shipped.chains, strict=True):
        assert mine.mount.position == pytest.approx(theirs.mount.position)
        assert mine.mount.rpy == pytest.approx(theirs.mount.rpy)
        for name, part in theirs.actuators.items():
            same = mine.actuators[name]
            assert same.length == pytest.approx(part.length)
            assert same.max_pressure == part.max_pressure
            assert same.mass == pytest.approx(part.mass)
            assert same.chamber_volume() == pytest.approx(part.chamber_volume())
            assert same.stiffness(x) == pytest.approx(part.stiffness(x))
    assert ours.mass == pytest.approx(shipped.mass)
    assert ours.plate == shipped.plate and ours.sheet == shipped.sheet


def test_each_number_changes_what_it_says(tmp_path):
    hand = made({"thumb_angle": 1.0, "spread": 0.027, "finger_length": 0.1}, tmp_path)
    assert hand.chain("thumb").mount.rpy[2] == -1.0
    places = [hand.chain(name).mount.position[1] for name in hands.FINGERS]
    assert np.diff(places) == pytest.approx([0.027] * 3)
    assert hand.chain("index").actuators["index"].length == 0.1
    stiff = made({"palm_wall_ratio": 2.0}, tmp_path).chain("palm").actuators["palm_outer"]
    assert float(np.asarray(stiff.stiffness(0.0))) > 1.1 * float(
        load_hand("rbo_hand_2").chain("palm").actuators["palm_outer"].stiffness(0.0)
    )


def test_thicker_walls_bear_more_pressure(tmp_path):
    thick, thin = (
        made({"finger_wall": wall}, tmp_path).max_pressures()[0] for wall in (0.003, 0.0015)
    )
    assert thick > 1.4 * thin


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"finger_height": 0.025, "spread": 0.022}, "side by side"),
        ({"finger_wall": 0.0035, "finger_height": 0.016, "taper": 0.5}, "below half the height"),
        (HEAVY | {"palm_wall_ratio": 2.2, "taper": 1 / 6}, "mass"),
    ],
)
def test_what_cannot_be_built_is_refused_with_the_reason(values, words):
    assert any(words in reason for reason in hands.broken(hands.SHIPPED | values))


def test_the_shipped_hand_is_not_refused():
    assert hands.broken(hands.SHIPPED) == []


def test_a_hand_that_is_not_refused_can_be_cast():
    random = np.random.default_rng(4)
    drawn = (
        {v.name: float(random.uniform(v.low, v.high)) for v in hands.VARIABLES} for _ in range(99)
    )
    values = next(values for values in drawn if not hands.broken(values))
    for actuator in hands.kinds(values).values():
        assert make_mould(actuator).failed == []
