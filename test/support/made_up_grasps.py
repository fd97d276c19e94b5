"""A file of stored grasps that nobody searched: two cylinders in the palm."""

from dataclasses import replace

from thesis.chapter_8.dexterity.patterns import (
    Pattern,
    Patterns,
    StoredGrasp,
    Times,
    load_patterns,
    write_patterns,
)
from thesis.chapter_8.dexterity.strategy_file import write_strategies

CYLINDER = Pattern(
    "cylinder_45",
    {"a": 0.0, "b": 0.0, "c": 1.5e-5, "d": 2.2e-5},
    {"a": 8.2e-5, "b": 2.6e-5, "c": 4.5e-5, "d": 4.5e-5},
    False,
    (0.033, 0.0, 0.105),
    (0.7071067811865476, 0.0, 0.0, 0.7071067811865476),
)
THIN = replace(
    CYLINDER,
    object="cylinder_25",
    final={**CYLINDER.final, "a": 9.0e-5},
    palm_first=True,
    position=(0.025, 0.0, 0.110),
)
TIMES = Times(pre=0.2, settle=0.1, grasp=0.5, release=0.2)
TRIALS = ({"held": True, "typed": True},) * 3


def write_made_up(path, hand="rbo_hand_2", segments=8):
    """Write patterns of the types 2 and 3, held in three of three trials, and 5, which is not; the
    file's path.
    """
    grasps = {
        2: StoredGrasp(THIN, 2, "9", 0.7, 3, 3, 0.1, TRIALS),
        3: StoredGrasp(CYLINDER, 1, "7", 0.5, 3, 3, 2.0, TRIALS),
        5: StoredGrasp(replace(THIN, object="tool_handle"), 1, "7", 9.0, 2, 0, 0.1, TRIALS),
    }
    write_patterns(Patterns(hand, 0.005, segments, TIMES, grasps), path)
    return path


def write_made_up_strategies(folder):
    """Write the same as strategies; their paths by the number of the type."""
    paths = write_strategies(load_patterns(write_made_up(folder / "patterns.yaml")), folder)
    return {int(path.stem): path for path in paths}
