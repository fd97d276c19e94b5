"""The names on top of `model_lab`: what they take, give and print."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lab_sets import SIZE as SPECIMEN

import model_lab as lab

FINGER = Path(__file__).parents[3] / "examples" / "measurements" / "finger"
UNITS = {"time": "s", "pressure": "psi", "tip_angle": "rad"}


@pytest.fixture(scope="module")
def finger():
    return lab.load(FINGER)


@pytest.fixture(scope="module")
def thin_frames(finger):
    """Runs of the thin finger in psi and rad, converted here."""
    frames = {name: frame for name, frame in finger.runs.items() if name.startswith("thin")}
    return {
        name: frame.assign(
            pressure=frame["pressure"] / 6.894757293168361,
            tip_angle=np.radians(frame["tip_angle"]),
        )
        for name, frame in frames.items()
    }


def protocols(frames):
    return {name: {"protocol": "half" if "half" in name else "ramp"} for name in frames}


@pytest.fixture(scope="module")
def compared(thin_frames):
    data = lab.from_frames(
        thin_frames, "free_bending", {"thin": SPECIMEN}, UNITS, protocols(thin_frames)
    )
    return lab.compare(data)


def test_the_import_alone_loads_neither_numpy_nor_matplotlib():
    code = "import sys, model_lab; print({'numpy', 'matplotlib'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_there_are_a_dozen_names_at_most_and_each_says_what_it_does():
    assert len(lab.__all__) <= 12
    for name in lab.__all__:
        assert getattr(lab, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'lod'"):
        lab.lod  # noqa: B018


def test_loaded_runs_are_in_the_units_of_the_files(finger):
    stored = pd.read_csv(FINGER / "thin_ramp_1.csv")
    for name in ("time", "pressure", "tip_angle"):
        np.testing.assert_allclose(finger.runs["thin_1"][name], stored[name], rtol=1e-12)
    assert finger.units == {"time": "s", "pressure": "kPa", "tip_angle": "deg"}


def test_errors_are_in_the_units_of_the_frames(compared, finger, thin_frames):
    assert compared.unit == "rad"
    kept = {name: finger.runs[name] for name in thin_frames}
    in_degrees = lab.compare(
        lab.from_frames(kept, "free_bending", {"thin": SPECIMEN}, finger.units, protocols(kept))
    )
    assert in_degrees.unit == "deg"
    np.testing.assert_allclose(np.radians(in_degrees.error), compared.error, rtol=1e-4)
    assert set(compared.runs) == set(thin_frames)


def test_plots_are_labelled_in_the_units_of_the_user(compared):
    figure = compared.plot()
    labels = {axes.get_ylabel() for axes in figure.axes}
    assert "tip angle [rad]" in labels
    assert "pressure [psi]" in {axes.get_xlabel() for axes in figure.axes}


def test_a_result_prints_itself_and_shows_figures_in_a_notebook(compared):
    assert "held out" in repr(compared)
    page = compared._repr_html_()
    assert page.count("<svg") == sum(axes.get_visible() for axes in compared.plot().axes)
    assert compared._repr_html_() != page  # ids differ between the cells of a notebook


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"experiment": "bending"}, "^experiment: expected"),
        ({"units": {"time": "s", "pressure": "N", "tip_angle": "rad"}}, "^columns.pressure.unit"),
        (
            {"runs": {"other": {}}},
            "^runs: expected some of the names in `frames`: thin_1, .* got other",
        ),
        ({"specimens": {"a": SPECIMEN, "b": SPECIMEN}}, "runs.thin_1.*specimen"),
    ],
)
def test_wrong_frames_are_refused_by_field(thin_frames, given, expected):
    right = {"experiment": "free_bending", "specimens": {"thin": SPECIMEN}, "units": UNITS}
    with pytest.raises(ValueError, match=expected) as refused:
        lab.from_frames(thin_frames, **(right | given))
    assert "/tmp" not in str(refused.value)


def test_a_frame_without_a_needed_column_is_named(thin_frames):
    broken = {**thin_frames, "thin_2": thin_frames["thin_2"].drop(columns="pressure")}
    with pytest.raises(ValueError, match=r"^frames\['thin_2'\].*pressure"):
        lab.from_frames(broken, "free_bending", {"thin": SPECIMEN}, UNITS)


def test_an_effect_that_was_hidden_is_added_and_the_saved_model_has_the_error_that_was_said(
    tmp_path,
):
    data = lab.synthesize("uniaxial", hide="gent_stiffening", seed=1)
    model = lab.add("gent_stiffening", data)
    before, after = model.errors
    assert after < 0.5 * before
    model.save(tmp_path / "model.yaml")
    again = lab.compare(data, tmp_path / "model.yaml")
    np.testing.assert_allclose(again.error, after, rtol=0.05)
    assert again.unit == model.unit == "kPa"
    assert lab.ladder(data, {"before": "base", "after": model}).errors["before"] > again.error


def test_nothing_to_add_is_said():
    with pytest.raises(ValueError, match="effects: expected at least one effect to add, got none"):
        lab.add((), FINGER)


def test_the_block_of_the_page_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    root = FINGER.parents[2]
    (block,) = re.findall(
        r"```python\n(.*?)```", (root / "docs/use/python.md").read_text(encoding="utf-8"), re.S
    )
    (tmp_path / "out").mkdir()
    (tmp_path / "examples").symlink_to(root / "examples")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "python.md", "exec"), {})
    assert (tmp_path / "out" / "compared.png").stat().st_size > 10_000
    assert "deg" in capsys.readouterr().out


def test_a_hidden_effect_is_named_added_and_the_error_falls_to_the_floor():
    data = lab.synthesize("uniaxial", hide="gent_stiffening", seed=1)
    found = lab.diagnose(data)
    assert [effect.name for effect in found.effects] == ["gent_stiffening"]
    assert "<svg" in found._repr_html_() and found.sentence in found._repr_html_()
    left = lab.compare(data, lab.add(found.effects, data))
    assert left.error < 1.3 * left.floor < 0.3 * lab.compare(data).error


PULL = "\n".join(f"{n};{1 + n / 10:.3f};{n},{100 + n}".replace(".", ",") for n in range(1, 9))


def test_an_import_can_be_told_what_the_command_can_be_told(tmp_path):
    files = [tmp_path / name for name in ("thin_1.csv", "thick_1.csv")]
    for file in files:
        file.write_text(f"time [s];stretch [-];stress [kPa]\n{PULL}\n")
    ways = {"sheets": {"other.xlsx": "A"}, "decimal": "comma"}
    for name, value in ways.items():
        with pytest.raises(ValueError, match=name.removesuffix("s")):
            lab.import_files(files, **{"decimal": ",", name: value})
    said = {"decimal": ",", "specimen": "strip", "stretched_to": {"": 2.0, "thin_1.csv": 1.5}}
    runs = {run.name: run for run in lab.import_files(files, **said).set.runs}
    assert {run.specimen for run in runs.values()} == {"strip"}
    assert {name: run.stretched_to for name, run in runs.items()} == {"thin_1": 1.5, "thick_1": 2.0}
    assert runs["thin_1"].columns["stress"][0] == pytest.approx(1.101e3)
    everywhere = lab.import_files(files, decimal=",", stretched_to=2.0).set.runs
    assert {run.stretched_to for run in everywhere} == {2.0}
