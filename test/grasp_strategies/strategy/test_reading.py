import math

import pytest

from grasp_strategies.strategy import Condition, load_strategy, strategy_names
from grasp_strategies.strategy.tried_with import TriedWith


def test_every_shipped_strategy_can_be_read():
    for name in strategy_names():
        assert load_strategy(name).name == name


def test_the_surface_constrained_grasp_asks_for_what_the_thesis_calls_success():
    strategy = load_strategy("surface_constrained")
    assert strategy.hand == "rbo_hand_2"
    assert strategy.success.lift_height == 0.100
    assert strategy.success.hold_time == 1.0
    by_name = {phase.name: phase for phase in strategy.phases}
    assert by_name["lift"].wrist.position[2] > strategy.success.lift_height
    assert by_name["hold"].duration > strategy.success.hold_time
    assert set(by_name["close"].air_mass) == {"a", "b", "c", "d"}


def test_an_unknown_name_lists_the_strategies_there_are():
    with pytest.raises(ValueError, match="expected one of .*surface_constrained.*got 'pinch'"):
        load_strategy("pinch")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.yaml: expected a readable file"):
        load_strategy(tmp_path / "none.yaml")


WRIST = "wrist: {frame: wrist_level, position: [0, 0, 0.12]}"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("softhand-strategy/1", "softhand-strategy/9", ["format", "softhand-strategy/1"]),
        ("frame: object", "frame: table", ["phases[0].wrist.frame", "environment", "table"]),
        ("[0, 0, 0.1]", "[0, 0]", ["phases[0].wrist.position", "3 numbers", "[0, 0]"]),
        ("[0, 0, 0.1]", "[0, 0, .nan]", ["phases[0].wrist.position", "number", "nan"]),
        ("a: 4.0e-5", "a: -1", ["phases[1].air_mass.a", "0", "-1"]),
        ("a: 4.0e-5", "a: much", ["phases[1].air_mass.a", "number", "much"]),
        ("duration: 0.5", "duration: 0", ["phases[0].duration", "above 0", "0"]),
        ("duration: 0.5", "durations: 0.5", ["phases[0]", "duration", "durations"]),
        ("    duration: 0.5\n", "", ["phases[0]", "`speed` or `duration`"]),
        ("duration: 0.5", "duration: 0.5\n    speed: 1", ["phases[0]", "`speed` or `duration`"]),
        (f"    {WRIST}\n", "", ["phases[2].speed", "no speed", "0.2"]),
        ("    time_out: 2.0\n", "", ["phases[1]", "time_out"]),
        ("until: {air_mass_error: {below: 1.0e-6}}", "duration: 1", ["phases[1]", "`until`"]),
        ("air_mass_error: {below", "force: {below", ["phases[1].until", "contact_force", "force"]),
        ("{below: 1.0e-6}", "{under: 1}", ["phases[1].until.air_mass_error", "above", "under"]),
        ("{below: 1.0e-6}", "{below: 1, above: 0}", ["phases[1].until.air_mass_error", "either"]),
        ("name: hold", "name: lift", ["phases", "different names"]),
        ("name: hold", "name: keep", ["hold_phase", "keep"]),
        ("hand: rbo_hand_2\n", "", ["hand"]),
        ("phases:", "objects: ball\nphases:", ["objects", "list", "ball"]),
        ("phases:", "objects: [3]\nphases:", ["objects[0]", "text", "3"]),
        (
            "phases:",
            "segments: 16\nphases:",
            ["segments", "1 to 15", "16"],
        ),
        ("phases:", "scene: []\nphases:", ["scene", "text"]),
        (
            "phases:",
            "place: edge\nphases:",
            ["place", "corner or", "edge"],
        ),
        ("phases:", "wall_inclination: 0\nphases:", ["inclination", "5 to 120 deg"]),
        ("phases:", "success: {max_turn: 20}\nphases:", ["success.max_turn", "3.142 rad", "20"]),
        (
            "duration: 0.5",
            "duration: 0.5\n    hold_object: {position: [0, 0]}",
            ["phases[0].hold_object.position", "3 numbers"],
        ),
        (
            "duration: 0.5",
            "duration: 0.5\n    hold_object: {position: [0, 0, 0], orientation: [1, 1, 0, 0]}",
            ["phases[0].hold_object.orientation", "a unit quaternion", "[1, 1, 0, 0]"],
        ),
        (
            "duration: 0.5",
            "duration: 0.5\n    release_object: 0",
            ["phases[0].release_object", "above 0", "0"],
        ),
        ("phases:", "success: {max_turn: 0}\nphases:", ["success.max_turn", "above 0", "0"]),
    ],
)
def test_an_error_names_file_key_expected_and_got(write_strategy, old, new, expected):
    path = write_strategy((old, new))
    with pytest.raises(ValueError) as error:
        load_strategy(path)
    for part in [str(path), *expected]:
        assert part in str(error.value)


def test_a_file_that_is_no_yaml_is_refused_in_one_line(write_strategy):
    path = write_strategy(("phases:", "phases: ["))
    with pytest.raises(ValueError, match="expected YAML") as error:
        load_strategy(path)
    assert "\n" not in str(error.value)


def test_conditions_hold_on_their_side_only():
    above, below = Condition("height", True, 0.1), Condition("height", False, 0.1)
    assert (above.holds(0.2), above.holds(0.05)) == (True, False)
    assert (below.holds(0.2), below.holds(0.05)) == (False, True)
    assert str(above) == "height above 0.1 m"


def test_an_object_may_turn_in_the_hand_by_20_deg_unless_the_strategy_says_otherwise(make_strategy):
    assert make_strategy().success.max_turn == pytest.approx(math.pi / 9)
    asked = make_strategy(("phases:", "success: {max_turn: 0.5}\nphases:"))
    assert asked.success.max_turn == 0.5


def test_a_strategy_may_name_the_objects_that_it_lifts(make_strategy):
    assert make_strategy().objects == ()
    fitting = make_strategy(("phases:", "objects: [ball, tube]\nphases:"))
    assert fitting.objects == ("ball", "tube")
    assert "cylinder" in load_strategy("surface_constrained").objects


def test_a_strategy_says_in_which_scene_and_with_which_hand_s_physics_it_was_tried(make_strategy):
    usual = make_strategy()
    assert usual.tried_with == TriedWith("table", None, "", 5, (0.0, 0.0), ())
    world = "scene: wall\nwall_inclination: 60\nmodel: rbo_hand_1\nsegments: 10\nplace: [0.05, 0]"
    asked = make_strategy(("phases:", f"{world}\nphases:"))
    assert asked.tried_with == TriedWith("wall", 60.0, "rbo_hand_1", 10, (0.05, 0.0))
    asked = make_strategy(("phases:", "place: corner\nupright: [tube]\nphases:"))
    assert (asked.tried_with.place, asked.tried_with.upright) == (None, ("tube",))
    asked = make_strategy(("phases:", "step: 0.001\nfinger_contact: true\nphases:"))
    assert (asked.tried_with.step, asked.tried_with.finger_contact) == (0.001, True)


def test_options_are_those_of_the_phases(make_strategy):
    assert make_strategy().options == {"lower_and_release"}


def test_a_hand_of_ones_own_is_looked_for_beside_the_strategy(write_strategy):
    path = write_strategy(("hand: rbo_hand_2", "hand: mine/gripper.yaml"))
    hand = path.parent / "mine" / "gripper.yaml"
    with pytest.raises(ValueError, match=r"hand: expected the name of a hand or the path .* got"):
        load_strategy(path)
    hand.parent.mkdir()
    hand.touch()
    assert load_strategy(path).hand == str(hand)
