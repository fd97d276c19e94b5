"""Report page: verdict, tables and figures in one HTML file without network or scripts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from matplotlib.figure import Figure

from model_lab.diagnosis.diagnose import Outcome
from model_lab.measurements.units import display_of
from model_lab.report import tables
from model_lab.report.curves import curves
from model_lab.report.drawing import COLOURS, Drawing, light_grid
from model_lab.report.errors import ladder, ranking, rest
from model_lab.report.parameters import parameters
from model_lab.report.residuals import residuals
from model_lab.report.sentences import axis_words, listed, tie_sentences, verdict_sentence
from model_lab.report.view import View

CSS = """
:root { color: #1d1d1f; background: #fff; }
body { font: 16px/1.5 "DejaVu Sans", Verdana, system-ui, sans-serif; margin: 0 auto;
  max-width: 62rem; padding: 1.5rem 1.25rem 4rem; }
h1 { font-size: 1.35rem; line-height: 1.35; margin: 0 0 .6rem; }
h2 { font-size: 1.1rem; margin: 2.4rem 0 .6rem; padding-top: .8rem; border-top: 1px solid #ddd; }
p { margin: .5rem 0; }
.verdict { font-size: 1.1rem; border-left: .35rem solid #0072B2; padding: .5rem .9rem;
  background: #f3f7fa; margin: .6rem 0; }
.verdict.unexplained { border-color: #D55E00; background: #fbf4ef; }
.verdict.adequate { border-color: #009E73; background: #f0f8f5; }
.set, figcaption, summary { color: #4a4a4f; font-size: .875rem; }
figure { margin: 1rem 0 1.4rem; }
figure svg { width: 100%; height: auto; display: block; }
figcaption { max-width: 52rem; margin-top: .3rem; }
table { border-collapse: collapse; font-size: .875rem; margin: .6rem 0; }
th, td { text-align: left; padding: .22rem .9rem .22rem 0; border-bottom: 1px solid #e4e4e4;
  vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th { font-weight: 600; color: #4a4a4f; }
details { margin: .5rem 0; overflow-x: auto; }
summary { cursor: pointer; }
pre { background: #f5f5f5; padding: .7rem .9rem; overflow-x: auto; font-size: .85rem; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  figure, table, pre { break-inside: avoid; }
  h2 { break-after: avoid; }
  .verdict { background: none; }
}
"""


def proposal(view: View) -> Drawing | None:
    """Course of the input in the proposed experiment; None when none is proposed, or pulses."""
    planned = view.diagnosis.next_experiment
    if planned is None or planned["duration"] is None:
        return None
    kelvin = display_of("K").shown(planned["temperature"])
    mount = str(planned["mount"]).replace("_", " ")
    caption = (
        f"{str(planned['description']).capitalize()}, within {planned['duration']:.3g} s, with "
        f"specimen {planned['specimen']} at {kelvin}, mounted {mount}. In it the explanations that "
        f"are still tied differ by {planned['separation']:.3g} sigma of the noise of a run."
    )
    return Drawing(
        "next", "Next experiment", caption, f"Course of the input: {planned['description']}", 2.3,
        lambda figure: _draw(figure, view),
    )  # fmt: skip


def _draw(figure: Figure, view: View) -> None:
    planned = view.diagnosis.next_experiment or {}
    inputs = planned["inputs"]
    name = "stretch" if "stretch" in inputs else "pressure"
    display = display_of("" if name == "stretch" else "Pa")
    axes = figure.subplots()
    light_grid(axes)
    shown = [display.factor * value for value in inputs[name]]
    axes.plot(inputs["time"], shown, color=COLOURS["after"], linewidth=1.6)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"{name} [{display.unit or '-'}]")


def write_report(outcome: Outcome, path: Path, commands: Sequence[str]) -> None:
    """Write the report of a diagnosis to an HTML file.

    commands: shell lines that make it again.
    """
    path.write_text(page(View(outcome), commands), encoding="utf-8")


def page(view: View, commands: Sequence[str]) -> str:
    """The whole page."""
    sections = [
        _section("Error and noise floor", tables.before_and_after(view), _figure(ladder(view))),
        _section("Measured and predicted", _figure(curves(view)), _runs(view)),
        _section("Where it fails", _figure(residuals(view)), tables.failures(view)),
        _section("Which effect", _ties(view), _figure(ranking(view)), _ranking(view)),
        _section("Fitted parameters", _figure(parameters(view)), _parameters(view)),
        _section("What is left", _rest(view), _figure(rest(view))),
        _section("What these data cannot show", tables.not_visible(view)),
        _section("What they would have shown", _detectable(view)),
        _section("The next experiment", _figure(proposal(view))),
        _section("Make it again", _commands(commands)),
    ]
    title = f"Model lab: {view.data.title}"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<link rel="icon" href="data:,"><title>{escape(title)}</title><style>{CSS}</style></head>'
        f"<body><main>{_head(view, title)}{''.join(sections)}</main></body></html>\n"
    )


def _head(view: View, title: str) -> str:
    data, diagnosis = view.data, view.diagnosis
    ties = "".join(f" {escape(sentence)}" for sentence in tie_sentences(diagnosis))
    samples = sum(run.samples for run in data.runs)
    held = "protocols with all their repeats" if diagnosis.holdout == "protocols" else "blocks"
    facts = (
        f"Experiment {data.experiment.replace('_', ' ')}: {_count(len(data.runs), 'run')}, "
        f"{_count(samples, 'sample')}, {_count(len(data.specimens), 'specimen')}, "
        f"{_count(len(data.protocols()), 'protocol')}. All errors are root mean squares over "
        f"{held} that were held out of the fit."
    )
    return (
        f'<h1>{escape(title)}</h1><p class="verdict {diagnosis.verdict}">'
        f"<strong>{escape(verdict_sentence(diagnosis))}</strong>{ties}</p>"
        f'<p class="set">{escape(facts)}</p>'
    )


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", " ")


def _section(title: str, *parts: str) -> str:
    """A section; none if it has nothing to show."""
    body = "".join(parts)
    return f"<section><h2>{escape(title)}</h2>{body}</section>" if body else ""


def _figure(drawing: Drawing | None) -> str:
    if drawing is None:
        return ""
    caption = escape(drawing.caption)
    return (
        f'<figure id="{drawing.name}">{drawing.svg()}'
        f"<figcaption><strong>{escape(drawing.title)}.</strong> {caption}</figcaption></figure>"
    )


def _details(summary: str, body: str) -> str:
    return f"<details><summary>{escape(summary)}</summary>{body}</details>"


def _runs(view: View) -> str:
    return _details(f"Every run ({len(view.data.runs)})", tables.runs(view))


def _ties(view: View) -> str:
    return "".join(f"<p>{escape(sentence)}</p>" for sentence in tie_sentences(view.diagnosis))


def _ranking(view: View) -> str:
    count = len(view.diagnosis.ranking)
    return _details(f"Every effect that was tried ({count})", tables.ranking(view)) if count else ""


def _parameters(view: View) -> str:
    return _details("As numbers", tables.parameters(view)) if len(view.best.fit.values) else ""


def _rest(view: View) -> str:
    rest_of, shown = view.diagnosis.unexplained, view.display.shown
    if not rest_of.rms > 0.0:
        return "<p>Nothing above the noise floor.</p>"
    against = listed([axis_words(name) for name in rest_of.against])
    varies = f"; it varies with {against}" if against else ""
    text = (
        f"{shown(rest_of.rms)} (rms) above the noise floor of {shown(view.diagnosis.noise_floor)}"
    )
    return f"<p>{escape(text + varies)}.</p>"


def _detectable(view: View) -> str:
    body = tables.detectable(view)
    return body and (
        "<p>Had one of these effects been there and stronger than this, it would have been found."
        "</p>" + body
    )


def _commands(commands: Sequence[str]) -> str:
    lines = "\n".join(commands)
    return f"<pre>{escape(lines)}</pre>" if lines else ""
