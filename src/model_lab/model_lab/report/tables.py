"""Tables of a report as plain text. A table without rows is not shown."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from model_lab.diagnosis.result import correlation
from model_lab.fitting.noise_floor import REPEATS, SPLINE, STATED
from model_lab.learning.learn import Learning
from model_lab.learning.words import alternative_rows, curve_rows
from model_lab.localisation.axes import axes_of
from model_lab.report.parameters import parameter_estimates
from model_lab.report.residuals import axis_title
from model_lab.report.view import View

TABLE_RUNS = 400  # in the table of runs
CALIBRATED = {"modulus_scale": "shear modulus of a batch over the stated one"}
FLOOR_WORDS = {
    REPEATS: "from the scatter of repeats",
    STATED: "as stated in experiment.yaml",
    SPLINE: "from what a smoothing spline leaves (there are no repeats)",
}


class Table(NamedTuple):
    """A table of plain text: head, and rows of cells."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def is_number(cell: str) -> bool:
    """Whether a cell is a number, which is then aligned to the right."""
    return cell[:1].isdigit() or (cell[:1] in "-+" and cell[1:2].isdigit())


def before_and_after(view: View) -> Table:
    """Table of the errors of the models before and after, beside the noise floor."""
    floor = view.outcome.problem.floor
    shown = view.display.shown
    found = [view.accuracy(scored) for _, scored in view.models]
    rows = [
        ["held-out error (rms)", *(shown(entry.rmse) for entry in found)],
        ["held-out error over noise floor", *(_ratio(e.rmse / floor.total) for e in found)],
        ["fit of held-out data", *(f"{entry.fit:.1f} %" for entry in found)],
        ["error of the fitted data (rms)", *(shown(scored.fit.rmse) for _, scored in view.models)],
        ["largest held-out error", *(shown(entry.largest) for entry in found)],
        ["free parameters", *(str(len(scored.fit.values)) for _, scored in view.models)],
    ]
    return Table(["", "before", "after"] if view.after else ["", "model"], rows)


def floor_note(view: View) -> str:
    """A sentence on the noise floor."""
    floor, shown = view.outcome.problem.floor, view.display.shown
    return (
        f"Noise floor {shown(floor.total)} (95 % bound {shown(floor.upper)}), "
        f"{FLOOR_WORDS[floor.source]}{_floor_parts(view)}."
    )


def _ratio(value: float) -> str:
    """Such as 1.24, 118 or 1190."""
    return f"{value:.3g}" if value < 1000.0 else f"{float(f'{value:.3g}'):.0f}"


def _floor_parts(view: View) -> str:
    """The parts of the floor that can be estimated from the set."""
    floor, shown = view.outcome.problem.floor, view.display.shown
    if floor.source != REPEATS:
        return "; what differs from run to run is not known"
    return f"; {shown(floor.within)} within a run, {shown(floor.between)} between runs"


def runs(view: View) -> Table:
    """Table of the held-out errors of all runs; of very many runs, the worst ones."""
    head = ["run", "specimen", "protocol", "temperature", "samples"]
    head += ["error before", "error after"] if view.after else ["error"]
    rows = []
    squares = [s.held_out.residual**2 for _, s in view.models]
    counts = np.bincount(view.data.table.run)
    errors = np.sqrt([np.bincount(view.data.table.run, square) / counts for square in squares])
    for index in np.sort(np.argsort(-errors[-1])[:TABLE_RUNS]):
        run = view.data.runs[index]
        warm = view.data.shown_in("K").shown(run.temperature)
        shown = [view.display.shown(float(error)) for error in errors[:, index]]
        rows.append([run.name, run.specimen, run.protocol, warm, str(run.samples), *shown])
    return Table(head, rows)


def failures(view: View) -> Table | None:
    """Table of where the model as it was fails; None if it does not."""
    titles = {axis.name: axis_title(axis) for axis in axes_of(view.data)}
    rows = [
        [
            titles.get(entry.against, entry.against),
            entry.where,
            f"{100 * entry.share_of_error:.0f} %",
            f"{entry.p_value:.1g}",
        ]
        for entry in view.diagnosis.failures
    ]
    head = ["against", "where", "share of the error", "p-value"]
    return Table(head, rows) if rows else None


def ranking(view: View) -> Table:
    """Table of every effect that was tried alone."""
    rows = [
        [
            entry.name,
            view.display.shown(entry.rmse_heldout),
            f"{entry.delta_bic:.0f}",
            f"{entry.p_value:.2g}",
            "yes" if entry.plausible else "no: on a limit",
        ]
        for entry in view.diagnosis.ranking
    ]
    head = ["effect", "held-out error", "BIC against without", "p-value", "plausible"]
    return Table(head, rows)


def parameters(view: View) -> Table:
    """Table of the fitted parameters of the best model, with units and meanings."""
    classes = view.outcome.problem.classes
    said = {
        f"{name}.{parameter.name}": parameter.description
        for name in view.best.effects
        for parameter in classes[name].parameters
    }
    rows = [
        [
            name,
            f"{entry.value:.4g}",
            f"{entry.std:.2g}",
            f"{entry.interval[0]:.4g} to {entry.interval[1]:.4g}",
            entry.unit or "-",
            said.get(name) or CALIBRATED.get(name.partition("[")[0], ""),
        ]
        for name, entry in parameter_estimates(view).items()
    ]
    head = ["parameter", "value", "standard error", "95 % interval", "unit", "what it is"]
    return Table(head, rows)


def not_visible(view: View) -> Table | None:
    """Table of the effects that these data cannot show, grouped by reason; None without any."""
    by_reason: dict[str, list[str]] = {}
    for entry in view.diagnosis.not_visible:
        by_reason.setdefault(entry.reason, []).append(entry.name)
    rows = [[reason, ", ".join(names)] for reason, names in by_reason.items()]
    return Table(["reason", "effects"], rows) if rows else None


def story(view: View) -> Table | None:
    """Table of how the error falls with each effect, or with those that help; None for a single
    named effect.
    """
    steps, floor = view.steps, view.diagnosis.noise_floor
    if len(steps) < 3 and not view.diagnosis.helps:
        return None
    rows = [
        [
            after.label.removeprefix("+ "),
            view.display.shown(before.rmse),
            view.display.shown(after.rmse),
            f"{before.rmse / after.rmse:.3g}-fold",
            _ratio(after.rmse / floor),
        ]
        for before, after in pairwise(steps)
    ]
    head = ["added", "before", "after", "falls", "over floor"]
    return Table(head, rows)


def correlations(view: View) -> list[tuple[str, list[float]]]:
    """(name of a parameter, its correlation with every parameter) for all fitted parameters; empty
    for fewer than two.
    """
    names = [name.partition(".")[2] or name for name in view.best.fit.likelihood.names]
    rows = correlation(view.best).tolist()
    return list(zip(names, rows, strict=True)) if len(names) > 1 else []


def shade(value: float) -> str:
    """Colours, as CSS, of a cell with a correlation: orange below 0, violet above, the darker the
    nearer to 1 in magnitude.
    """
    hue = "#5E3C99" if value > 0.0 else "#B35806"
    strong = min(abs(value), 1.0)
    return f"background:{hue}{round(255 * strong):02x};color:{'#fff' if strong > 0.6 else '#222'}"


def learned_curves(learned: Learning) -> list[Table]:
    """Tables of the learned curves at their knots."""
    found = map(curve_rows, learned.curves)
    return [Table(head, rows) for head, *rows in found]


def alternatives(learned: Learning) -> Table:
    """Table of the curves that were fitted together with the model."""
    head, *rows = alternative_rows(learned)
    return Table(head, rows)


def detectable(view: View) -> Table | None:
    """Table of the weakest value of each effect that the data would have shown; None
    without any.
    """
    classes = view.outcome.problem.classes
    rows = []
    for entry in view.diagnosis.detectable:
        units = {parameter.name: parameter.unit for parameter in classes[entry.name].parameters}
        value = view.data.shown_in(units[entry.parameter]).shown(entry.smallest, 2)
        rows.append([entry.name, entry.parameter, value])
    return Table(["effect", "parameter", "weakest that would have shown"], rows) if rows else None
