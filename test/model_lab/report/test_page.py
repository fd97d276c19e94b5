"""The report in a real browser without network: on a phone, wide, without scripts, printed."""

import base64
import re
from dataclasses import replace

import numpy as np
import pytest
from bending_set import bending_set
from browser import SCRIPT, overlapping, printed, render

from model_lab.bench.protocols import PROTOCOLS
from model_lab.bench.trial_runs import TrialRun
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.next_experiment import Experiment
from model_lab.diagnosis.result import Step
from model_lab.fitting.notices import Notice
from model_lab.learning.learn import learn
from model_lab.measurements.units import display_of
from model_lab.report import write_report
from model_lab.report.curves import curves
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
    step = Experiment(trial, 7.0, 3.0, (("viscoelasticity", "tube_lag"),), {})
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


@pytest.fixture(scope="module")
def pictures(pages, folder):
    """The reports in a browser that runs no scripts, by name."""
    return {name: render(page, folder, scripts=False) for name, page in pages.items()}


def one_run():
    """The least that can be diagnosed: one run without time."""
    data = bending_set(protocols=1, repeats=1)
    columns = {name: v for name, v in data.runs[0].columns.items() if name != "time"}
    data = replace(data, runs=(replace(data.runs[0], columns=columns),))
    return data, diagnosed(data)


PHONE = 390  # [pixels]
KINDS = ("missing", "unexplained", "adequate", "one_run")
ALWAYS = {"ladder", "curves", "residuals", "ranking", "parameters", "rest"}


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_is_drawn_as_plots_on_a_phone(on_phone, kind):
    figures = {figure["name"]: figure for figure in on_phone[kind].figures}
    assert set(figures) == ALWAYS | ({"next"} if kind == "missing" else set())
    for figure in figures.values():
        assert figure["panels"] > 0 and figure["empty"] == 0
        assert figure["plots"]["marks"] > 3 * figure["panels"]
        assert figure["picture"]["boxes"] == []
        assert len(figure["label"]) > 20 and len(figure["caption"]) > 60


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_on_a_phone_needs_no_sideways_scrolling_and_no_magnifier(on_phone, kind):
    content, window = on_phone[kind].width
    assert content == window == PHONE
    assert on_phone[kind].smallest >= 14.0
    for figure in on_phone[kind].figures:
        assert all(left >= 0.0 and right <= PHONE for left, _, right, _ in figure["plots"]["boxes"])


@pytest.mark.parametrize("kind", KINDS)
def test_the_browser_complains_of_nothing_and_fetches_nothing(on_phone, kind):
    assert on_phone[kind].console == []
    assert on_phone[kind].fetched == []


@pytest.mark.parametrize("kind", KINDS)
def test_headings_are_in_order(on_phone, kind):
    levels = on_phone[kind].headings
    assert levels[0] == 1 and set(levels[1:]) == {2}


@pytest.mark.parametrize("kind", KINDS)
def test_no_label_of_a_plot_covers_another(on_phone, on_screen, kind):
    for rendered in (on_phone[kind], on_screen):
        covered = {figure["name"]: overlapping(figure["plots"]) for figure in rendered.figures}
        assert {name: pairs for name, pairs in covered.items() if pairs} == {}


def test_panels_lie_side_by_side_where_there_is_room(on_screen, on_phone):
    def lefts(rendered):
        return {round(box[0]) for box in rendered.figure("curves")["plots"]["boxes"]}

    assert len(lefts(on_phone["missing"])) == 1 < len(lefts(on_screen))
    assert on_screen.width[0] <= on_screen.width[1]


def test_a_mouse_that_is_dragged_over_curves_zooms_into_them(on_screen):
    (low, high), zoomed = on_screen.zoom
    assert np.allclose(zoomed, [low + share * (high - low) for share in (0.4, 0.6)], rtol=0.02)


@pytest.mark.parametrize("kind", KINDS)
def test_without_scripts_every_figure_is_a_picture(pictures, kind):
    for figure in pictures[kind].figures:
        left, top, right, bottom = figure["picture"]["boxes"][0]
        assert right - left > 600.0 and bottom - top > 70.0
        assert figure["picture"]["marks"] > 3 and figure["plots"]["boxes"] == []
        assert overlapping(figure["picture"]) == [], figure["name"]


def test_paper_has_the_pictures_and_not_the_plots(pages, folder, on_screen):
    paper, found = printed(pages["missing"], folder)
    assert (found["pictures"], found["plots"]) == (len(on_screen.figures), 0)
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


def test_curves_are_drawn_in_degrees_over_time_where_memory_is_missing(pictures):
    labels = {
        kind: {text[0] for text in pictures[kind].figure("curves")["picture"]["texts"][0]}
        for kind in ("missing", "adequate")
    }
    assert "time [s]" in labels["missing"] and "with viscoelasticity" in labels["missing"]
    assert "pressure [kPa]" in labels["adequate"] and "model" in labels["adequate"]


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
    assert overlapping(figure["plots"]) == []


def test_confidence_is_shown_where_it_is_known(unexplained, tmp_path):
    _, outcome = unexplained
    sure = replace(outcome.diagnosis, confidence=0.973)
    write_report(replace(outcome, diagnosis=sure), tmp_path / "sure.html", COMMANDS)
    assert "Confidence 97 %" in (tmp_path / "sure.html").read_text()
    assert '<meter value="0.973"' in (tmp_path / "sure.html").read_text()


def test_ids_of_figures_do_not_clash(pages):
    text = SCRIPT.sub("", pages["missing"].read_text())
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
    figure = render(path, tmp_path, scripts=False).figure("curves")
    assert overlapping(figure["picture"]) == []
    titles = [text[0] for text in figure["picture"]["texts"][0] if re.match(r"p\d", text[0])]
    assert len(titles) == 36
    panel = curves(View(outcome)).shown()[0][1]["data"]
    shown = np.frombuffer(base64.b64decode(panel[0]["y"]["bdata"]), "<f4")
    assert len(shown) < 500 and np.isclose(shown.min(), np.degrees(-3.0))
