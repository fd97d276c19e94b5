"""The command that lists and draws objects, and the page that names them."""

import re
from pathlib import Path

import numpy as np
import pytest

from pneuflex_sim.commands.objects import main, picture
from pneuflex_sim.scene.objects import load_object

PAGE = Path(__file__).parents[3] / "docs/use/objects.md"


def test_the_page_names_each_object_that_the_command_lists(capsys):
    assert main([]) == 0
    listed = re.findall(r"^\| (`\w+`)", capsys.readouterr().out, re.MULTILINE)
    page = PAGE.read_text()
    assert len(listed) >= 30
    assert [name for name in listed if name not in page] == []


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
    assert main(["ball", "--figure", str(tmp_path / "two.png")]) == 2  # it exists
    assert main(["ball", "--figure", str(tmp_path / "two.png"), "--force"]) == 0
    assert (tmp_path / "two.png").read_bytes()[1:4] == b"PNG"
    assert np.unique(picture(load_object("ball"))).size > 10


def test_a_figure_of_no_known_kind_is_refused_before_anything_is_read(tmp_path, capsys):
    assert main(["no such object", "--figure", str(tmp_path / "o.foo")]) == 2
    assert "o.foo: expected a file with the suffix .png or .pdf or .svg" in capsys.readouterr().err


MUG = (
    "format: pneuflex-object/1\nshape: box\nsize: [0.05, 0.05, 0.05]\nmass: 0.1\nmaterial: cheese\n"
)
OWN = "format: pneuflex-friction/1\npairs:\n  cheese: {rubber: 0.5, wood: 0.3}\n"


def test_a_material_without_friction_is_refused_unless_a_table_of_ones_own_has_it(tmp_path, capsys):
    mug, own = tmp_path / "mug.yaml", tmp_path / "own.yaml"
    mug.write_text(MUG)
    own.write_text(OWN)
    assert main([str(mug)]) == 2
    error = capsys.readouterr().err
    assert "mug.yaml:5: material: expected one of cardboard, " in error
    assert "friction.yaml), got 'cheese'" in error
    assert main([str(mug), "--friction", str(own)]) == 0
    assert "| cheese |" in capsys.readouterr().out
