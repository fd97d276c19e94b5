import itertools

import numpy as np
import pytest

from softhand_trials.sweep import load_plan

PLAN = """
format: softhand-sweep/1
name: push_map
strategy: surface_constrained
objects:
  marker:
  bottle: {place: [0.03, -0.03], object_rpy: [0, 0, 0]}
step: 0.005
segments: 10
grid: {x: [-0.06, 0.06, 0.01], y: [-0.01, 0.01, 0.01]}
replicates: 3
nominal: true
seed: 5
"""


@pytest.fixture
def read(tmp_path):
    def write_and_read(*replacements):
        text = PLAN
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "plan.yaml"
        path.write_text(text)
        return load_plan(path)

    return write_and_read


def by_key(plan):
    return {line.key: line for line in plan.tasks()}


def test_a_plan_stands_for_every_object_cell_and_replicate_once(read):
    lines = by_key(read())
    assert len(lines) == 2 * 13 * 3 * 4
    line = lines["push_map/marker/10,-10/1"]
    assert (line.object, line.cell, line.replicate) == ("marker", (0.01, -0.01), 1)
    assert line.settings.segments == 10 and line.settings.early_end


def test_a_cell_displaces_the_hand_so_the_object_lies_at_minus_that(read):
    lines = by_key(read())
    assert lines["push_map/marker/20,-10/0"].placement.offset == (-0.02, 0.01)
    assert lines["push_map/bottle/20,-10/0"].placement.offset == pytest.approx((0.01, -0.02))
    moved = by_key(read(("seed: 5", "moves: object")))
    assert moved["push_map/marker/20,-10/0"].placement.offset == (0.02, -0.01)


def test_an_object_has_settings_of_its_own(read):
    lines = by_key(read())
    assert lines["push_map/bottle/0,0/1"].settings.object_rpy == (0, 0, 0)
    assert lines["push_map/marker/0,0/1"].settings.object_rpy is None


def test_replicates_are_jittered_within_their_bounds_and_fill_them(read):
    lines = read(("replicates: 3", "replicates: 40"), ("nominal: true", "nominal: false")).tasks()
    place = [np.add(ln.placement.offset, ln.cell) for ln in lines if ln.object == "marker"]
    drawn = np.array(
        [(ln.placement.mass_scale, ln.placement.yaw, ln.placement.friction_scale) for ln in lines]
    )
    drawn = (drawn - (1, 0, 1)) / (0.05, 0.0349, 0.15)
    for values in (drawn, np.array(place) / 0.001):
        assert np.abs(values).max() <= 1 + 1e-9
        assert values.std(axis=0) == pytest.approx(1 / np.sqrt(3), rel=0.06)
    moduli = {line.settings.modulus_scale for line in lines}
    assert len(moduli) == 40 and all(0.95 <= scale <= 1.05 for scale in moduli)


def test_trials_of_other_settings_and_smaller_plans_see_the_same_jitter(read):
    whole = by_key(read())
    part = by_key(
        read(
            ("-0.06, 0.06", "-0.02, 0.02"),
            ("replicates: 3", "replicates: 2"),
            ("step: 0.005", "step: 0.002"),
            ("  bottle: {place: [0.03, -0.03], object_rpy: [0, 0, 0]}\n", ""),
        )
    )
    assert set(part) < set(whole)
    assert all(line.placement == whole[key].placement for key, line in part.items())
    other = by_key(read(("seed: 5", "seed: 6")))
    assert other["push_map/marker/0,0/1"].placement != whole["push_map/marker/0,0/1"].placement


def test_what_varies_stands_in_the_key_and_sees_the_same_places(read):
    lines = by_key(read(("seed: 5", "seed: 5\nvary: {air_scale: [0, 1], without: [[], [touch]]}")))
    assert len(lines) == 4 * 2 * 13 * 3 * 4
    empty = lines["push_map/marker/air_scale=0/without=touch/0,0/1"]
    usual = lines["push_map/marker/air_scale=1/without=/0,0/1"]
    assert (empty.settings.air_scale, empty.settings.without) == (0, ("touch",))
    assert usual.settings.air_scale == 1 and empty.placement == usual.placement


def test_trials_of_one_hand_and_scene_follow_each_other(read):
    settings = [line.settings for line in read().tasks()]
    changes = sum(a != b for a, b in itertools.pairwise(settings))
    assert changes + 1 == len(set(settings)) == 2 * 4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("replicates: 3", "replicates: -1", "replicates: expected a whole number from 0"),
        ("seed: 5", "cells: [[0, 0]]", "expected either `cells` or `grid`, got both"),
        ("seed: 5", "sede: 5", "sede"),
        ("0.06, 0.01]", "0.06, 0]", "grid.x: expected first, last and pitch"),
        ("seed: 5", "jitter: {mass: 2}", "jitter.mass: expected a number from 0 to 0.9"),
        ("seed: 5", "moves: table", "moves: expected one of hand, object"),
        ("  marker:\n", "  marker: {colour: red}\n", "colour"),
        ("seed: 5", "segments: 2.5", "segments"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_with_its_key(read, old, new, message):
    with pytest.raises(ValueError, match=r"plan\.yaml") as refused:
        read(*([(old, new)] if "segments" not in new else [("segments: 10", new)]))
    assert message in str(refused.value)
