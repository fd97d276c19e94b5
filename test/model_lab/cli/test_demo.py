"""The demonstration, run whole as `make lab-demo` does, and what its ending says."""

import json
import subprocess
import sys

import pytest

from model_lab.cli.demo import ending

SEED = 0  # an effect without memory: the quickest


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The folder of a demonstration and what it printed."""
    folder = tmp_path_factory.mktemp("demo") / "lab-demo"
    command = [
        sys.executable,
        "-m",
        "model_lab.cli.demo",
        "--seed",
        str(SEED),
        "--out",
        str(folder),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_the_story_goes_from_the_set_to_the_opened_seal(told):
    folder, text = told
    commands = [line.split()[2] for line in text.splitlines() if line.startswith("    $ ")]
    first, *adds, last = "synthesize compare diagnose", "compare reveal"
    assert not adds
    assert commands[:3] == first.split() and commands[-2:] == last.split()
    assert set(commands[3:-2]) == {"add"}
    assert "--force" not in text
    for name in ("report.html", "model.yaml", "diagnosis.json", "set/experiment.yaml"):
        assert (folder / name).is_file()


def test_the_hidden_effect_is_found_and_the_error_falls_to_the_floor(told):
    folder, text = told
    found = json.loads((folder / "diagnosis.json").read_text())
    before, after = (
        json.loads((folder / f"{name}.json").read_text())["held_out"]["rmse"]
        for name in ("before", "after")
    )
    assert "\nRight" in text
    assert before > 2.0 * found["noise_floor"]
    assert after < 1.3 * found["noise_floor"]


def test_the_diagnosis_is_the_same_without_the_seal(told, tmp_path):
    folder, _ = told
    (folder / "set" / ".seal").unlink()
    again = tmp_path / "again.json"
    command = ["diagnose", str(folder / "set"), "--model", "base", "--json", str(again)]
    # in a process as the story's: the threads of the algebra decide on the last digits
    subprocess.run([sys.executable, "-m", "model_lab", *command], check=True, capture_output=True)
    assert json.loads(again.read_text()) == json.loads((folder / "diagnosis.json").read_text())


@pytest.mark.parametrize(
    ("named", "tied", "said"),
    [
        (["tube_lag"], [[]], "Right: tube_lag was hidden, tube_lag was named."),
        (["hysteresis"], [["tube_lag"]], "Right within its tie (tube_lag): tube_lag was hidden"),
        (["hysteresis"], [[]], "Wrong: tube_lag was hidden, hysteresis was named."),
        ([], [], "Not found: tube_lag was hidden, nothing was named."),
    ],
)
def test_the_ending_is_honest(named, tied, said):
    found = {"effects": [{"name": name} for name in named], "tied": tied}
    assert ending(found, {"effects": [{"name": "tube_lag"}]}).startswith(said)
