"""Questions about a model and measurements: how large the error is, what is missing, and what
helps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from model_lab.api.data import Data, set_of
from model_lab.api.model import Files, Given, load_model
from model_lab.api.shown import Shown, figure_of
from model_lab.comparison.compare import Comparison as Compared
from model_lab.comparison.compare import compare as compared
from model_lab.comparison.ladder import Ladder as Rungs
from model_lab.comparison.ladder import compare_models
from model_lab.diagnosis.described import Outcome
from model_lab.diagnosis.diagnose import diagnose as diagnosed
from model_lab.diagnosis.result import NamedEffect
from model_lab.learning import words
from model_lab.learning.effect_file import files_of, text_of
from model_lab.learning.learn import Learning
from model_lab.learning.learn import learn as learnt
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.own_effects import all_classes
from model_lab.report import tables
from model_lab.report.comparison_text import comparison_text, ladder_text
from model_lab.report.drawing import Drawing
from model_lab.report.learned import picture_of
from model_lab.report.loops import loops, rest_over_input
from model_lab.report.page import write_report
from model_lab.report.sentences import learned_sentences, slip_sentences, verdict_sentence
from model_lab.report.tables import Table
from model_lab.report.text import diagnosis_text, text_table
from model_lab.report.view import View
from model_lab.slips.slip import Slip
from softhand_common.documents.output_file import write_new
from softhand_common.progress import Progress
from softhand_model.model_file import Model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Measured = Data | MeasurementSet | str | Path


def _shown(data: MeasurementSet, error: float) -> float:
    """An error in the unit of the output as the user stated it."""
    return float(data.display(data.outputs[0]).factor * error)


# ---------------------------------------------------------------------- compare
@dataclass(frozen=True, repr=False)
class Comparison(Shown):
    """The error of a model, and where it occurs.

    details: all results, in SI units. name: name of the model.
    """

    details: Compared
    name: str

    @property
    def error(self) -> float:
        """Root mean square of measured minus predicted values, each predicted by a fit without its
        own data (held out), in `unit`.
        """
        return _shown(self.details.data, self.details.errors.held_out.rmse)

    @property
    def floor(self) -> float:
        """Noise floor, in `unit`: the error that measurement noise leaves to any model."""
        return _shown(self.details.data, self.details.errors.floor.total)

    @property
    def unit(self) -> str:
        """Unit of the errors: the one that the user stated for the (first) output."""
        return self.details.data.display(self.details.data.outputs[0]).unit

    @property
    def slips(self) -> tuple[Slip, ...]:
        """Slips: mistakes in how the data are stated, such as a wrong unit."""
        return self.details.slips

    @property
    def runs(self) -> dict[str, float]:
        """Held-out root mean square error of each run, by its name, in `unit`."""
        data = self.details.data
        return {part.name: _shown(data, part.held_out.rmse) for part in self.details.runs}

    def plot(self) -> Figure:
        """Figure of output over input, and of the residual over input and its autocorrelation."""
        return figure_of(*self.drawings())

    def text(self) -> str:
        """The text that `print` shows: that of `model-lab compare`."""
        return comparison_text(self.details, self.name)

    def headline(self) -> str:
        """Sentences on error, noise floor and slips."""
        said = [
            f"{self.name}: held-out error {self.error:.3g} {self.unit}, "
            f"noise floor {self.floor:.3g} {self.unit}.",
            *slip_sentences(self.slips, self.details.data.output_display, self.details.fits_mended),
        ]
        return " ".join(said)

    def tables(self) -> list[Table]:
        """A table of the errors of the runs."""
        rows = [[name, f"{error:.3g}"] for name, error in self.runs.items()]
        return [Table(["run", f"held-out error [{self.unit}]"], rows)]

    def drawings(self) -> list[Drawing]:
        """The figures that a notebook shows."""
        errors = self.details.errors
        residuals = [("before", errors.residual)]
        return [loops(errors.data, residuals), rest_over_input(errors.data, residuals)]


def compare(data: Measured, model: Given = "base", seed: int = 0, own: Files = ()) -> Comparison:
    """Compute the error of a model relative to the noise floor, and where the error occurs.

    Args:
        data: measurement set, or the path of its folder.
        model: shipped name, file, or what `add` returned.
        seed: seed of all random draws; the same seed gives the same answer.
        own: Python files of those effects in the model file that are your own.

    Raises ValueError for data that the model cannot use.
    """
    with Progress("comparing") as progress:
        found = compared(set_of(data), load_model(model, own), seed, progress)
    return Comparison(found, _name_of(model))


def _name_of(model: Given) -> str:
    if isinstance(model, str | Path):
        return str(model)
    known = load_model(model)
    return " + ".join([known.base, *(effect.name for effect in known.effects)])


# ---------------------------------------------------------------------- diagnose
@dataclass(frozen=True, repr=False)
class Diagnosis(Shown):
    """The effects that a model lacks.

    outcome: all results, in SI units, with the fits behind them.
    """

    outcome: Outcome

    @property
    def verdict(self) -> str:
        """One of `adequate`, `effects_missing`, `unexplained` and `slip` (a mistake in the
        description of the data).
        """
        return self.outcome.diagnosis.verdict

    @property
    def sentence(self) -> str:
        """The verdict as a sentence."""
        return verdict_sentence(self.outcome.diagnosis)

    @property
    def effects(self) -> tuple[NamedEffect, ...]:
        """The missing effects. Each has its parameters with value, standard error and 95 %
        interval, in the unit that the parameter states.
        """
        return self.outcome.diagnosis.effects

    @property
    def tied(self) -> tuple[tuple[str, ...], ...]:
        """For each effect of `effects`, in order: names of other effects that explain the data as
        well.
        """
        return self.outcome.diagnosis.tied

    @property
    def slips(self) -> tuple[Slip, ...]:
        """Slips: mistakes in how the data are stated. All other results are about the data without
        them.
        """
        return self.outcome.diagnosis.slips

    @property
    def confidence(self) -> float | None:
        """Share (0 to 1) of verdicts of this kind that are right; None if it is not known."""
        return self.outcome.diagnosis.confidence

    @property
    def next_experiment(self) -> Mapping[str, Any] | None:
        """The run that would best separate tied effects; None if none are tied, or no run can.

        Keys: `inputs` (lists: time [s], pressure [Pa] or stretch [-]), `specimen`, `mount`,
        `temperature` [K], `description`, `changes`.
        """
        return self.outcome.diagnosis.next_experiment

    @property
    def data(self) -> Data:
        """The measurements that were judged: slips are corrected, and long recordings have fewer
        samples.
        """
        return Data(self.outcome.problem.data)

    def json(self) -> dict[str, Any]:
        """The dictionary that `model-lab diagnose --json` writes, in SI units."""
        return self.outcome.diagnosis.as_json()

    def report(self, path: str | Path) -> None:
        """Write the report: one HTML page that needs no other files."""
        write_report(self.outcome, Path(path), ())

    def plot(self) -> Figure:
        """Figure of output over input, of the residual over input, and of its autocorrelation, each
        before and with the missing effects.
        """
        return figure_of(*self.drawings())

    def text(self) -> str:
        """The text that `print` shows: that of `model-lab diagnose`."""
        return diagnosis_text(self.outcome.diagnosis)

    def headline(self) -> str:
        """The verdict as a sentence."""
        return self.sentence

    def tables(self) -> list[Table]:
        """A table of the errors before and after, and one of the effects' parameters."""
        view = View(self.outcome)
        rows = [
            [effect.name, name, f"{e.value:.4g}", *(f"{end:.4g}" for end in e.interval), e.unit]
            for effect in self.effects
            for name, e in effect.parameters.items()
        ]
        named = Table(["effect", "parameter", "value", "95 % from", "to", "unit"], rows)
        return [tables.before_and_after(view), *([named] if rows else [])]

    def drawings(self) -> list[Drawing]:
        """The figures that a notebook shows."""
        view = View(self.outcome)
        return [loops(view.data, view.residuals), rest_over_input(view.data, view.residuals)]


def diagnose(
    data: Measured, model: Given = "base", seed: int = 0, jobs: int = 1, own: Files = ()
) -> Diagnosis:
    """Find the physical effects that a model lacks, or mistakes in the description of the data.

    Args:
        data: measurement set, or the path of its folder.
        model: shipped name, file, or what `add` returned.
        seed: seed of all random draws; the same seed gives the same answer.
        jobs: number of processes that share the search.
        own: Python files with effects of your own, which are run and searched with the others.

    Raises ValueError for data that the model cannot use.
    """
    known = load_model(model, own)
    classes = all_classes(known, map(Path, own))
    with Progress("diagnosing") as progress:
        found = diagnosed(set_of(data), known, classes, seed, jobs, progress)
    return Diagnosis(found)


# ---------------------------------------------------------------------- learn
@dataclass(frozen=True, repr=False)
class Learned(Shown):
    """The curve that a model lacks.

    learning: the result in SI units, with the fits behind it.
    """

    learning: Learning

    def save(self, path: str | Path, force: bool = False) -> list[Path]:
        """Write one effect file (Python) per curve, to be given as `own`, and return their paths:
        `path` for the first curve, numbered names for others.

        Raises ValueError if nothing was learned, or if a file exists, unless `force`.
        """
        curves = self.learning.curves
        if not curves:
            raise ValueError(f"nothing was learned: {self.learning.reason}")
        files = files_of(Path(path))[: len(curves)]
        data = self.learning.problem.data
        origin = f" from {data.title or data.experiment}"
        for curve, file in zip(curves, files, strict=True):
            values, spread = curve.values.tolist(), curve.spread.tolist()
            write_new(file, text_of(curve.shape, file.stem, values, spread, origin), force)
        return files

    def plot(self) -> Figure:
        """Figure of the curve, and of the residual with and without it."""
        return figure_of(*self.drawings())

    def text(self) -> str:
        """The text that `print` shows: what was learned, and the curves that were tried."""
        candidates = text_table(words.alternative_rows(self.learning))
        return f"{learned_sentences(self.learning)}\n\n{candidates}"

    def headline(self) -> str:
        """A sentence on what was learned."""
        return learned_sentences(self.learning)

    def tables(self) -> list[Table]:
        """Tables of the curves: values at their knots."""
        return tables.learned_curves(self.learning)

    def drawings(self) -> list[Drawing]:
        """The figures that a notebook shows."""
        return [picture_of(self.learning)]


def learn(data: Measured, model: Given = "base", own: Files = ()) -> Learned:
    """Learn the curve that a model lacks, for data that no known effect explains.

    Args:
        data: measurement set, or the path of its folder.
        model: shipped name, file, or what `add` returned.
        own: Python files of those effects in the model file that are your own.

    Raises ValueError for data that the model cannot use.
    """
    known = load_model(model, own)
    with Progress("learning") as progress:
        return Learned(learnt(set_of(data), known, all_classes(known, map(Path, own)), progress))


# ---------------------------------------------------------------------- ladder
@dataclass(frozen=True, repr=False)
class Ladder(Shown):
    """Errors of several models on the same data.

    rungs: the models with all their errors, in SI units.
    """

    rungs: Rungs

    @property
    def errors(self) -> dict[str, float]:
        """Held-out root mean square error of each model, by its name, in the unit that the user
        stated for the (first) output.
        """
        data = self.rungs.data
        return {one.name: _shown(data, one.errors.held_out.rmse) for one in self.rungs.rungs}

    def text(self) -> str:
        """The text that `print` shows: that of `model-lab ladder`."""
        return ladder_text(self.rungs)

    def headline(self) -> str:
        """A sentence that names the model with the smallest error."""
        return f"The smallest held-out error is that of {self.rungs.best.name}."

    def tables(self) -> list[Table]:
        """A table of the errors of the models."""
        unit = self.rungs.data.display(self.rungs.data.outputs[0]).unit
        rows = [[name, f"{error:.3g}"] for name, error in self.errors.items()]
        return [Table(["model", f"held-out error [{unit}]"], rows)]


def ladder(data: Measured, models: Mapping[str, Given] | Sequence[Given]) -> Ladder:
    """Compare several models with the same data.

    Args:
        data: measurement set, or the path of its folder.
        models: models by the names under which they are shown, or a list of models, which are shown
            by their own names.

    Raises ValueError for data that a model cannot use; the message names the model.
    """
    named = models if isinstance(models, Mapping) else {_name_of(one): one for one in models}
    loaded: dict[str, Model] = {name: load_model(one) for name, one in named.items()}
    with Progress("comparing") as progress:
        return Ladder(compare_models(set_of(data), loaded, progress))
