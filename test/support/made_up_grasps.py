"""A file of stored grasps that nobody searched: a cylinder in the palm, a ball of another type."""

from dataclasses import replace

from grasp_strategies.dexterity.patterns import (
    Pattern,
    Patterns,
    StoredGrasp,
    Times,
    write_patterns,
)

CYLINDER = Pattern(
    "cylinder_45",
    {"a": 0.0, "b": 0.0, "c": 2e-5, "d": 3e-5},
    {"a": 1.1e-4, "b": 3.5e-5, "c": 6e-5, "d": 6e-5},
    False,
    (0.040, 0.0, 0.110),
    (0.7071067811865476, 0.0, 0.0, 0.7071067811865476),
)
BALL = replace(CYLINDER, object="ball_40", palm_first=True)


def write_made_up(path, hand="rbo_hand_2", segments=8):
    """Write patterns of the types 3 and 14; the file's path."""
    grasps = {
        3: StoredGrasp(CYLINDER, 1, "7", 0.5, 3, 3, 2.0, ()),
        14: StoredGrasp(BALL, 2, "9", 0.7, 0, 0, 0.1, ()),
    }
    write_patterns(Patterns(hand, 0.005, segments, Times(), grasps), path)
    return path
