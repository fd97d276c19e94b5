"""The command that shows rubbers and fibres and chooses."""

import json

import pytest

from softhand_design.commands.materials import main

TABLE_3_2 = {
    "Dragon Skin 10": "26.6",
    "Dragon Skin 20": "20.2",
    "Dragon Skin 30": "13.5",
    "Ecoflex 00-30": "19.7",
    "Ecoflex 00-50": "22.5",
    "Elastosil M4125": "23.5",
    "TangoBlack+ FLX980 stiff": "8.0",
    "TangoBlack+ FLX980 soft": "8.6",
}


def cells(text):
    """Rows of the last table in a text, by their first cell."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    return {row[0]: row[1:] for row in rows}


def test_the_table_has_the_indices_of_table_3_2(capsys):
    assert main(["table"]) == 0
    shown = cells(capsys.readouterr().out)
    assert {name: shown[name][3] for name in TABLE_3_2} == TABLE_3_2


def test_the_fibres_are_those_of_table_3_1(capsys):
    assert main(["fibres"]) == 0
    shown = cells(capsys.readouterr().out)
    assert [shown[name][2] for name in ("no fibres", "stiff silicone", "PET", "HD-PE")] == [
        "0.15",
        "0.177",
        "50",
        "2300",
    ]


def test_a_mesh_allows_more_stress_than_a_thread_and_newtons_only_with_a_surface_energy(capsys):
    assert main(["defect"]) == 0
    out = capsys.readouterr().out
    assert cells(out)["70"] == ["2.67"] and "kPa" not in out
    assert main(["defect", "--surface-energy", "10"]) == 0
    assert cells(capsys.readouterr().out)["500"][1] == "61.8"


def test_the_choice_is_printed_as_a_table_and_as_json(capsys):
    words = ["choose", "--curvature", "100", "--stiffness", "4"]
    assert main([*words, "--diameter", "20"]) == 0
    assert cells(capsys.readouterr().out)["Dragon Skin 10"][-1] == "suits"
    assert main(["choose", "--curvature", "1000", "--stiffness", "40", "--json"]) == 2
    assert len(json.loads(capsys.readouterr().out)["choices"]) == len(TABLE_3_2)
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["choices"][0]["lowest"]["height"] == pytest.approx(0.01682, abs=1e-5)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["choose", "--curvature", "1000", "--stiffness", "40"], "curvature at most 334."),
        (["choose", "--curvature", "-1", "--stiffness", "4"], "curvature: expected 0.1 to 10000"),
        (["fibres", "--share", "2"], "share: expected 0.01 to 1, got 2"),
        (["defect", "0"], "widths: expected 0.1 to 10000 um, got 0"),
    ],
)
def test_what_cannot_be_is_refused_with_its_bound(words, told, capsys):
    assert main(words) == 2
    assert told in capsys.readouterr().err
