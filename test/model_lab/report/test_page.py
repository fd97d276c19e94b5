"""The report in a real browser without network: on a phone, wide, printed."""

import re
from dataclasses import replace

import numpy as np
import pytest
from bending_set import bending_set
from browser import overlapping, printed, render

from model_lab.bench.protocols import PROTOCOLS
from model_lab.bench.trial_runs import TrialRun
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.next_experiment import Experiment
from model_lab.diagnosis.result import Step
from model_lab.fitting.notice import Notice
from model_lab.learning.learn import learn
from model_lab.measurements.units import display_of
from model_lab.report.curves import curves
from model_lab.report.marks import LINE_POINTS, envelope
from model_lab.report.page import write_report
from model_lab.report.view import View
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
    step = Experiment(trial, 7.0, 3.0, True, (("viscoelasticity", "tube_lag"),), {})
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
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def pages(missing, unexplained, folder):
    """Every kind of report, by name."""
    plain = bending_set()
    cases = {
        "missing": missing,
        "unexplained": unexplained,
        "adequate": (plain, diagnosed(plain)),
        "one_run": one_run(),
    }
    for name, (_, outcome) in cases.items():
        write_report(outcome, folder / f"{name}.html", COMMANDS)
    return {name: folder / f"{name}.html" for name in cases}


@pytest.fixture(scope="module")
def on_phone(pages, folder):
    """The reports on a window of 390 pixels, by name."""
    return {name: render(page, folder, PHONE) for name, page in pages.items()}


@pytest.fixture(scope="module")
def on_screen(pages, folder):
    """A report on a wide window."""
    return render(pages["missing"], folder)


def one_run():
    """The least that can be diagnosed: one run without time."""
    data = bending_set(protocols=1, repeats=1)
    columns = {name: v for name, v in data.runs[0].columns.items() if name != "time"}
    data = replace(data, runs=(replace(data.runs[0], columns=columns),))
    return data, diagnosed(data)


PHONE = 390  # [pixels]
KINDS = ("missing", "unexplained", "adequate", "one_run")
ALWAYS = {
    "ladder",
    "curves",
    "loops",
    "residuals",
    "ranking",
    "parameters",
    "rest-over-input",
    "rest",
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_panel_of_every_figure_is_drawn_on_a_phone(on_phone, kind):
    figures = {figure["name"]: figure for figure in on_phone[kind].figures}
    assert set(figures) == ALWAYS | ({"next"} if kind == "missing" else set())
    for figure in figures.values():
        assert figure["panels"] > 0 and figure["empty"] == 0
        assert len(figure["label"]) > 20 and len(figure["caption"]) > 60


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_on_a_phone_needs_no_sideways_scrolling_and_no_magnifier(on_phone, kind):
    content, window = on_phone[kind].width
    assert content == window == PHONE
    assert on_phone[kind].smallest >= 14.0
    for figure in on_phone[kind].figures:
        assert all(left >= 0.0 and right <= PHONE for left, _, right, _ in figure["boxes"])


def test_a_page_has_no_script(pages):
    assert not any("<script" in page.read_text() for page in pages.values())


@pytest.mark.parametrize("kind", KINDS)
def test_the_browser_complains_of_nothing_and_fetches_nothing(on_phone, kind):
    assert on_phone[kind].console == []
    assert on_phone[kind].fetched == []


@pytest.mark.parametrize("kind", KINDS)
def test_headings_are_in_order(on_phone, kind):
    levels = on_phone[kind].headings
    assert levels[0] == 1 and set(levels[1:]) == {2}


@pytest.mark.parametrize("kind", KINDS)
def test_no_label_of_a_panel_covers_another(on_phone, kind):
    covered = {figure["name"]: overlapping(figure) for figure in on_phone[kind].figures}
    assert {name: pairs for name, pairs in covered.items() if pairs} == {}


def test_panels_lie_side_by_side_where_there_is_room(on_screen, on_phone):
    def lefts(rendered):
        return {round(box[0]) for box in rendered.figure("curves")["boxes"]}

    assert len(lefts(on_phone["missing"])) == 1 < len(lefts(on_screen))
    assert on_screen.width[0] <= on_screen.width[1]


def test_a_click_makes_a_panel_as_wide_as_the_page_and_another_small_again(on_screen):
    before, enlarged, after = on_screen.clicked
    assert enlarged > 900.0 > 2.0 * before and after == before


def test_paper_has_every_panel(pages, folder, on_screen):
    paper, found = printed(pages["missing"], folder)
    assert found["pictures"] == sum(figure["panels"] for figure in on_screen.figures)
    assert found["right"] <= found["width"] + 1.0
    pages_printed = len(re.findall(rb"/Type\s*/Page\b", paper.read_bytes()))
    assert 2 <= pages_printed <= 10


def test_the_browser_would_tell_of_an_error_in_the_page(tmp_path):
    page = tmp_path / "broken.html"
    page.write_text("<html><body><script>nowhere();</script></body></html>")
    assert "nowhere is not defined" in "".join(render(page, tmp_path).console)


def test_the_page_says_the_verdict_with_numbers_and_units(pages):
    text = {name: page.read_text() for name, page in pages.items()}
    assert "The model lacks viscoelasticity (relative_modulus = 0.4" in text["missing"]
    assert "These data cannot tell viscoelasticity from tube_lag." in text["missing"]
    assert "These data cannot tell" not in text["adequate"]
    assert "The model is adequate" in text["adequate"]
    assert "no known effect explains it" in text["unexplained"]


def test_texts_of_the_user_are_shown_as_they_are_and_the_commands_stand_at_the_end(pages):
    text = pages["missing"].read_text()
    assert "small &amp; &lt;quick&gt;" in text and "<quick>" not in text
    assert "\n".join(COMMANDS) in text


def test_curves_are_drawn_in_degrees_over_time_where_memory_is_missing(on_phone, pages):
    def labels(kind):
        return {text for text, *_ in on_phone[kind].figure("curves")["texts"][0]}

    assert "time [s]" in labels("missing") and "pressure [kPa]" in labels("adequate")
    assert "with viscoelasticity</span>" in pages["missing"].read_text()


def test_the_story_of_several_effects_and_what_is_odd_stand_on_the_page(missing, tmp_path, folder):
    _, outcome = missing
    first = View(outcome).before.held_out.rmse
    steps = Step("tube_lag", first, first / 2), Step("viscoelasticity", first / 2, first / 10)
    wild = Notice(
        "wild_samples", 1.0, 1.0, "1 single sample lies far from both neighbours",
        np.arange(500.0), np.ones(500), np.array([7]),
    )  # fmt: skip
    told = replace(outcome.diagnosis, story=steps)
    path = tmp_path / "story.html"
    write_report(replace(outcome, diagnosis=told, notices=(wild,)), path, COMMANDS)
    text = path.read_text()
    story = re.search(r"<th scope=\"col\">falls</th>.*?</table>", text, re.DOTALL).group()
    cells = re.findall(r"<td[^>]*>(.*?)</td>", story)
    before, half, after = (display_of("rad").shown(first / part) for part in (1, 2, 10))
    assert cells[:4] == ["tube_lag", before, half, "2-fold"]
    assert cells[5:9] == ["viscoelasticity", half, after, "5-fold"]
    assert "far from both neighbours" in text
    assert render(path, folder, PHONE).figure("oddities")["empty"] == 0


def test_what_was_learned_stands_in_the_report_of_what_nothing_known_explains(folder):
    data = bending_set(samples=40, protocols=3)
    bent = []
    for run in data.runs:
        angle = run.columns["tip_angle"]
        seen = angle * (1.0 + 0.4 * np.abs(angle / 3.0) ** 1.5)
        bent.append(replace(run, columns={**run.columns, "tip_angle": seen}))
    data = replace(data, runs=tuple(bent))
    learned = learn(data, load_model("base"))
    path = folder / "with_curve.html"
    write_report(diagnosed(data, ("angle_offset",)), path, COMMANDS, learned)
    assert learned.chosen is not None and learned.chosen.shape.title[:-1] in path.read_text()
    rendered = render(path, folder, PHONE)
    figure = rendered.figure("learned")
    assert (figure["panels"], figure["empty"]) == (3, 0)
    assert rendered.width == [PHONE, PHONE]
    assert overlapping(figure) == []


def test_confidence_is_shown_where_it_is_known(unexplained, tmp_path):
    _, outcome = unexplained
    sure = replace(outcome.diagnosis, confidence=0.973)
    write_report(replace(outcome, diagnosis=sure), tmp_path / "sure.html", COMMANDS)
    assert "Confidence 97 %" in (tmp_path / "sure.html").read_text()
    assert '<meter value="0.973"' in (tmp_path / "sure.html").read_text()


def test_ids_of_figures_do_not_clash(pages):
    text = pages["missing"].read_text()
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    used = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text))
    assert {a or b for a, b in used} <= set(ids)


def test_a_large_set_makes_a_page_of_less_than_six_megabytes_and_keeps_extremes(tmp_path):
    data = bending_set(samples=500, protocols=36, repeats=1)
    angles = data.runs[0].columns["tip_angle"].copy()
    angles[331:336] = -3.0
    first = replace(data.runs[0], columns={**data.runs[0].columns, "tip_angle": angles})
    outcome = diagnosed(replace(data, runs=(first, *data.runs[1:])), ())
    path = tmp_path / "large.html"
    write_report(outcome, path, COMMANDS)
    assert path.stat().st_size <= 6_000_000
    figure = render(path, tmp_path).figure("curves")
    assert overlapping(figure) == []
    assert figure["panels"] == len(
        set(re.findall(r'<span class="title">(p\d[^<]*)', path.read_text()))
    )
    assert figure["panels"] == 36
    lines = [mark for mark in curves(View(outcome)).panels[0].marks if mark.width]
    assert lines and all(mark.most <= LINE_POINTS for mark in lines)
    shown = angles[envelope(angles, LINE_POINTS)]
    assert len(shown) <= LINE_POINTS < len(angles) and shown.min() == -3.0
