"""The command `softhand`: one screen tells the suite, every name leads to its command."""

import importlib.metadata
import importlib.util
import subprocess
import sys

import pytest

from softhand_bringup import command


def softhand(*words, **environment):
    return subprocess.run(
        [sys.executable, "-m", "softhand_bringup.command", *words],
        capture_output=True,
        text=True,
        env=environment or None,
    )


def completions(line, folder):
    """What the shell would offer behind a line."""
    file = folder / "offered"
    done = softhand(
        _ARGCOMPLETE="1",
        _ARGCOMPLETE_IFS="\n",
        _ARGCOMPLETE_SUPPRESS_SPACE="1",
        _ARGCOMPLETE_STDOUT_FILENAME=str(file),
        COMP_LINE=line,
        COMP_POINT=str(len(line)),
        COMP_TYPE="9",
    )
    assert file.exists(), done.stderr
    return [word.strip() for word in file.read_text().splitlines()]


def test_help_tells_the_whole_suite_in_one_screen(capsys):
    assert command.main(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 80
    for name in command.modules():
        assert any(line.strip().startswith(f"{name} ") for line in lines), name


@pytest.mark.parametrize("module", sorted(set(command.modules().values())))
def test_every_name_leads_to_a_module_that_exists(module):
    assert importlib.util.find_spec(module)


def test_arguments_and_exit_status_are_those_of_the_command(capsys):
    assert command.main(["trials", "--seeds", "0"]) == 2
    assert "seeds" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "hint"), [(["trails"], "trials"), (["run", "drivr"], "run driver"), (["x"], "--help")]
)
def test_a_name_that_is_none_is_refused_with_what_is_near(words, hint, capsys):
    assert command.main(words) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert hint in said


def test_a_node_tells_its_parameters():
    done = softhand("run", "driver", "--help")
    assert done.returncode == 0, done.stderr
    assert "control_mode" in done.stdout


def test_the_shell_completes_names_and_options(tmp_path):
    assert set(completions("softhand fi", tmp_path)) == {"film", "figures"}
    assert "--object" in completions("softhand trials --ob", tmp_path)
    assert set(completions("softhand run dr", tmp_path)) == {"driver"}


def test_pip_puts_four_names_on_the_path():
    packages = ("softhand_model", "pneuflex_sim", "softhand_design", "pneumaticbox_driver")
    scripts = {
        entry.name
        for package in (
            *packages,
            "grasp_strategies",
            "softhand_trials",
            "model_lab",
            "softhand_bringup",
        )
        for entry in importlib.metadata.distribution(package).entry_points
        if entry.group == "console_scripts"
    }
    assert scripts == {"softhand", "softhand-sweep", "softhand-search", "model-lab"}
