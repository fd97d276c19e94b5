"""Stored grasps as strategy files: what the phases do by what is stored."""

import pytest
from made_up_grasps import CYLINDER, TIMES, write_made_up_strategies

from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.reading import STRATEGY_FOLDER, TAXONOMY_FOLDER
from softhand_model.hand.hand import load_hand
from thesis.chapter_8.dexterity.patterns import load_patterns
from thesis.chapter_8.dexterity.posture import first_channels
from thesis.chapter_8.dexterity.strategy_file import strategy_text


@pytest.fixture
def written(tmp_path):
    return write_made_up_strategies(tmp_path)


def named(strategy):
    return {phase.name: phase for phase in strategy.phases}


def test_the_shipped_strategies_are_those_of_the_stored_patterns():
    patterns = load_patterns()
    shipped = {
        int(path.stem): path.read_text()
        for path in (STRATEGY_FOLDER / TAXONOMY_FOLDER).glob("*.yaml")
    }
    assert shipped == {number: strategy_text(number, patterns) for number in patterns.grasps}


def test_a_strategy_takes_masses_pose_and_times_from_what_is_stored(written):
    strategy = load_strategy(written[3])
    phases, tried = named(strategy), strategy.tried_with
    assert strategy.name == "feix_3"
    assert "medium wrap" in strategy.description
    assert strategy.objects == ("cylinder_45",)
    assert (strategy.hand, tried.scene, tried.segments) == ("rbo_hand_2", "held", 8)
    assert (tried.step, tried.finger_contact) == (0.005, True)
    assert phases["pre_grasp"].air_mass == CYLINDER.pre
    assert phases["hold_out"].held_out.position == CYLINDER.position
    assert phases["grasp"].air_mass == CYLINDER.final
    assert phases["grasp"].air_ramp == TIMES.grasp
    assert phases["release"].release == TIMES.release
    assert "grasp_by_palm" not in phases


def test_a_grasp_whose_palm_closes_first_fills_its_channels_before_those_of_the_fingers(written):
    phases = named(load_strategy(written[2]))
    assert "grasp" not in phases
    hand = load_hand("rbo_hand_2")
    first = {c for c, is_first in zip(hand.channels, first_channels(hand), strict=True) if is_first}
    assert phases["grasp_by_palm"].air_mass.keys() == first == {"c", "d"}
    assert phases["grasp_by_fingers"].air_mass.keys() == {"a", "b"}
    assert list(phases).index("grasp_by_palm") + 1 == list(phases).index("grasp_by_fingers")
