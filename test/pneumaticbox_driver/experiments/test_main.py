"""The command: lists, writes, refuses to overwrite, redraws; what plots is kept apart."""

import json
import subprocess
import sys

import numpy as np
import pytest

from thesis.chapter_4.command import EXPERIMENTS, experiment, main, make_parser


def test_the_list_has_a_sentence_for_each(capsys):
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(EXPERIMENTS)
    assert all(len(line.split()) > 5 for line in lines)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_help_names_the_thesis_and_a_unit_for_every_setting(name, capsys):
    with pytest.raises(SystemExit) as ended:
        make_parser().parse_args([name, "--help"])
    assert ended.value.code == 0
    told = " ".join(capsys.readouterr().out.split())
    assert experiment(name).THESIS.split(",")[0] in told
    for setting in experiment(name).Settings.__dataclass_fields__.values():
        assert f"--{setting.name.replace('_', '-')}" in told
        assert setting.metadata["help"].endswith("]")


def test_it_writes_figure_series_and_json_and_prints_a_verdict(tmp_path, capsys):
    out = tmp_path / "made"
    assert main(["flow_function", "--ratios", "101", "--seed", "3", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert told.startswith("flow_function: ") and "thesis: 1.4 %" in told
    content = json.loads((out / "result.json").read_text())
    assert content["seed"] == 3 and content["settings"] == {"ratios": 101}
    assert content["version"] and content["verdict"] in told
    assert {"name", "value", "unit", "thesis"} == set(content["metrics"][0])
    assert (out / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_it_does_not_overwrite_unasked_and_redraws_from_the_series(tmp_path, capsys):
    arguments = ["flow_function", "--ratios", "101", "--out", str(tmp_path)]
    assert main(arguments) == 0
    assert main(arguments) == 2
    assert "--force overwrites it" in capsys.readouterr().err
    before = (tmp_path / "figure.png").read_bytes()
    (tmp_path / "figure.png").unlink()
    with np.load(tmp_path / "series.npz") as kept:
        assert len(kept["ratio"]) == 101
    assert main(["flow_function", "--redraw", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "figure.png").read_bytes() == before


def test_unusable_settings_end_in_one_line(tmp_path, capsys):
    out = ["--out", str(tmp_path / "made")]
    assert main(["long_run", "--amplitude", "1.0", *out]) == 2
    assert main(["long_run", "--redraw", *out]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert "amplitude must be above 0 kg and below the mean" in lines[0]
    assert "expected result.json and series.npz" in lines[1]


def test_simulating_and_reporting_need_no_plotting_library():
    code = (
        "import sys; from thesis.chapter_4.command import *\n"
        "for name in EXPERIMENTS: experiment(name)\n"
        "module = experiment('flow_function'); settings = module.Settings()\n"
        "module.report(module.simulate(settings, 0, print), settings)\n"
        "assert 'matplotlib' not in sys.modules and 'pybullet' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
