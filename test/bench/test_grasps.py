"""The bench of grasps without its long runs."""

import pytest

from bench.grasps.steps import COUNT, SIDES, at_step, beside, scattered
from bench.grasps.table_grasps import OBJECTS, strategy_for


def test_every_object_on_the_table_has_a_strategy_of_the_hand():
    assert [strategy_for(name) for name in OBJECTS] == [
        "surface_constrained",
        "rbo_hand_2_lying_cylinder",
        "rbo_hand_2_lying_cylinder",
        "rbo_hand_2_ball",
    ]
    with pytest.raises(ValueError, match="tissue: expected a strategy of rbo_hand_2"):
        strategy_for("tissue")


def test_scattered_trials_are_of_both_maps_and_drawn_by_the_seed():
    lines = scattered(3)
    assert len({line.key for line in lines}) == COUNT
    assert {line.key.split("/")[0] for line in lines} == {"push_map", "surface_map"}
    assert lines == scattered(3) != scattered(4)


def test_a_trial_beside_another_differs_in_its_place_alone():
    line = scattered(0, 1)[0]
    moved = beside(line, SIDES[2])
    assert moved.settings == line.settings and moved.key != line.key
    shift = [b - a for a, b in zip(line.placement.offset, moved.placement.offset, strict=True)]
    assert shift == pytest.approx([0.0, 0.003])
    assert at_step(line, 0.001).placement == line.placement
