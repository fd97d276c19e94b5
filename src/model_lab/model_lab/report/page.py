"""Report page: verdict, tables and figures in one HTML file that needs no network.

The templates stand in `templates`: `frame.html` is what pages share. Pages have no scripts: every
panel of a figure is a picture, which a click makes as wide as the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from model_lab.diagnosis.described import Outcome
from model_lab.learning.learn import Learning
from model_lab.measurements.sample_table import WHOLE_PROTOCOLS
from model_lab.report import tables
from model_lab.report.curves import curves
from model_lab.report.drawing import Drawing, Panel, Scale
from model_lab.report.errors import ladder, ranking, rest
from model_lab.report.learned import picture_of
from model_lab.report.loops import loops, rest_over_input
from model_lab.report.marks import Points
from model_lab.report.parameters import parameters
from model_lab.report.picture import draw_row
from model_lab.report.residuals import oddities, residuals
from model_lab.report.sentences import (
    axis_words,
    counted,
    learned_sentences,
    listed,
    notice_sentence,
    preconditioning_sentence,
    story_sentence,
    tie_sentences,
    verdict_sentence,
)
from model_lab.report.view import View
from softhand_common.documents.output_file import write_file

LEARNED_PAGE, LEARNED_PICTURE = "learned.html", "learned.png"


def write_report(
    outcome: Outcome, path: Path, commands: Sequence[str], learned: Learning | None = None
) -> None:
    """Write the report of a diagnosis to an HTML file.

    commands: shell lines that repeat it. learned: the learned curve, if nothing known explains the
    error; None: none was learned.
    """
    write_file(path, page(View(outcome), commands, learned))


def write_learned(learned: Learning, folder: Path, command: str) -> None:
    """Write the page and the picture of a learned curve to a folder.

    command: the shell line that repeats them.
    """
    text = template("learned.html").render(
        title=f"Learned: {learned.problem.data.title}", learned=learned, commands=[command]
    )
    write_file(folder / LEARNED_PAGE, text)
    draw_row(picture_of(learned), folder / LEARNED_PICTURE)


@lru_cache(maxsize=2)
def template(name: str) -> Template:
    """The template of this package with that name."""
    environment = Environment(
        loader=PackageLoader("model_lab", "report/templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["number"] = tables.is_number
    environment.globals |= {
        "tables": tables,
        "ladder": ladder,
        "curves": curves,
        "loops": loops,
        "rest_over_input": rest_over_input,
        "residuals": residuals,
        "oddities": oddities,
        "ranking": ranking,
        "parameters": parameters,
        "rest": rest,
        "proposal": proposal,
        "picture_of": picture_of,
        "learned_words": learned_sentences,
    }
    return environment.get_template(name)


def page(view: View, commands: Sequence[str], learned: Learning | None = None) -> str:
    """The whole report as HTML text. commands, learned: as for `write_report`."""
    return template("page.html").render(
        view=view,
        data=view.data,
        diagnosis=view.diagnosis,
        title=f"Model lab: {view.data.title}",
        verdict=verdict_sentence(view.diagnosis),
        ties=tie_sentences(view.diagnosis),
        story=story_sentence(view.diagnosis),
        notice=notice_sentence([notice.text for notice in view.outcome.notices]),
        facts=_facts(view),
        rest_words=_rest(view),
        learned=learned,
        commands=commands,
    )


def _facts(view: View) -> str:
    data = view.data
    samples = sum(run.samples for run in data.runs)
    held = "protocols with all their repeats" if data.table.holdout == WHOLE_PROTOCOLS else "blocks"
    return (
        f"Experiment {data.experiment.replace('_', ' ')}: {counted(len(data.runs), 'run')}, "
        f"{counted(samples, 'sample')}, {counted(len(data.specimens), 'specimen')}, "
        f"{counted(len(data.protocols()), 'protocol')}. All errors are root mean squares over "
        f"{held} that were held out of the fit. {preconditioning_sentence(data)}".strip()
    )


def _rest(view: View) -> str:
    rest_of, shown = view.diagnosis.unexplained, view.display.shown
    if not rest_of.rms > 0.0:
        return "Nothing above the noise floor."
    against = listed([axis_words(name, view.data.experiment) for name in rest_of.against])
    varies = f"; it varies with {against}" if against else ""
    floor = shown(view.diagnosis.noise_floor)
    return f"{shown(rest_of.rms)} (rms) above the noise floor of {floor}{varies}."


# ---------------------------------------------------------------------- the next experiment
def proposal(view: View) -> Drawing | None:
    """Figure of the input in the proposed experiment; None if none is proposed, or if it is one of
    valve pulses.
    """
    planned = view.diagnosis.next_experiment
    if planned is None or planned["duration"] is None:
        return None
    kelvin = view.data.shown_in("K").shown(planned["temperature"])
    mount = str(planned["mount"]).replace("_", " ")
    caption = (
        f"{str(planned['description']).capitalize()}, within {planned['duration']:.3g} s, with "
        f"specimen {planned['specimen']} at {kelvin}, mounted {mount}. In it the explanations that "
        f"are still tied differ by {planned['separation']:.3g} sigma of the noise of a run."
    )
    inputs = planned["inputs"]
    name = "stretch" if "stretch" in inputs else "pressure"
    display = view.data.shown_in("" if name == "stretch" else "Pa")
    shown = display.factor * np.array(inputs[name], float)
    course = Points(np.array(inputs["time"], float), shown, "after", width=1.6)
    panel = Panel((course,), Scale("time [s]"), Scale(f"{name} [{display.unit or '-'}]"))
    alt = f"Course of the input: {planned['description']}"
    return Drawing("next", "Next experiment", caption, alt, (panel,))
