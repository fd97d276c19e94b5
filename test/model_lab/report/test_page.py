"""The report in a real browser: figures render, nothing is fetched or complained of."""

import re
from dataclasses import replace

import numpy as np
import pytest
from bending_set import bending_set
from browser import overlapping, render

from model_lab.bench.protocols import PROTOCOLS
from model_lab.bench.trial_runs import TrialRun
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.next_experiment import Experiment
from model_lab.report import write_report
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

COMMANDS = ("model-lab diagnose set --model base --report out", "model-lab reveal set")
TRIED = ("gent_stiffening", "yeoh_stiffening", "viscoelasticity", "tube_lag")


def diagnosed(data, names=TRIED):
    classes = effect_classes()
    return diagnose(data, load_model("base"), {name: classes[name] for name in names})


@pytest.fixture(scope="module")
def missing():
    """A set that lacks one effect; as if another were tied with it and a step should tell."""
    hidden = effect_classes()["viscoelasticity"](relative_modulus=0.4, relaxation_time=2.0)
    data = bending_set([hidden])
    outcome = diagnosed(data)
    held = next(entry for entry in PROTOCOLS if entry.name == "step_and_hold")
    time, course = held.course(48.0, 45e3, 200)
    columns = {"time": time, "pressure": course}
    trial = TrialRun("step_and_hold", "a step, held", data.specimens["thin"], 313.15, columns)
    step = Experiment(trial, 7.0, (("viscoelasticity", "tube_lag"),))
    diagnosis = replace(outcome.diagnosis, tied=(("tube_lag",),), next_experiment=step.as_json())
    return data, replace(outcome, diagnosis=diagnosis)


@pytest.fixture(scope="module")
def unexplained():
    """A set with an error that no effect of the catalogue makes."""
    data = bending_set()
    runs = []
    for run in data.runs:
        wave = 0.5 * np.sin(run.columns["time"]) * (run.columns["pressure"] > 15e3)
        runs.append(
            replace(run, columns={**run.columns, "tip_angle": run.columns["tip_angle"] + wave})
        )
    data = replace(data, runs=tuple(runs))
    return data, diagnosed(data)


@pytest.fixture(scope="module")
def pages(missing, unexplained, tmp_path_factory):
    """Every kind of report, written and rendered, by name."""
    plain = bending_set()
    folder = tmp_path_factory.mktemp("pages")
    cases = {
        "missing": missing,
        "unexplained": unexplained,
        "adequate": (plain, diagnosed(plain)),
        "one_run": one_run(),
    }
    rendered = {}
    for name, (_, outcome) in cases.items():
        path = folder / f"{name}.html"
        write_report(outcome, path, COMMANDS)
        rendered[name] = (path.read_text(encoding="utf-8"), render(path, folder))
    return rendered


def one_run():
    """The least that can be diagnosed: one run without time."""
    data = bending_set(protocols=1, repeats=1)
    columns = {name: v for name, v in data.runs[0].columns.items() if name != "time"}
    data = replace(data, runs=(replace(data.runs[0], columns=columns),))
    return data, diagnosed(data)


KINDS = ("missing", "unexplained", "adequate", "one_run")
ALWAYS = {"ladder", "curves", "residuals", "ranking", "parameters", "rest"}


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_of_the_page_renders(pages, kind):
    figures = {figure["name"]: figure for figure in pages[kind][1].figures}
    assert set(figures) == ALWAYS | ({"next"} if kind == "missing" else set())
    for figure in figures.values():
        left, top, right, bottom = figure["box"]
        assert right - left > 600.0 and bottom - top > 90.0
        assert figure["marks"] > 3
        assert len(figure["label"]) > 20 and len(figure["caption"]) > 60


@pytest.mark.parametrize("kind", KINDS)
def test_the_browser_complains_of_nothing_and_fetches_nothing(pages, kind):
    rendered = pages[kind][1]
    assert rendered.console == []
    assert rendered.fetched == []


@pytest.mark.parametrize("kind", KINDS)
def test_no_label_of_a_figure_covers_another(pages, kind):
    covered = {figure["name"]: overlapping(figure) for figure in pages[kind][1].figures}
    assert {name: pairs for name, pairs in covered.items() if pairs} == {}


@pytest.mark.parametrize("kind", KINDS)
def test_the_page_is_no_wider_than_its_window(pages, kind):
    content, window = pages[kind][1].width
    assert 0 < content <= window


def test_the_browser_would_tell_of_an_error_in_the_page(tmp_path):
    page = tmp_path / "broken.html"
    page.write_text("<html><body><script>nowhere();</script></body></html>")
    assert "nowhere is not defined" in "".join(render(page, tmp_path).console)


def test_the_page_says_the_verdict_with_numbers_and_units(pages):
    text = pages["missing"][0]
    assert "The model lacks viscoelasticity (relative_modulus = 0.4" in text
    assert "These data cannot tell viscoelasticity from tube_lag." in text
    assert "These data cannot tell" not in pages["adequate"][0]
    assert "The model is adequate" in pages["adequate"][0]
    assert "no known effect explains it" in pages["unexplained"][0]


def test_texts_of_the_user_are_shown_as_they_are_and_the_commands_stand_at_the_end(pages):
    text = pages["missing"][0]
    assert "small &amp; &lt;quick&gt;" in text and "<quick>" not in text
    assert "\n".join(COMMANDS) in text


def test_curves_are_drawn_in_degrees_over_time_where_memory_is_missing(pages):
    curves = {
        kind: next(f for f in pages[kind][1].figures if f["name"] == "curves")
        for kind in ("missing", "adequate")
    }
    labels = {kind: {text[0] for text in figure["texts"]} for kind, figure in curves.items()}
    assert "time [s]" in labels["missing"] and "with viscoelasticity" in labels["missing"]
    assert "pressure [kPa]" in labels["adequate"] and "model" in labels["adequate"]


def test_ids_of_figures_do_not_clash(pages):
    ids = re.findall(r'\bid="([^"]+)"', pages["missing"][0])
    assert len(ids) == len(set(ids))
    used = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', pages["missing"][0]))
    assert {a or b for a, b in used} <= set(ids)


def test_a_large_set_makes_a_page_that_is_not_large(tmp_path):
    data = bending_set(samples=800, protocols=18)
    path = tmp_path / "large.html"
    write_report(diagnosed(data, ()), path, COMMANDS)
    assert path.stat().st_size < 3_000_000
    figures = {figure["name"]: figure for figure in render(path, tmp_path).figures}
    assert overlapping(figures["curves"]) == []
    titles = [text[0] for text in figures["curves"]["texts"] if text[0].startswith("p1")]
    assert len(titles) == sum(str(name).startswith("1") for name in range(18))
