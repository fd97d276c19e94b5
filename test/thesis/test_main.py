"""The command: lists, runs, refuses to overwrite, redraws; what plots and what speaks ROS apart."""

import io
import json
import subprocess
import sys
from dataclasses import fields
from functools import partial
from types import SimpleNamespace

import pytest

from softhand_common.progress import Progress
from thesis import frame
from thesis.__main__ import main, parser_of, progress_line

EXPERIMENTS = frame.experiments()
FLOW = ["run", "flow_function", "--ratios", "101"]


def run(*arguments):
    return main([str(argument) for argument in arguments])


def content_of(folder):
    return json.loads((folder / "result.json").read_text())


def test_the_list_has_a_line_that_names_the_place_in_the_thesis_for_each(capsys):
    assert run("list") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(EXPERIMENTS)
    assert all(len(line.split()) > 5 and line.endswith(")") for line in lines)


def test_modules_that_experiments_share_are_none():
    assert set(EXPERIMENTS).isdisjoint({"boxes", "rig_run", "stand", "static_finger", "course"})
    with pytest.raises(ValueError, match="expected one of approximation, .* got boxes"):
        frame.experiment("boxes")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_help_names_every_parameter_with_a_unit(name, capsys):
    module = EXPERIMENTS[name]
    with pytest.raises(SystemExit) as ended:
        run("run", name, "--help")
    assert ended.value.code == 0
    told = " ".join(capsys.readouterr().out.split())
    assert frame.title_of(module) in told
    for entry in fields(frame.parameters_of(module)):
        assert f"--{entry.name.replace('_', '-')}" in told
        assert entry.metadata["help"].endswith("]")


def test_small_parameters_are_parameters():
    for module in EXPERIMENTS.values():
        frame.parameters_of(module, getattr(module, "SMALL", None))


def test_the_name_of_an_experiment_is_short_for_running_it(capsys):
    with pytest.raises(SystemExit):
        run("push_map", "--help")
    assert "python -m thesis run push_map" in capsys.readouterr().out


def test_it_writes_figure_series_and_json_and_prints_table_and_verdict(tmp_path, capsys):
    assert run(*FLOW, "--out", tmp_path / "made", "--figure", tmp_path / "copy.png") == 0
    told = capsys.readouterr().out
    assert told.startswith("| what | thesis | here |\n") and "Verdict: Scaled to fit" in told
    content = content_of(tmp_path / "made")
    assert content["parameters"] == {"ratios": 101}
    assert content["versions"]["numpy"] and content["verdict"] in told
    assert {"what", "value", "unit", "thesis"} <= set(content["findings"][0])
    picture = (tmp_path / "made" / "figure.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and picture == (tmp_path / "copy.png").read_bytes()


def test_own_parameters_stand_before_the_small_ones(tmp_path):
    options = ("--small", "--diameters", 7e-4, 1e-3, "--seed", 2)
    assert run("run", "choke_size", *options, "--out", tmp_path) == 0
    given = content_of(tmp_path)["parameters"]
    assert given == {"seed": 2, "diameters": [7e-4, 1e-3], "channels": 1}


def test_it_does_not_overwrite_unasked_and_redraws_from_what_was_kept(tmp_path, capsys):
    arguments = [*FLOW, "--out", tmp_path]
    assert run(*arguments) == 0
    table = capsys.readouterr().out
    before = (tmp_path / "figure.png").read_bytes(), content_of(tmp_path)
    assert run(*arguments) == 2
    assert "--force replaces its result" in capsys.readouterr().err
    (tmp_path / "figure.png").unlink()
    assert run("run", "flow_function", "--redraw", "--out", tmp_path) == 0
    assert ((tmp_path / "figure.png").read_bytes(), content_of(tmp_path)) == before
    assert capsys.readouterr().out == table
    assert run(*arguments, "--force") == 0


def test_a_target_that_is_missed_shows_in_verdict_and_exit_status(tmp_path, capsys):
    assert run("run", "wall_strain", "--out", tmp_path) == 0
    content = content_of(tmp_path)
    assert content["results"]["bounds"]["gent"] == pytest.approx(1.0766, abs=1e-4)
    content["results"]["curves"]["1"]["deformed_depth"][5] += 0.01
    (tmp_path / "result.json").write_text(json.dumps(content))
    assert run("run", "wall_strain", "--out", tmp_path, "--redraw") == 1
    assert "falls short (2 of 3 targets met)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nonsense"], "expected one of approximation"),
        (["wall_strain", "--redraw"], "expected the result of an earlier run"),
        (["long_run", "--amplitude", "1.0"], "amplitude must be above 0 kg and below the mean"),
        (["long_run", "--seed", "-1"], "seed: expected a whole number from 0, got -1"),
        (["equilibrium_point", "--small"], "has no small run"),
        (["payload", "--grasps", "by the teeth"], "grasps: expected of RBO Hand 2"),
        (["discretisation", "--segments", "3"], "segments must have 10 among them"),
        (["disturbance", "--pressures", "1e3"], "pressures must have 60000 Pa"),
    ],
)
def test_unusable_input_ends_in_one_line(arguments, words, tmp_path, capsys):
    assert run("run", *arguments, *(() if len(arguments) < 2 else ("--out", tmp_path / "x"))) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "required: COMMAND"),
        (["nonsense"], "invalid choice: 'nonsense'"),
        (["run"], "required: name"),
        (["run", "flow_function", "--nonsense"], "unrecognized arguments: --nonsense"),
        (["run", "flow_function", "--ratios", "many"], "invalid int value: 'many'"),
        (["all", "chapter_99"], "invalid choice: 'chapter_99'"),
        (["all", "--seed", "x"], "invalid int value: 'x'"),
    ],
)
def test_a_wrong_call_ends_in_one_line(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        run(*arguments)
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line and line.endswith("--help tells more")


def test_a_result_of_another_experiment_is_not_redrawn(tmp_path, capsys):
    assert run(*FLOW, "--out", tmp_path) == 0
    assert run("run", "wall_strain", "--redraw", "--out", tmp_path) == 2
    assert "expected wall_strain, got flow_function" in capsys.readouterr().err


def test_all_runs_a_chapter_with_one_seed_and_says_what_it_leaves_out(
    tmp_path, monkeypatch, capsys
):
    names = ("flow_function", "scheduled_events", "equilibrium_point")
    asked = []

    def found(chapter):
        asked.append(chapter)
        return {name: EXPERIMENTS[name] for name in names}

    monkeypatch.setattr(frame, "experiments", found)
    assert run("all", "chapter_4", "--small", "--seed", 3, "--out", tmp_path) == 0
    assert asked == ["chapter_4"]
    assert "equilibrium_point: left out, it has no small run" in capsys.readouterr().err
    assert content_of(tmp_path / "scheduled_events")["parameters"]["seed"] == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flow_function", "scheduled_events"]


def test_one_that_is_refused_does_not_keep_the_others_from_running(tmp_path, monkeypatch, capsys):
    def chosen(chapter=None):
        return {name: EXPERIMENTS[name] for name in ("posture", "flow_function")}

    monkeypatch.setattr(frame, "experiments", chosen)
    monkeypatch.setitem(EXPERIMENTS["posture"].SMALL, "patterns", str(tmp_path / "none.yaml"))
    assert run("all", "--small", "--out", tmp_path) == 2
    assert "none.yaml: expected" in capsys.readouterr().err
    assert (tmp_path / "flow_function" / "result.json").exists()


def test_a_run_that_fails_ends_with_status_1_and_an_interrupted_one_with_130(
    tmp_path, monkeypatch, capsys
):
    for reason, status in (
        (RuntimeError("the finger does not come to rest"), 1),
        (KeyboardInterrupt(), 130),
    ):

        def fails(given, job, reason=reason):
            raise reason

        monkeypatch.setattr(EXPERIMENTS["wall_strain"], "run", fails)
        assert run("run", "wall_strain", "--out", tmp_path) == status
    assert "the finger does not come to rest" in capsys.readouterr().err


def test_progress_in_a_log_is_whole_lines(monkeypatch):
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr("softhand_common.progress.LINE_EVERY", 0.0)
    monkeypatch.setattr("thesis.__main__.Progress", partial(Progress, patience=0.0))
    with progress_line("long_run") as tell:
        tell("calibration", 0.25)
    assert "\r" not in log.getvalue()
    assert log.getvalue().splitlines()[-1] == "long_run: calibration, 25 % (00:00)"


def test_progress_says_what_it_is_at_and_how_far(monkeypatch):
    said = []
    stream = SimpleNamespace(write=said.append, flush=lambda: None, isatty=lambda: True)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr("softhand_common.progress.MOVE_EVERY", 0.0)
    monkeypatch.setattr("thesis.__main__.Progress", partial(Progress, patience=0.0))
    with progress_line("long_run") as tell:
        tell("calibration", 0.25)
        tell("sine", 0.1)
    words = "".join(said)
    assert "long_run: calibration, 25 %" in words and "long_run: sine, 10 %" in words


def test_the_parser_of_each_takes_its_defaults():
    for module in EXPERIMENTS.values():
        assert parser_of(module).parse_args([]).out.name == frame.name_of(module)


def test_simulating_and_reporting_need_no_plotting_library_and_no_ros():
    code = (
        "import sys; from pathlib import Path; from thesis import frame\n"
        "frame.experiments('chapter_4'); module = frame.experiment('flow_function')\n"
        "assert 'pneuflex_sim.simulation.simulation' not in sys.modules\n"
        "results = module.run(module.Parameters(), frame.Job(Path(), print))\n"
        "assert module.report(results, module.Parameters()).table\n"
        "frame.experiments(); assert 'pneuflex_sim.simulation.simulation' in sys.modules\n"
        "assert not {'matplotlib', 'rclpy', 'geometry_msgs'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
