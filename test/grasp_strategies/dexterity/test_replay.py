"""Replays of stored grasps: what the strategy does by what is stored, and what is refused."""

import pytest
from made_up_grasps import CYLINDER, TIMES, write_made_up

from grasp_strategies.dexterity.patterns import load_patterns
from grasp_strategies.dexterity.posture import first_channels
from grasp_strategies.dexterity.replay import FILE, load_replay, words
from softhand_model.hand.hand import load_hand


@pytest.fixture
def patterns(tmp_path):
    return write_made_up(tmp_path / "patterns.yaml")


def named(strategy):
    return {phase.name: phase for phase in strategy.phases}


def test_a_replay_takes_masses_pose_and_times_from_what_is_stored(patterns):
    strategy = load_replay(3, patterns)
    phases = named(strategy)
    assert strategy.name == "feix_3"
    assert "medium wrap" in strategy.description
    assert strategy.objects == ("cylinder_45",)
    assert (strategy.hand, strategy.tried_with.scene, strategy.tried_with.segments) == (
        "rbo_hand_2",
        "held",
        8,
    )
    assert phases["pre_grasp"].air_mass == CYLINDER.pre
    assert phases["hold_out"].held_out.position == CYLINDER.position
    assert phases["grasp"].air_mass == CYLINDER.final
    assert phases["grasp"].air_ramp == TIMES.grasp
    assert phases["release"].release == TIMES.release
    assert "grasp_by_palm" not in phases


def test_a_grasp_whose_palm_closes_first_fills_its_channels_before_those_of_the_fingers(patterns):
    phases = named(load_replay(2, patterns))
    assert "grasp" not in phases
    assert phases["grasp_by_palm"].air_mass.keys() == {"c", "d"}
    assert phases["grasp_by_fingers"].air_mass.keys() == {"a", "b"}
    assert list(phases).index("grasp_by_palm") + 1 == list(phases).index("grasp_by_fingers")


def test_the_channels_that_are_filled_first_are_those_of_the_postures(patterns):
    hand = load_hand("rbo_hand_2")
    first = [c for c, is_first in zip(hand.channels, first_channels(hand), strict=True) if is_first]
    assert sorted(words(2, load_patterns(patterns))["final_of_palm"]) == sorted(first)


def test_a_type_without_a_stored_grasp_is_refused_with_those_that_there_are(patterns):
    with pytest.raises(ValueError, match=r"grasp_type: expected one that is stored .* \(2, 3, 5\)"):
        load_replay(6, patterns)


def test_where_nothing_is_stored_the_refusal_says_what_stores_it(tmp_path):
    with pytest.raises(ValueError, match="no grasps are stored: .*python -m thesis run feix"):
        load_replay(5, tmp_path / "none.yaml")


def test_a_name_that_means_nothing_is_refused_with_those_that_do(patterns, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(FILE.read_text().replace("$final}", "$last}").replace("$final\n", "$last\n"))
    with pytest.raises(ValueError, match=r"own.yaml: expected one of \$type, .*, got \$last"):
        load_replay(3, patterns, own)
