"""Parts of the demo that need no nodes: the verdict, the run's folder, the variation by seed."""

import json
import re
from pathlib import Path

import pytest
from made_up_grasps import write_made_up_strategies

from grasp_strategies.strategy import STRATEGY_FOLDER, load_strategy, strategy_names
from grasp_strategies.strategy.fitting import fitting_strategies
from grasp_strategies.strategy.tried_with import TriedWith
from pneuflex_sim.scene.objects import load_object
from softhand_bringup.grasp_verdict import verdict_from
from softhand_bringup.processes import suite
from softhand_bringup.processes.run_folder import make_run_folder
from softhand_bringup.ros import demo as command
from softhand_bringup.ros.demo import main

VALUES = {"outcome": "gripped", "lift_height": "0.112", "slip": "0.0004", "duration": "9.5"}


def test_the_line_says_what_a_reader_needs(tmp_path):
    line = verdict_from(VALUES, True, "held", 1.25, 3).line(tmp_path)
    assert line.startswith(
        "gripped: lifted 112 mm, slip 0.40 mm in the hold, real-time factor 1.25"
    )
    for name in ("bag", "grasp.png", "frames.png"):
        assert f"{tmp_path}/{name}" in line
    assert "\n" not in line


def test_the_result_file_is_plain_json_in_si(tmp_path):
    verdict_from(VALUES, True, "held", 1.25, 3).write(tmp_path / "result.json")
    result = json.loads((tmp_path / "result.json").read_text(), parse_constant=pytest.fail)
    assert result["gripped"] is True
    assert (result["lift_height"], result["slip"], result["seed"]) == (0.112, 0.0004, 3)
    assert result["real_time_factor"] == 1.25
    assert re.match(r"\d+\.\d+", result["versions"]["pybullet"])


def test_a_grasp_that_was_never_held_has_no_slip_and_says_why(tmp_path):
    values = VALUES | {"outcome": "none", "slip": "nan", "reason": "time out in lift"}
    verdict = verdict_from(values, False, "none: time out in lift", 1.0, 0)
    assert not verdict.gripped
    assert "not gripped (time out in lift)" in verdict.line(tmp_path)
    verdict.write(tmp_path / "result.json")
    assert json.loads((tmp_path / "result.json").read_text())["slip"] is None


def test_where_and_of_what_a_grasp_failed_stands_in_the_line_and_in_the_file(tmp_path):
    told = {"outcome": "lost", "reason": "dropped", "phase": "lift", "cause": "slipped in the lift"}
    verdict = verdict_from(VALUES | told | {"turn": "0.5"}, False, "lost: dropped", 1.0, 0)
    line = verdict.line(tmp_path)
    assert line.startswith("not gripped, slipped in the lift (dropped): ")
    verdict.write(tmp_path / "result.json")
    result = json.loads((tmp_path / "result.json").read_text())
    assert (result["phase"], result["cause"], result["turn"]) == (
        "lift",
        "slipped in the lift",
        0.5,
    )


@pytest.mark.parametrize(
    ("values", "success"),
    [(VALUES | {"outcome": "lost"}, True), (VALUES, False)],
    ids=["result says lost", "service says no"],
)
def test_both_the_service_and_the_result_must_say_gripped(values, success):
    assert not verdict_from(values, success, "", 1.0, 0).gripped


def test_a_result_without_a_number_is_refused_by_name():
    with pytest.raises(ValueError, match="lift_height: expected a number, got high"):
        verdict_from(VALUES | {"lift_height": "high"}, True, "", 1.0, 0)


def test_every_run_has_a_folder_and_the_link_points_to_the_latest(tmp_path):
    first, second = make_run_folder(tmp_path), make_run_folder(tmp_path)
    assert first != second
    assert (tmp_path / "demo").resolve() == second
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([first.name, second.name, "demo"])


def test_a_folder_that_cannot_be_written_is_named_before_anything_starts(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["--out", str(tmp_path / "file" / "out")]) == 2
    assert f"cannot write {tmp_path}/file/out: Not a directory" in capsys.readouterr().out


def test_a_strategy_that_cannot_be_read_is_named_before_anything_starts(tmp_path, capsys):
    assert main(["--strategy", "pinch", "--out", str(tmp_path / "out")]) == 2
    assert "strategy: expected one of" in capsys.readouterr().out
    assert not (tmp_path / "out").exists()


def test_a_strategy_brings_its_hand_and_reaches_the_sequencer(tmp_path, monkeypatch):
    gripper = Path(__file__).parents[3] / "examples/three_finger_gripper"
    begun = []
    monkeypatch.setattr(command, "Demo", lambda options, *_, **__: begun.append(options))
    monkeypatch.setattr(command, "_run", lambda demo: True)
    strategy = str(gripper / "grasp.yaml")
    assert main(["--strategy", strategy, "--object", "ball", "--out", str(tmp_path)]) == 0
    (options,) = begun
    for node in suite.three_nodes(options):
        assert node.parameters["hand"] == str(gripper / "gripper.yaml")
    assert suite.sequencer(options).parameters["strategy.surface_constrained"] == strategy


def test_wall_and_friction_of_the_demo_reach_the_simulator_and_the_pictures(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(command, "Demo", lambda options, *_, **__: made.append(options))
    monkeypatch.setattr(command, "_run", lambda demo: True)
    choice = ["--scene", "wall", "--wall-inclination", "60", "--friction", "pairs.yaml"]
    assert main([*choice, "--out", str(tmp_path)]) == 0
    (options,) = made
    parameters = suite.simulator(options).parameters
    assert (parameters["wall_inclination"], parameters["friction_file"]) == (60.0, "pairs.yaml")
    drawing = suite.figures(options, tmp_path, tmp_path).arguments
    assert drawing[-2:] == ("--wall-inclination", "60.0")
    usual = suite.simulator(suite.SuiteOptions()).parameters
    assert not {"wall_inclination", "friction_file"} & set(usual)


def test_a_wall_that_cannot_be_is_named_before_anything_starts(tmp_path, capsys):
    out = str(tmp_path / "out")
    assert main(["--wall-inclination", "60", "--out", out]) == 2
    assert "wall_inclination: expected a scene with a wall, got table" in capsys.readouterr().out
    assert main(["--scene", "wall", "--wall-inclination", "0", "--out", out]) == 2
    assert "expected 5 to 120 deg, got 0" in capsys.readouterr().out
    assert not (tmp_path / "out").exists()


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """Options of the demos that a call of the command begins, none of which is run."""
    made = []
    monkeypatch.setattr(command, "Demo", lambda options, *_, **__: made.append(options))
    monkeypatch.setattr(command, "_run", lambda demo: True)

    def begin(*arguments):
        made.clear()
        return main([*arguments, "--out", str(tmp_path / "out")]), made

    return begin


def test_an_object_alone_chooses_a_strategy_that_lifts_it_and_its_hand(begun, capsys):
    status, (options,) = begun("--object", "cylinder")
    assert (status, options.strategy, options.hand) == (0, "surface_constrained", "rbo_hand_2")
    assert "warning" not in capsys.readouterr().out


def test_a_hand_alone_chooses_a_strategy_of_that_hand(begun):
    status, (options,) = begun("--hand", "rbo_hand_1")
    assert status == 0 and load_strategy(options.strategy).hand == "rbo_hand_1"


def test_an_object_that_no_strategy_lifts_tells_which_strategies_fit_which(begun, capsys, tmp_path):
    nothing = tmp_path / "thing.yaml"
    text = "format: pneuflex-object/1\nshape: sphere\ndiameter: 0.05\nmass: 0.1\nmaterial: pvc\n"
    nothing.write_text(text + "rpy: [0, 0, 0]\n")
    status, made = begun("--object", str(nothing))
    said = capsys.readouterr().out
    assert status == 2 and not made
    assert "no strategy is known to lift" in said and "thing.yaml" in said
    for name in strategy_names():
        assert f"  {name} ({load_strategy(name).hand}): " in said


def test_an_object_that_does_not_exist_is_told_the_names_there_are(begun, capsys):
    status, made = begun("--object", "elephant")
    assert status == 2 and not made
    assert "tape_dispenser" in capsys.readouterr().out


def test_a_combination_that_does_not_fit_runs_with_a_warning(begun, capsys):
    status, (options,) = begun("--object", "tissue", "--strategy", "surface_constrained")
    assert (status, options.object) == (0, "tissue")
    said = capsys.readouterr().out
    assert "warning: surface_constrained is not known to lift 'tissue', but cylinder" in said


def test_a_strategy_alone_brings_object_scene_model_and_segments(begun, tmp_path):
    shipped = (STRATEGY_FOLDER / "surface_constrained.yaml").read_text()
    world = "scene: wall\nwall_inclination: 60\nmodel: base\nsegments: 7\nplace: [0.1, 0.2]"
    own = f"{world}\nobjects: [ball, tube]"
    path = tmp_path / "own.yaml"
    path.write_text(re.sub("objects: .*", own, shipped))
    _, (options,) = begun("--strategy", str(path))
    assert (options.object, options.scene, options.model) == ("ball", "wall", "base")
    parameters = suite.simulator(options).parameters
    assert (parameters["segments"], parameters["model_file"]) == (7, "base")
    assert parameters["wall_inclination"] == 60.0
    assert parameters["object_offset"] == pytest.approx([0.1, 0.2], abs=0.0101)
    _, (options,) = begun("--strategy", str(path), "--wall-inclination", "70")
    assert options.wall_inclination == 70.0
    _, (options,) = begun("--strategy", str(path), "--scene", "table", "--model", "linear")
    assert (options.scene, options.model, options.wall_inclination) == ("table", "linear", None)


def test_a_strategy_that_was_tried_in_the_corner_has_its_object_there(begun, tmp_path):
    shipped = (STRATEGY_FOLDER / "surface_constrained.yaml").read_text()
    world = "place: corner\nupright: [tube]\nobjects: [tube]"
    path = tmp_path / "own.yaml"
    path.write_text(re.sub("objects: .*", world, shipped))
    for name, upright in (("tube", True), ("cylinder", False)):
        _, (options,) = begun("--strategy", str(path), "--object", name)
        (x, y), thing = options.object_offset, load_object(name)
        radius, half_length = thing.half_extents[0], thing.half_extents[2]
        across = radius if upright else half_length  # else it lies along y
        assert (x, y) == (pytest.approx(radius, abs=0.0101), pytest.approx(-across, abs=0.0101))
        assert suite.simulator(options).parameters["object_upright"] is upright


def test_those_that_fit_come_with_the_usual_one_first_and_those_of_the_table_next():
    fitting = fitting_strategies("cylinder")
    assert fitting[0] == "surface_constrained"
    elsewhere = [load_strategy(name).tried_with != TriedWith() for name in fitting[1:]]
    assert elsewhere == sorted(elsewhere)
    assert all("cylinder" in load_strategy(name).objects for name in fitting)
    assert fitting_strategies("elephant") == []


def test_a_stored_grasp_brings_its_object_held_out_to_the_hand(tmp_path, begun):
    strategy = str(write_made_up_strategies(tmp_path)[2])
    status, (options,) = begun("--strategy", strategy, "--seed", "3")
    assert status == 0
    simulator, sequencer = (make(options).parameters for make in (suite.simulator, suite.sequencer))
    assert (simulator["object"], simulator["scene"]) == ("cylinder_25", "held")
    assert (simulator["step"], simulator["finger_contact"]) == (0.005, True)
    assert simulator["object_mass_scale"] == 1.0
    assert sequencer["strategy.surface_constrained"] == strategy
