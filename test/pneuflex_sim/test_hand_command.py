"""The command `hand`: what it prints, writes and refuses."""

import json
from pathlib import Path

import matplotlib.image
import pytest
import yaml

from pneuflex_sim.hand_command import main
from softhand_model.hands import load_hand

WISH = ("design", "--ratio", 0.93, "--stiffness", 3.9, "--length", 90)


def run(*arguments):
    return main([str(argument) for argument in arguments])


def test_a_design_is_a_table_with_units_and_a_hand_to_load(tmp_path, capsys):
    path = tmp_path / "new" / "finger.yaml"
    assert run(*WISH, "--tip-stiffness", 1, "-o", path) == 0
    shown = capsys.readouterr()
    rows = {line[:24].strip(): line[24:].split() for line in shown.out.splitlines()}
    assert rows["actuation ratio"] == ["0.93", "0.93", "1/(m", "kPa)"]
    assert rows["stiffness at the base"] == ["3.9", "3.9", "mN", "m2"]
    finger = load_hand(path).chain("finger").actuators["finger"]
    assert rows["wall"] == [f"{1e3 * finger.wall:.4g}", "mm"]
    assert rows["height"] == [*(f"{1e3 * float(finger.height(x)):.4g}" for x in (0, 0.09)), "mm"]
    assert shown.err == ""


def test_json_holds_the_same_in_si_units_and_nothing_else(capsys):
    assert run(*WISH, "--json", "--name", "index") == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["wish"]["stiffness"] == pytest.approx(3.9e-3)
    assert printed["reached"]["actuation_ratio"] == pytest.approx(0.93e-3, rel=1e-5)
    assert printed["actuator"]["name"] == "index"
    assert printed["actuator"]["length"] == pytest.approx(0.09)
    assert printed["broken_rules"] == []


def test_a_broken_rule_is_a_warning_and_stands_in_the_file(tmp_path, capsys):
    path = tmp_path / "finger.yaml"
    assert run(*WISH, "--height", 24, "-o", path) == 0
    error = capsys.readouterr().err
    assert error.startswith("warning: rule 3: ") and "got 1.631" in error
    assert "# Warning: rule 3: " in path.read_text()


def test_a_file_is_not_overwritten_unless_forced(tmp_path, capsys):
    path = tmp_path / "finger.yaml"
    path.write_text("mine")
    assert run(*WISH, "-o", path) == 2
    assert path.read_text() == "mine" and "(or --force)" in capsys.readouterr().err
    assert run(*WISH, "-o", path, "--force") == 0
    assert load_hand(path).name == "finger_on_stand"


def test_another_rubber_takes_another_wall(capsys):
    walls = []
    for rubber in (("Dragon Skin 10",), ("Dragon Skin 20",), ("Dragon Skin 10", "--modulus", 113)):
        assert run(*WISH, "--json", "--rubber", *rubber) == 0
        walls.append(json.loads(capsys.readouterr().out)["actuator"]["wall"])
    assert walls[1] == walls[2] < walls[0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((*WISH, "--ratio", 0.1), "actuation_ratio: expected above 0.0002857 1/(m Pa)"),
        ((*WISH, "--rubber", "gum"), "rubber: expected one of Dragon Skin 10, Dragon Skin 20"),
        ((*WISH, "--modulus", -1), "modulus: expected a number above 0, got -1"),
        ((*WISH, "--max-stretch", 0.5), "max_stretch: expected a number above 1, got 0.5"),
        ((*WISH, "--name", "P5"), "name: expected none of a shipped actuator, got P5"),
        ((*WISH, "-o", "finger.txt"), "out: expected a file that ends in .yaml, got finger.txt"),
        (("show", "claw"), "hand: expected one of rbo_hand_1"),
        (("show", "rbo_hand_2", "--pressure", "20,30"), "expected 1 or 4 numbers, got 2"),
        (("show", "rbo_hand_2", "--pressure", "much"), "pressure: expected a number, or one for"),
        (("show", "rbo_hand_2", "--segments", "0"), "segments: expected 1 or more, got 0"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments, words, capsys):
    assert run(*arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"hand {arguments[0]}: ") and words in error


def test_a_designed_finger_is_drawn(tmp_path, capsys):
    finger, picture = tmp_path / "finger.yaml", tmp_path / "new" / "finger.png"
    assert run(*WISH, "-o", finger) == 0
    assert run("show", finger, "--pressure", 20, "--segments", 3, "-o", picture) == 0
    assert capsys.readouterr().out.endswith(f"{picture}\n")
    assert matplotlib.image.imread(picture)[..., :3].std() > 0.05


def test_the_air_that_a_hand_takes_is_printed_for_strategies(tmp_path, capsys):
    gripper = Path(__file__).parents[2] / "examples/three_finger_gripper/gripper.yaml"
    picture = tmp_path / "gripper.png"
    assert run("show", gripper, "--pressure", "20,0", "--segments", 3, "-o", picture) == 0
    assert picture.exists()
    line = next(line for line in capsys.readouterr().out.splitlines() if "kPa" in line)
    pressures, masses = line.split(" kPa: air_mass: ")
    air = yaml.safe_load(masses)
    assert pressures == "20, 0"
    assert float(air["single"]) == 0.0
    # at least what fills the volume at rest, and as a bent finger holds more, not much above that
    rest = load_hand(gripper).rest_volumes()[0]
    assert 1.0 < float(air["pair"]) / (20e3 * rest / (287.05 * 293.15)) < 3.0
