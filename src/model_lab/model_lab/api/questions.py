"""What is asked of a model and measurements: how far it is off, what is missing, and what helps."""

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
from model_lab.diagnosis.diagnose import Outcome
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
from model_lab.report.sentences import slip_sentences, verdict_sentence
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
    """How far a model is off, and where. details: the same in SI units, with all that was found."""

    details: Compared
    name: str

    @property
    def error(self) -> float:
        """Root mean square of measured minus predicted over runs held out of the fit, in `unit`."""
        return _shown(self.details.data, self.details.errors.held_out.rmse)

    @property
    def floor(self) -> float:
        """Noise floor, below which no model can go, in `unit`."""
        return _shown(self.details.data, self.details.errors.floor.total)

    @property
    def unit(self) -> str:
        """Unit of the errors: that of the output as the user stated it."""
        return self.details.data.display(self.details.data.outputs[0]).unit

    @property
    def slips(self) -> tuple[Slip, ...]:
        """Mistakes in how the data are stated, such as a unit."""
        return self.details.slips

    @property
    def runs(self) -> dict[str, float]:
        """Held-out error of each run, in `unit`."""
        data = self.details.data
        return {part.name: _shown(data, part.held_out.rmse) for part in self.details.runs}

    def plot(self) -> Figure:
        """Loops of output over input, the residual over the input, and its autocorrelation."""
        return figure_of(*self.drawings())

    def text(self) -> str:
        """What it prints: the text of `model-lab compare`."""
        return comparison_text(self.details, self.name)

    def headline(self) -> str:
        """Error and floor, and slips."""
        said = [
            f"{self.name}: held-out error {self.error:.3g} {self.unit}, "
            f"noise floor {self.floor:.3g} {self.unit}.",
            *slip_sentences(self.slips, self.details.data.output_display),
        ]
        return " ".join(said)

    def tables(self) -> list[Table]:
        """Errors of the runs."""
        rows = [[name, f"{error:.3g}"] for name, error in self.runs.items()]
        return [Table(["run", f"held-out error [{self.unit}]"], rows)]

    def drawings(self) -> list[Drawing]:
        """Figures of a notebook."""
        errors = self.details.errors
        residuals = [("before", errors.residual)]
        return [loops(errors.data, residuals), rest_over_input(errors.data, residuals)]


def compare(data: Measured, model: Given = "base", seed: int = 0, own: Files = ()) -> Comparison:
    """How far a model is off, against the noise floor, and where the error lies.

    Args:
        data: measurements.
        model: shipped name, file, or what `add` returned.
        seed: of tests that draw at random; same seed, same answer.
        own: Python files with effects of your own that the model file names.

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
    """Which effects are missing. outcome: the same in SI units, with the fits behind it."""

    outcome: Outcome

    @property
    def verdict(self) -> str:
        """`adequate`, `effects_missing`, `unexplained`, or `slip`: a mistake in the statement."""
        return self.outcome.diagnosis.verdict

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return verdict_sentence(self.outcome.diagnosis)

    @property
    def effects(self) -> tuple[NamedEffect, ...]:
        """Missing effects, with values, standard errors and 95 % intervals of their parameters, in
        the units that each of them states.
        """
        return self.outcome.diagnosis.effects

    @property
    def tied(self) -> tuple[tuple[str, ...], ...]:
        """Names of what the data cannot tell from each effect."""
        return self.outcome.diagnosis.tied

    @property
    def slips(self) -> tuple[Slip, ...]:
        """Mistakes in how the data are stated; all else is about the mended data."""
        return self.outcome.diagnosis.slips

    @property
    def confidence(self) -> float | None:
        """Share of such verdicts that are right, 0 to 1; None if it is not known."""
        return self.outcome.diagnosis.confidence

    @property
    def next_experiment(self) -> Mapping[str, Any] | None:
        """What would tell apart what is tied: `inputs` (time [s], pressure [Pa] or stretch, lists),
        `specimen`, `mount`, `temperature` [K], `description`, `changes`; None if nothing is.
        """
        return self.outcome.diagnosis.next_experiment

    @property
    def data(self) -> Data:
        """The measurements as they were judged: without slips, long recordings thinned."""
        return Data(self.outcome.problem.data)

    def json(self) -> dict[str, Any]:
        """What `model-lab diagnose --json` writes, in SI units."""
        return self.outcome.diagnosis.as_json()

    def report(self, path: str | Path) -> None:
        """Write the report, an HTML page that needs nothing else."""
        write_report(self.outcome, Path(path), ())

    def plot(self) -> Figure:
        """Loops before and with the missing effects, the residual and its autocorrelation."""
        return figure_of(*self.drawings())

    def text(self) -> str:
        """What it prints: the text of `model-lab diagnose`."""
        return diagnosis_text(self.outcome.diagnosis)

    def headline(self) -> str:
        """The verdict."""
        return self.sentence

    def tables(self) -> list[Table]:
        """Errors before and after, and the effects' parameters."""
        view = View(self.outcome)
        rows = [
            [effect.name, name, f"{e.value:.4g}", *(f"{end:.4g}" for end in e.interval), e.unit]
            for effect in self.effects
            for name, e in effect.parameters.items()
        ]
        named = Table(["effect", "parameter", "value", "95 % from", "to", "unit"], rows)
        return [tables.before_and_after(view), *([named] if rows else [])]

    def drawings(self) -> list[Drawing]:
        """Figures of a notebook."""
        view = View(self.outcome)
        return [loops(view.data, view.residuals), rest_over_input(view.data, view.residuals)]


def diagnose(
    data: Measured, model: Given = "base", seed: int = 0, jobs: int = 1, own: Files = ()
) -> Diagnosis:
    """Which physical effect a model lacks, or what is wrong with how the data are stated.

    Args:
        data: measurements.
        model: shipped name, file, or what `add` returned.
        seed: of what is drawn at random; same seed, same answer.
        jobs: processes.
        own: Python files with effects of your own, which are run and take part.

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
    """The curve that a model lacks. learning: the same with the fits behind it, in SI units."""

    learning: Learning

    def save(self, path: str | Path, force: bool = False) -> list[Path]:
        """Write an effect file a curve, NAME.py, to be given as `own`; ValueError if nothing was
        learned. Returns the files.
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
        """The curve, and the residual with and without it."""
        return figure_of(*self.drawings())

    def text(self) -> str:
        """What it prints."""
        candidates = text_table(words.alternative_rows(self.learning))
        return f"{words.verdict(self.learning)}\n\n{candidates}"

    def headline(self) -> str:
        """What was learned."""
        return words.verdict(self.learning)

    def tables(self) -> list[Table]:
        """The curves at their knots."""
        return tables.learned_curves(self.learning)

    def drawings(self) -> list[Drawing]:
        """Figures of a notebook."""
        return [picture_of(self.learning)]


def learn(data: Measured, model: Given = "base", own: Files = ()) -> Learned:
    """The curve that a model lacks, where no known effect explains the error.

    Args:
        data: measurements.
        model: shipped name, file, or what `add` returned.
        own: Python files with effects of your own that the model file names.

    Raises ValueError for data that the model cannot use.
    """
    known = load_model(model, own)
    with Progress("learning") as progress:
        return Learned(learnt(set_of(data), known, all_classes(known, map(Path, own)), progress))


# ---------------------------------------------------------------------- ladder
@dataclass(frozen=True, repr=False)
class Ladder(Shown):
    """Errors of several models side by side. rungs: the same in SI units."""

    rungs: Rungs

    @property
    def errors(self) -> dict[str, float]:
        """Held-out error of each model, in the unit of the output as the user stated it."""
        data = self.rungs.data
        return {one.name: _shown(data, one.errors.held_out.rmse) for one in self.rungs.rungs}

    def text(self) -> str:
        """What it prints: the text of `model-lab ladder`."""
        return ladder_text(self.rungs)

    def headline(self) -> str:
        """The best of them."""
        return f"The smallest held-out error is that of {self.rungs.best.name}."

    def tables(self) -> list[Table]:
        """Errors of the models."""
        unit = self.rungs.data.display(self.rungs.data.outputs[0]).unit
        rows = [[name, f"{error:.3g}"] for name, error in self.errors.items()]
        return [Table(["model", f"held-out error [{unit}]"], rows)]


def ladder(data: Measured, models: Mapping[str, Given] | Sequence[Given]) -> Ladder:
    """Errors of several models, by the names that are given, or by their own.

    Raises ValueError for data that a model cannot use, naming it.
    """
    named = models if isinstance(models, Mapping) else {_name_of(one): one for one in models}
    loaded: dict[str, Model] = {name: load_model(one) for name, one in named.items()}
    with Progress("comparing") as progress:
        return Ladder(compare_models(set_of(data), loaded, progress))
