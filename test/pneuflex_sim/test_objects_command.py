"""The command that lists and draws objects, and the page that shows what it prints."""

from pathlib import Path

import numpy as np
import pytest

from pneuflex_sim.objects import load_object
from pneuflex_sim.objects_command import main, picture

PAGE = Path(__file__).parents[2] / "docs/objects.md"


def test_the_page_has_the_table_that_the_command_prints(capsys):
    assert main([]) == 0
    shown = PAGE.read_text().split("<!-- objects -->\n")[1].split("<!-- end of objects -->")[0]
    assert shown == capsys.readouterr().out


def test_an_object_that_does_not_exist_ends_the_command_with_those_there_are(capsys):
    assert main(["brick"]) == 2
    assert "expected one of cylinder" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "least"), [("tissue", 0.1), ("paper_cup", 0.05)])
def test_an_object_covers_a_part_of_its_picture(name, least):
    seen = picture(load_object(name)).astype(int)
    blue = (seen[:, :, 2] > seen[:, :, 0] + 30).mean()
    assert least < blue < 0.5


def test_the_figure_is_written(tmp_path):
    pytest.importorskip("matplotlib")
    assert main(["ball", "tube", "--figure", str(tmp_path / "two.png")]) == 0
    assert (tmp_path / "two.png").read_bytes()[1:4] == b"PNG"
    assert np.unique(picture(load_object("ball"))).size > 10
