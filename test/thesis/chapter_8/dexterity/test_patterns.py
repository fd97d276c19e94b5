"""The file of stored grasp patterns."""

from dataclasses import replace

import pytest

from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.feix_trials import HandSettings, fresh_trials
from thesis.chapter_8.dexterity.patterns import (
    Pattern,
    Patterns,
    StoredGrasp,
    Times,
    load_patterns,
    write_patterns,
)

PATTERN = Pattern(
    "cylinder_45",
    {"a": 0.0, "b": 1e-5 / 3.0},
    {"a": 7.7e-5, "b": 2e-5 / 7.0},
    True,
    (0.1, 1.0 / 3.0, -0.0),
    (0.0, 0.6, 0.0, 0.8),
)
TRIAL = {"held": True, "typed": False, "markers": {"thumb": [0.1, 0.2, 1.0 / 3.0]}}
STORED = StoredGrasp(PATTERN, 3003, "four_channels_3/0012", 1.5, 1, 0, 6.25, (TRIAL,))
PATTERNS = Patterns("rbo_hand_2", 0.005, 6, Times(), {3: STORED, 31: replace(STORED, held=0)})


def test_a_file_comes_back_bit_for_bit(tmp_path):
    write_patterns(PATTERNS, tmp_path / "patterns.yaml")
    assert load_patterns(tmp_path / "patterns.yaml") == PATTERNS
    first = (tmp_path / "patterns.yaml").read_bytes()
    write_patterns(load_patterns(tmp_path / "patterns.yaml"), tmp_path / "patterns.yaml")
    assert (tmp_path / "patterns.yaml").read_bytes() == first


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("palm_first: true", "palm_first: maybe", "grasps.3.palm_first: expected"),
        ("    object: cylinder_45\n", "", "grasps.3: .*object"),
        ("segments: 6", "segments: 0", "segments: expected"),
        ("softhand-grasp-patterns/1", "softhand-grasp-patterns/2", "format"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_the_place(tmp_path, old, new, named):
    path = tmp_path / "patterns.yaml"
    write_patterns(PATTERNS, path)
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ValueError, match=named):
        load_patterns(path)


def test_a_pattern_of_every_type_is_shipped_with_the_object_of_its_type():
    shipped, types = load_patterns().grasps, grasp_types()
    assert sorted(shipped) == sorted(types)
    for number, stored in shipped.items():
        assert stored.pattern.object == types[number].object
        assert len(stored.trials) == 3
        assert stored.held == sum(trial["held"] for trial in stored.trials)


def test_the_shipped_medium_wrap_holds_a_cylinder_by_the_right_parts():
    stored = load_patterns()
    settings = HandSettings("cylinder_45", step=stored.step, segments=stored.segments)
    pattern = stored.grasps[3].pattern
    (trial,) = fresh_trials("shipped", 3, pattern, stored.times, settings, 3000, 1)
    found = replace(trial, robust=False).result()
    assert found["held"] and found["typed"], (found["held_reason"], found["typed_reason"])
