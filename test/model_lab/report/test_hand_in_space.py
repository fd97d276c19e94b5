"""The picture of a measured and a predicted hand."""

from pathlib import Path

import matplotlib.image
import pytest

from model_lab.cli.main import main as lab
from model_lab.report.hand_in_space import main

EXAMPLE = Path(__file__).parents[3] / "examples" / "measurements" / "finger"


@pytest.fixture(scope="module")
def hand(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hand") / "set"
    assert lab(["synthesize", "hand_pose", "--hide", "--seed", "1", "--out", str(folder)]) == 0
    return folder


def test_a_panel_for_each_model(hand, tmp_path):
    widths = []
    for models in (["gravity"], ["gravity", "gravity"]):
        out = tmp_path / f"{len(models)}.png"
        assert main([str(hand), *models, str(out)]) == 0
        widths.append(matplotlib.image.imread(out).shape[1])
    assert widths[1] == 2 * widths[0]


def test_what_is_no_set_of_a_hand_is_refused_in_a_line(tmp_path, capsys):
    assert main([str(EXAMPLE), "base", str(tmp_path / "out.png")]) == 2
    assert "expected a set of a hand, got free_bending" in capsys.readouterr().err
