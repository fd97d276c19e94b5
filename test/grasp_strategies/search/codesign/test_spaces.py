"""Hands and motions from numbers: the shipped ones, what changes, and what is refused."""

import numpy as np
import pytest

from grasp_strategies.search.codesign.hand_space import (
    HAND_SPACE,
    InfeasibleHand,
    hand_text,
    shipped,
)
from grasp_strategies.search.codesign.motion_space import MOTION_SPACE, strategy_text
from grasp_strategies.strategy import load_strategy
from softhand_model.hand.hand import load_hand


def built(tmp_path, **values):
    path = tmp_path / "hand.yaml"
    path.write_text(hand_text(values), encoding="utf-8")
    return load_hand(path)


def test_the_shipped_numbers_give_the_shipped_hand(tmp_path):
    hand, known = built(tmp_path), load_hand("rbo_hand_2")
    assert (hand.channels, hand.tips) == (known.channels, known.tips)
    assert hand.mass == pytest.approx(known.mass)
    x = np.linspace(0.0, 0.09, 9)
    for chain, other in zip(hand.chains, known.chains, strict=True):
        assert np.allclose(chain.mount.position, other.mount.position)
        assert np.allclose(chain.mount.rpy, other.mount.rpy)
        for one, two in zip(chain.actuators.values(), other.actuators.values(), strict=True):
            assert np.allclose(one.sides(x), two.sides(x))
            assert np.allclose(one.stiffness(x), two.stiffness(x))
            assert one.max_pressure == pytest.approx(two.max_pressure)


def test_numbers_change_what_they_name(tmp_path):
    wanted = {"finger_wall": 0.0025, "finger_height": 0.022, "finger_length": 0.1}
    wanted |= {"taper_exponent": 0.25, "spread": 0.027, "thumb_angle": 1.0, "palm_walls": 1.4}
    hand = built(tmp_path, **wanted)
    index, little = hand.chain("index"), hand.chain("little")
    finger = index.actuators["index"]
    assert finger.length == pytest.approx(0.1)
    assert [float(size) for size in finger.sides(0.0)] == pytest.approx(
        [0.022, 0.022] + [0.0025] * 2
    )
    assert float(finger.height(0.1)) == pytest.approx(0.022 * 0.075**0.25)
    assert index.mount.position[1] - little.mount.position[1] == pytest.approx(3 * 0.027)
    assert hand.chain("thumb").mount.rpy[2] == pytest.approx(-1.0)
    palm = list(hand.chain("palm").actuators.values())
    assert float(palm[1].wall(0.0) / palm[0].wall(0.0)) == pytest.approx(1.4)
    assert hand.mass > load_hand("rbo_hand_2").mass


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"finger_height": 0.025, "spread": 0.02}, "fingers 25 mm wide overlap at 20 mm"),
        ({"finger_wall": 0.0035, "finger_height": 0.016, "taper_exponent": 0.5}, "at its tip"),
    ],
)
def test_what_cannot_be_built_is_refused_with_its_reason(values, reason):
    with pytest.raises(InfeasibleHand, match=reason):
        hand_text(values)


def test_a_number_outside_of_its_range_is_refused():
    with pytest.raises(ValueError, match="finger_wall: expected 0.0015 to 0.0035, got 0.009"):
        hand_text({"finger_wall": 0.009})
    with pytest.raises(ValueError, match="ramp: expected 0.4 to 2.4, got 9"):
        strategy_text({"ramp": 9.0}, "rbo_hand_2")


def test_random_numbers_give_hands_that_load_or_a_reason(tmp_path):
    random, good = np.random.default_rng(3), 0
    for _ in range(20):
        values = {k: random.uniform(one.low, one.high) for k, one in HAND_SPACE.items()}
        try:
            good += len(built(tmp_path, **values).chains) == 6
        except InfeasibleHand as reason:
            assert str(reason)
    assert good >= 5


def test_the_shipped_motion_is_the_shipped_strategy_but_for_the_heading(tmp_path):
    path = tmp_path / "motion.yaml"
    path.write_text(strategy_text({}, "rbo_hand_2"), encoding="utf-8")
    found, known = load_strategy(path), load_strategy("rbo_hand_2_lying_cylinder")
    assert found.phases == known.phases
    assert found.success == known.success
    assert found.object_rpy is None


def test_numbers_of_the_motion_reach_their_phases(tmp_path):
    path = tmp_path / "motion.yaml"
    values = {"approach_x": -0.02, "approach_yaw": 0.1, "touch_force": 3.0, "mass_a": 8e-5}
    path.write_text(strategy_text(values | {"order": 0.0, "ramp": 2.0}, "rbo_hand_2"))
    phases = {phase.name: phase for phase in load_strategy(path).phases}
    assert phases["approach"].wrist.position[0] == -0.02
    assert phases["approach"].wrist.rpy[2] == 0.1
    assert phases["touch"].until[0].threshold == 3.0
    assert phases["close"].air_mass["a"] == 8e-5 and phases["close"].air_ramp == 2.0
    assert set(phases["thumb_first"].air_mass.values()) == {0.0}


def test_the_shipped_numbers_lie_within_their_ranges():
    for space in (HAND_SPACE, MOTION_SPACE):
        for name, value in shipped(space).items():
            assert space[name].low <= value <= space[name].high
