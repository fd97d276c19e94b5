"""What the lab says of measurements on disk: `python scripts/measure_real_data.py [FOLDER]`.

FOLDER holds measurement sets, one folder each; its default is the environment variable
SOFTHAND_MEASUREMENTS. Prints tables in Markdown, writes a report of each set to out/real-data;
--figure draws measured and predicted curves of all of them. A set is diagnosed with the base model
if its specimens have the sizes that the model needs, else with `linear`. For tensile tests the last
table has the results of plain least squares.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.optimize import least_squares

from model_lab.comparison.compare import Comparison, compare
from model_lab.diagnosis.diagnose import Outcome, diagnose
from model_lab.diagnosis.result import NamedEffect, named_effect
from model_lab.learning.learn import learn
from model_lab.learning.words import words_of
from model_lab.localisation.axes import resting_share
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import display_of
from model_lab.report.page import write_report
from softhand_common.documents.output_file import save_figure
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.progress import Progress
from softhand_model.model_file import Model, load_model

Array = NDArray[np.float64]

VARIABLE = "SOFTHAND_MEASUREMENTS"
SHOWN = 7  # runs of a set in the picture
HEAD = (
    "set", "model", "runs", "samples", "held-out error", "noise floor", "verdict",
    "missing", "error with it", "best effect alone", "error with it", "the rest varies with",
)  # fmt: skip
LEARNED = (
    "set", "learned", "tied with", "held-out error", "with the curves", "falls by",
    "processor time",
)  # fmt: skip


def sets_in(folder: Path) -> list[Path]:
    """Folders of measurement sets in a folder, by name."""
    return sorted(path.parent for path in folder.glob("*/experiment.yaml"))


def fitting_model(data: MeasurementSet) -> tuple[str, Model]:
    """The base model, or `linear` for an actuator of another kind."""
    try:
        model = load_model("base")
        compare(data, model)
    except DocumentError:
        return "linear", load_model("linear")
    return "base", model


def row(name: str, model: str, data: MeasurementSet, outcome: Outcome) -> list[str]:
    """Results of the lab for one set."""
    found, shown = outcome.diagnosis, display_of(data.unit).shown
    best = next(iter(outcome.selection.singles), None)
    return [
        f"`{name}`",
        model,
        str(len(data.runs)),
        str(sum(run.samples for run in data.runs)),
        shown(found.rmse_before),
        f"{shown(found.noise_floor)} ({found.noise_floor_source})",
        f"`{found.verdict}`",
        "; ".join(_named(found.effects, found.tied)) or "-",
        shown(found.rmse_after) if found.effects else "-",
        _words(named_effect(best, best.added)) if best else "-",
        shown(best.held_out.rmse) if best else "-",
        ", ".join(_noun(data, axis) for axis in found.unexplained.against) or "-",
    ]


def _noun(data: MeasurementSet, axis: str) -> str:
    """An axis in words: what drives a test of rubber is the stretch."""
    said = axis.replace("pressure", "stretch") if data.stretched else axis
    return said.replace("_", " ")


def learned(name: str, data: MeasurementSet, model: Model) -> list[str]:
    """What `learn` finds in one set, and the error before and after."""
    started = time.process_time()
    found, shown = learn(data, model), display_of(data.unit).shown
    seconds = time.process_time() - started
    curves = "; ".join(one.shape.title[:-1] for one in found.curves) or found.reason
    ties = [words_of(one.shape) for one in found.others if found.is_tied(one)]
    more = [f"{len(ties) - 2} more"] if len(ties) > 2 else []
    tied = ", ".join([*ties[:2], *more]) or "-"
    before, after = found.base.held_out.rmse, found.final.held_out.rmse
    errors = [shown(before), shown(after), f"{before / after:.1f}"]
    return [f"`{name}`", curves, tied, *errors, f"{seconds:.0f} s"]


def _named(effects: tuple, tied: tuple) -> list[str]:
    """Named effects with parameters, errors and ties."""
    words = []
    for effect, others in zip(effects, tied, strict=True):
        ties = f", tied with {', '.join(f'`{name}`' for name in others)}" if others else ""
        words.append(f"{_words(effect)}{ties}")
    return words


def _words(effect: NamedEffect) -> str:
    """An effect with its parameters and their standard errors."""
    values = [f"{name} = {e.value:.3g} ± {e.std:.2g}" for name, e in effect.parameters.items()]
    return f"`{effect.name}` ({', '.join(values)})"


def failures(name: str, comparison: Comparison) -> list[list[str]]:
    """Where the model fails by more than chance."""
    return [
        [
            f"`{name}`",
            _noun(comparison.data, axis.against),
            axis.where,
            f"{axis.share_of_error:.0%}",
        ]
        for axis in comparison.localisation.failures
    ]


# ---------------------------------------------------------------------- by plain least squares
def _invariant(stretch: Array) -> Array:
    return stretch**2 + 2.0 / stretch - 3.0


LAWS: dict[str, tuple[Callable[..., Array], tuple[float, ...]]] = {
    "neo-Hooke": (lambda x: x - x**-2, ()),
    "Yeoh, two terms": (lambda x, c2: (x - x**-2) * (1.0 + 2.0 * c2 * _invariant(x)), (0.02,)),
    "Gent": (lambda x, jm: (x - x**-2) / (1.0 - _invariant(x) / max(jm, 18.0)), (60.0,)),
    "Mooney-Rivlin": (lambda x, b: (x - x**-2) * (1.0 + b / x) / (1.0 + b), (0.5,)),
    "Ogden, one term": (lambda x, a: 2.0 / a * (x ** (a - 1.0) - x ** (-a / 2 - 1.0)), (2.2,)),
}  # nominal stress over the shear modulus of small strains


def fitted_laws(data: MeasurementSet) -> list[list[str]]:
    """Laws of rubber with a free shear modulus, fitted to all the samples of a tensile test."""
    stretch = np.concatenate([run.columns["stretch"] for run in data.runs])
    stress = np.concatenate([run.columns["stress"] for run in data.runs])
    given = next(iter(data.specimens.values())).values["shear_modulus"]
    rows = []
    for law, (shape, start) in LAWS.items():
        found = least_squares(lambda v, f=shape: v[0] * f(stretch, *v[1:]) - stress / given,
                              (1.0, *start), x_scale=np.abs((1.0, *start)))  # fmt: skip
        error = np.sqrt(np.mean(found.fun**2)) * given
        values = ", ".join(f"{value:.3g}" for value in found.x[1:]) or "-"
        rows.append([law, f"{found.x[0] * given / 1e3:.1f} kPa", values, f"{error / 1e3:.2f} kPa"])
    return rows


# ---------------------------------------------------------------------- as a picture
def draw(found: dict[str, Comparison], path: Path) -> None:
    """Measured dots and the lines of the model fitted to all the data, one panel for each set."""
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    grid = figure.subplots(-(-len(found) // 2), 2, squeeze=False).flat
    for axes, (name, comparison) in zip(grid, found.items(), strict=False):
        _draw_set(axes, comparison)
        axes.set_title(name, fontsize=9)
    save_figure(figure, path, dpi=100)


def _draw_set(axes: Axes, comparison: Comparison) -> None:
    data, errors = comparison.data, comparison.errors
    display, over_time = display_of(data.unit), data.has_time and resting_share(data) > 0.5
    for index in np.unique(np.linspace(0, len(data.runs) - 1, SHOWN).round().astype(int)):
        run, mine = data.runs[index], errors.table.run == index
        driving = data.driving(run)
        at = run.columns["time"] if over_time else driving / (1e3 if driving.max() > 1e3 else 1.0)
        measured = display.factor * errors.table.value[mine]
        predicted = measured - display.factor * errors.residual_as_is[mine]
        axes.plot(at, measured, ".", color="0.45", markersize=2)
        axes.plot(at, predicted, color="#D55E00", linewidth=1.0)
    stretched = data.stretched
    axes.set_xlabel("time [s]" if over_time else "stretch" if stretched else "pressure [kPa]")
    axes.set_ylabel(f"{data.outputs[0].replace('_', ' ')} [{display.unit}]")


def table(head: tuple[str, ...], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [list(head), ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def main(arguments: list[str]) -> int:
    """Print the tables; 1 without measurements."""
    parser = argparse.ArgumentParser(description="what the lab says of measurements on disk")
    parser.add_argument("folder", nargs="?", default=os.environ.get(VARIABLE), type=Path)
    parser.add_argument("--reports", type=Path, default=Path("out/real-data"))
    parser.add_argument("--figure", type=Path, help="picture of all sets")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args(arguments)
    if given.folder is None or not sets_in(given.folder):
        print(f"no measurement sets: name a folder or set {VARIABLE}", file=sys.stderr)
        return 1
    rows, curves, where, laws, compared = [], [], [], [], {}
    for path in sets_in(given.folder):
        try:
            data = load_measurements(path)
        except DocumentError as reason:  # such as an experiment that the lab does not know
            print(f"left out: {reason}", file=sys.stderr)
            continue
        name, model = fitting_model(data)
        with Progress(f"diagnosing {path.name}") as progress:
            outcome = diagnose(data, model, jobs=given.jobs, tell=progress)
        report = given.reports / path.name / "report.html"
        report.parent.mkdir(parents=True, exist_ok=True)
        command = f"model-lab diagnose {path} --model {name} --report {report.parent}"
        write_report(outcome, report, [command])
        rows.append(row(path.name, name, data, outcome))
        compared[path.name] = compare(data, model)
        curves.append(learned(path.name, data, model))
        where += failures(path.name, compared[path.name])
        if data.experiment == "uniaxial":
            laws += [[f"`{path.name}`", *line] for line in fitted_laws(data)]
    if given.figure is not None:
        draw(compared, given.figure)
    print(table(HEAD, rows))
    print(table(LEARNED, curves))
    print(table(("set", "against", "where the model fails", "share of the error"), where))
    print(table(("set", "law", "shear modulus", "its parameter", "error (rms)"), laws), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
