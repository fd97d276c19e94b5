"""The lab's story of a hand: what it plays, what it hides, and when the lab was right."""

from dataclasses import replace

import numpy as np
import pytest

from grasp_strategies.strategy import load_strategy
from model_lab.bench.layouts import hand_pose_set
from model_lab.bench.pose_strategy import POSE_HOLD
from model_lab.measurements.save import write_set
from softhand_bringup.lab_story.free_poses import POSE_PEAK, free_poses
from softhand_bringup.lab_story.hand_story import HIDDEN_SIZES, distance, hidden_effect, is_right
from softhand_model.hand.hand import load_hand


@pytest.mark.parametrize("name", ["rbo_hand_2", "rbo_hand_1"])
def test_poses_are_a_strategy_that_stays_far_below_the_limits_and_empties_between_runs(
    tmp_path, name
):
    hand = load_hand(name)
    path = tmp_path / "poses.yaml"
    path.write_text(free_poses(hand, name))
    phases = load_strategy(str(path)).phases
    limits = dict(zip(hand.channels, hand.max_pressures(), strict=True))
    pressed = [phase.pressure for phase in phases if phase.pressure]
    assert all(p[channel] <= POSE_PEAK * limits[channel] + 1.0 for p in pressed for channel in p)
    for channel in limits:  # each acts alone in some pose
        assert any(p[channel] > 0 and sum(map(bool, p.values())) == 1 for p in pressed)
    turns = [k for k, phase in enumerate(phases) if phase.name.endswith("_turn")]
    assert len(turns) == 6
    assert all(not any(phases[k - 1].pressure.values()) for k in turns)
    held = [phase for phase in phases if phase.name.endswith("_held")]
    assert held and all(phase.duration == POSE_HOLD for phase in held)


@pytest.mark.parametrize("kind", HIDDEN_SIZES)
def test_place_and_size_of_what_is_hidden_follow_the_seed(kind):
    hand = load_hand("rbo_hand_2")
    drawn = [hidden_effect(hand, kind, np.random.default_rng(seed)) for seed in (3, 3, *range(9))]
    assert (drawn[0].name, drawn[0].values) == (drawn[1].name, drawn[1].values)
    assert len({effect.name for effect in drawn}) > 2


def test_right_is_the_effect_at_its_place_and_nothing_else():
    hidden = hidden_effect(load_hand("rbo_hand_2"), "crosstalk", np.random.default_rng(0))
    named = {"name": "crosstalk", "where": dict(hidden.where)}
    turned = {
        "name": "crosstalk",
        "where": dict(zip(("to", "from"), hidden.where.values(), strict=True)),
    }
    assert is_right(hidden, {"effects": [named]})
    assert not is_right(hidden, {"effects": [turned]})
    assert not is_right(hidden, {"effects": [named, {"name": "palm_stiffness"}]})
    assert not is_right(hidden, {"effects": []})


def test_distance_of_two_recordings_is_that_of_their_markers(tmp_path):
    one = hand_pose_set()
    runs = [
        replace(run, columns={k: v + 3e-3 * k.endswith(".x") for k, v in run.columns.items()})
        for run in one.runs
    ]
    write_set(one, tmp_path / "one")
    write_set(replace(one, runs=tuple(runs)), tmp_path / "other")
    assert distance(tmp_path / "one", tmp_path / "other") == pytest.approx(3e-3 / np.sqrt(3.0))

    shorter = replace(one, runs=tuple(runs[3:]))  # a pose of another attitude is another pose
    write_set(shorter, tmp_path / "shorter")
    assert distance(tmp_path / "shorter", tmp_path / "one") == pytest.approx(3e-3 / np.sqrt(3.0))
    turned = replace(one, runs=tuple(replace(run, wrist_rpy=(0.5, 0.5, 0.0)) for run in one.runs))
    write_set(turned, tmp_path / "turned")
    with pytest.raises(ValueError, match="expected poses as in"):
        distance(tmp_path / "one", tmp_path / "turned")
