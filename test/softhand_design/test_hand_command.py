"""The command `hand`: what it prints, writes and refuses."""

import json
from pathlib import Path

import matplotlib.image
import pytest
import yaml

from pneuflex_sim.pictures.hand_picture import HAND_CAPTION
from softhand_design.commands.hand import main
from softhand_model.hand.hand import load_hand

OWN_RUBBER = ("--modulus", 113, "--max-stretch", 7.5)
PROFILES = ("design", "--length", 90, "--ratio-profile", "[[0, 0.7], [90, 1.1]]")
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
    assert rows["wall"] == [f"{1e3 * float(finger.wall(0.0)):.4g}", "mm"]
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
    assert path.read_text() == "mine" and "--force overwrites it" in capsys.readouterr().err
    assert run(*WISH, "-o", path, "--force") == 0
    assert load_hand(path).name == "finger_on_stand"


def test_another_rubber_takes_another_wall(capsys):
    walls = []
    for rubber in (("--rubber", "Dragon Skin 10"), ("--rubber", "Dragon Skin 20"), OWN_RUBBER):
        assert run(*WISH, "--json", *rubber) == 0
        walls.append(json.loads(capsys.readouterr().out)["actuator"]["wall"])
    assert walls[1] == walls[2] < walls[0]


def test_a_rubber_of_ones_own_bears_no_name_of_the_table(tmp_path, capsys):
    path = tmp_path / "finger.yaml"
    assert run(*WISH, *OWN_RUBBER, "--density", 1200, "-o", path) == 0
    rows = {line[:24].strip(): line[24:].split() for line in capsys.readouterr().out.splitlines()}
    assert rows["rubber"] == ["custom"]
    assert rows["shear modulus"] == ["113", "kPa"]
    assert rows["largest stretch"] == ["7.5"]
    assert rows["density"] == ["1200", "kg/m3"]
    assert "rubber: custom, 1200 kg/m3" in path.read_text()
    assert "Dragon Skin" not in path.read_text()


def test_each_rubber_of_the_table_has_a_density_of_its_own(capsys):
    masses = []
    for rubber in (("--rubber", "Dragon Skin 20"), (*OWN_RUBBER, "--density", 2160)):
        assert run(*WISH, "--json", *rubber) == 0
        masses.append(json.loads(capsys.readouterr().out)["actuator"]["mass"])
    assert masses[1] == pytest.approx(2 * masses[0], rel=1e-5)  # Dragon Skin 20: 1080 kg/m3


def test_warnings_are_in_the_units_of_the_options(capsys):
    assert run(*WISH, "--wall", 3, "--height", 25, "--width", 25) == 0
    ratio, stiffness, *_ = capsys.readouterr().err.splitlines()
    assert "actuation ratio expected at least 0.837 and at most 1.023 1/(m kPa), got 0." in ratio
    assert "stiffness expected at least 3.51 and at most 4.29 mN m2, got " in stiffness


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((*WISH, "--ratio", 0.1), "ratio: expected above 0.3025 1/(m kPa), at which"),
        ((*WISH, "--rubber", "gum"), "rubber: expected one of Dragon Skin 10, Dragon Skin 20"),
        ((*WISH, *OWN_RUBBER, "--modulus", 0.113), "modulus: expected 1 to 100000 kPa, got 0.113"),
        ((*WISH, *OWN_RUBBER, "--max-stretch", 0.5), "max-stretch: expected 1.01 to 100, got 0.5"),
        (
            (*WISH, *OWN_RUBBER, "--max-stretch", 1.8),
            "max-stretch: expected above 2 of custom, got",
        ),
        ((*WISH, "--modulus", 113), "max-stretch: expected a number, as modulus is given"),
        ((*WISH, "--max-stretch", 7), "modulus: expected a number, as max-stretch is given"),
        ((*WISH, "--density", 1.07), "density: expected 100 to 20000 kg/m3, got 1.07"),
        ((*WISH, "--length", 0.09), "length: expected 2 to 2000 mm, got 0.09"),
        (
            (*WISH, "--wall", 30),
            "wall: expected below 8.899 mm, which leaves a chamber of 1 mm",
        ),
        (
            (*WISH, "--tip-stiffness", 5),
            "tip-stiffness: expected 0 to the stiffness at the base, 3.9",
        ),
        ((*WISH, "--name", "../../evil"), "name: expected a name of letters, digits, _ and -, got"),
        (
            (*WISH, "--name", "P5"),
            "name: expected another name than those of shipped actuators, got P5",
        ),
        (
            (*WISH, "-o", "finger.txt"),
            "finger.txt: expected a file with the suffix .yaml or .yml, got .txt",
        ),
        (("design", "--stiffness", 4, "--length", 90), "ratio: expected a number, got none"),
        ((*PROFILES, "--wall", 2), "wall: expected nothing beside profiles, got 2.0"),
        ((*WISH, "--pressure", 40), "pressure: expected a profile beside it, got 40.0"),
        ((*WISH, "--side-share", 0.3), "side-share: expected a profile beside it, got 0.3"),
        ((*PROFILES, "--ratio", 3), "ratio: expected none beside ratio-profile, got 3.0"),
        ((*PROFILES, "--arc-angle", 90), "arc-angle: expected none beside length, got 90.0"),
        (
            (*PROFILES, "--stiffness", 4, "--rubber", "auto", "--density", 1000),
            "density: expected none beside rubber auto, got 1000.0",
        ),
        ((*PROFILES, "--stiffness", -1), "stiffness: expected 0 to 1e+06 mN m2, got -1"),
        (
            (*PROFILES, "--stiffness-profile", "[[0, 4], [80, 2]]"),
            "stiffness-profile: expected [x, value] from x = 0 to the length, 90 mm",
        ),
        ((*PROFILES, "--stiffness-profile", "[[0"), "stiffness-profile: expected a number, [["),
        (
            (*PROFILES, "--stiffness", 4, "--pressure", 20, "--max-curvature", 60),
            "pressure: expected at least 61.38 kPa for this curvature, got 20 kPa",
        ),
        (
            (*PROFILES, "--stiffness", 4, "--ratio-profile", 0.1),
            "ratio-profile at 0 mm: expected above 0.3236 1/(m kPa), at which",
        ),
        (("show", "claw"), "hand: expected one of rbo_hand_1"),
        (("show", "rbo_hand_2", "--pressure", "20,30"), "expected 1 or 4 numbers, got 2"),
        (("show", "rbo_hand_2", "--pressure", "500"), "0 to [80, 80, 105, 160] kPa, got [500]"),
        (
            ("show", "rbo_hand_2", "-o", "hand.foo"),
            "hand.foo: expected a file with the suffix .png",
        ),
        (("show", "rbo_hand_2", "--pressure", "much"), "pressure: expected a number [kPa], or one"),
        (("show", "rbo_hand_2", "--segments", "0"), "segments: expected 1 or more, got 0"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments, words, capsys):
    assert run(*arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"softhand hand {arguments[0]}: ") and words in error


def test_profiles_give_a_wall_that_varies_and_a_picture(tmp_path, capsys):
    path, picture = tmp_path / "finger.yaml", tmp_path / "finger.png"
    profiles = (*PROFILES, "--stiffness-profile", "{maximum: 4, taper: 0.5, root: 1}")
    assert run(*profiles, "--max-curvature", 60, "-o", path, "--figure", picture) == 0
    shown = capsys.readouterr()
    rows = [line.split("|") for line in shown.out.splitlines() if line.startswith("| ")][2:]
    finger = load_hand(path).chain("finger").actuators["finger"]
    for cells, x in zip(rows, (0.0, 0.015, 0.03, 0.045, 0.06, 0.075, 0.09), strict=True):
        ratio, reached, stiffness, bent = (float(cell) for cell in cells[2:6])
        assert ratio == pytest.approx(0.7 + 0.4 * x / 0.09, rel=1e-3)
        assert reached == pytest.approx(ratio, rel=1e-3)
        assert bent == pytest.approx(stiffness, rel=1e-3)
        assert float(cells[10]) == pytest.approx(1e3 * float(finger.wall(x)), rel=1e-3)
    assert float(finger.wall(0.0)) > 1.3 * float(finger.wall(0.09))
    assert matplotlib.image.imread(picture).std() > 0.05
    assert shown.err == ""


def test_without_an_aspect_the_finger_is_as_wide_as_high_and_with_tapers_rules_warn(capsys):
    wanted = (*PROFILES, "--stiffness-profile", "[[0, 4], [90, 1.5]]")
    told = []
    for aspect in ((), ("--aspect", 1), ("--aspect", "P10")):
        assert run(*wanted, *aspect) == 0
        told.append(capsys.readouterr())
    assert told[0] == told[1]
    assert told[0].err == ""
    assert "rule 2" in told[2].err


def test_the_rubber_is_chosen_by_its_index_among_those_that_do(capsys):
    assert run(*PROFILES, "--stiffness", 4, "--rubber", "auto", "--json") == 0
    assert json.loads(capsys.readouterr().out)["wish"]["rubber"]["name"] == "Dragon Skin 10"
    assert run(*PROFILES, "--stiffness", 4, "--rubber", "auto") == 0
    assert "| Elastosil M4125" in capsys.readouterr().out


def test_an_arc_is_designed_by_radius_and_angle(tmp_path):
    path = tmp_path / "palm.yaml"
    arc = ("--arc-radius", 60, "--arc-angle", 90, "--ratio-profile", 0.6)
    assert run("design", *arc, "--stiffness-profile", 7, "-o", path) == 0
    palm = load_hand(path).chain("finger").actuators["finger"]
    assert palm.arc_radius == pytest.approx(0.06)
    assert palm.length == pytest.approx(0.09425, rel=1e-3)


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


@pytest.mark.parametrize(
    "command",
    [("show", "single_finger", "--segments", 2, "--pressure", 20), ("urdf", "single_finger")],
)
def test_a_file_of_the_users_is_overwritten_by_force_alone(tmp_path, capsys, command):
    path = tmp_path / "mine.png"
    path.write_text("mine")
    assert run(*command, "-o", path) == 2
    assert path.read_text() == "mine" and "--force overwrites it" in capsys.readouterr().err
    assert run(*command, "-o", path, "--force") == 0
    assert path.read_bytes() != b"mine"


def test_the_picture_without_a_name_is_always_drawn_anew(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        assert run("show", "single_finger", "--segments", 2, "--pressure", 20) == 0
    assert (tmp_path / "out/hand/single_finger.png").exists()


def test_help_and_picture_say_that_nothing_touches(capsys):
    with pytest.raises(SystemExit):
        run("show", "--help")
    assert "without contact" in " ".join(capsys.readouterr().out.split())
    assert "no contact" in HAND_CAPTION
