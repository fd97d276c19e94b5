"""What the figures of a report show: curves of each run, errors of each model, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from model_lab.aliases import Array
from model_lab.comparison.compare import Accuracy, accuracy
from model_lab.diagnosis.described import Outcome
from model_lab.diagnosis.result import Diagnosis
from model_lab.diagnosis.search import Scored
from model_lab.fitting.problem import FitProblem
from model_lab.localisation.axes import resting_share
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, MeasurementSet
from model_lab.measurements.sample_table import Series
from model_lab.measurements.units import Display

RESTING_SHARE = 0.5  # share of samples at rest, from which curves over pressure are heaps of dots
TIME_SHOWS = {"time_since_step", "time_in_run", "pressure_rate", "direction"}


@dataclass(frozen=True)
class Repeats:
    """Runs that repeat each other, with the series of one output."""

    title: str
    courses: tuple[Series, ...]


@dataclass(frozen=True)
class Step:
    """A model in the ladder of errors; rmse: its held-out error [SI unit of the outputs]."""

    label: str
    rmse: float


@dataclass(frozen=True)
class View:
    """A diagnosis, its measurement set, and the models that a report compares.

    steps: errors of the model as it was, and after each added effect.
    """

    outcome: Outcome
    steps: tuple[Step, ...] = field(init=False)

    def __post_init__(self) -> None:
        steps = _ladder(self.outcome.problem, self.before, self.diagnosis)
        object.__setattr__(self, "steps", steps)

    @property
    def data(self) -> MeasurementSet:
        """The measurement set in which effects were searched, with long recordings thinned."""
        return self.outcome.problem.data

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis."""
        return self.outcome.diagnosis

    @property
    def before(self) -> Scored:
        """The model as it was, with its calibration fitted."""
        return self.outcome.selection.base

    @property
    def after(self) -> Scored | None:
        """The model with the missing effects; None if none are named."""
        return self.outcome.selection.final if self.diagnosis.effects else None

    @property
    def best(self) -> Scored:
        """The model with the missing effects; if none are named, the one as it was."""
        return self.after or self.before

    @property
    def models(self) -> tuple[tuple[str, Scored], ...]:
        """(colour, model) of the models to compare: before, and after if there is one."""
        after = (("after", self.after),) if self.after else ()
        return (("before", self.before), *after)

    @property
    def residuals(self) -> list[tuple[str, Array]]:
        """(colour, held-out residual (samples,) in SI units) of the models to compare."""
        return [(label, scored.held_out.residual) for label, scored in self.models]

    @property
    def display(self) -> Display:
        """How outputs are shown: in the unit that the user stated."""
        return self.data.display(self.data.outputs[0])

    @property
    def output_name(self) -> str:
        """Name of the measured quantity."""
        outputs = self.data.outputs
        return outputs[0].replace("_", " ") if len(outputs) == 1 else "torque on the base"

    @property
    def measured(self) -> Array:
        """Measured outputs (samples,) in SI units."""
        return self.data.table.value

    def accuracy(self, scored: Scored) -> Accuracy:
        """Accuracy of a model on data that were held out of its fit."""
        return accuracy(self.measured, scored.held_out.residual, self.data.table.output)

    def predicted(self, scored: Scored) -> Array:
        """Predictions (samples,) of a model for data that were held out of its fit, in SI units."""
        return self.measured - scored.held_out.residual

    def panels(self) -> list[Repeats]:
        """Groups of repeats, one for each output."""
        found: dict[tuple[int, int], list[Series]] = {}
        for course in self.data.table.courses:
            found.setdefault((course.group, course.output), []).append(course)
        return [Repeats(self._title(found[key][0]), tuple(found[key])) for key in sorted(found)]

    def _title(self, first: Series) -> str:
        """Specimen and protocol, as far as they differ in the set; temperature if it varies."""
        run = self.data.runs[first.run]
        parts = [run.protocol] if len(self.data.protocols()) > 1 else []
        if len(self.data.specimens) > 1 or not parts:
            parts.append(run.specimen)
        temperatures = [entry.temperature for entry in self.data.runs]
        if max(temperatures) - min(temperatures) > 1.0:
            parts.append(self.data.shown_in("K").shown(run.temperature))
        if len(self.data.outputs) > 1:
            parts.append(self.data.outputs[first.output].removeprefix("torque_"))
        return ", ".join(parts)

    def abscissa(self) -> tuple[str, Display, list[Array]]:
        """(name, unit and factor for display, values run by run in SI units) of the horizontal axis
        of curves.

        It is time if the error depends on time, if there are several inputs, or if the input mostly
        rests; else the input.
        """
        data = self.data
        if data.experiment == "valve_pulse":
            shown = [
                _signed(run.columns["direction"], run.columns["duration"]) for run in data.runs
            ]
            return "pulse duration (negative: deflating)", Display("ms", 1e3), shown
        if data.has_time and self._over_time():
            starts = [run.columns["time"][0] for run in data.runs]
            shown = [run.columns["time"] - t for run, t in zip(data.runs, starts, strict=True)]
            return "time", Display("s"), shown
        name = "stretch" if data.stretched else "pressure"
        display = Display("-") if name == "stretch" else data.shown_in("Pa")
        return name, display, [data.driving(run) for run in data.runs]

    def _over_time(self) -> bool:
        data = self.data
        if data.experiment == "base_torque" or resting_share(data) > RESTING_SHARE:
            return True
        return self._time_matters()

    def _time_matters(self) -> bool:
        named = [entry.name for entry in self.diagnosis.effects]
        for names in self.diagnosis.tied:
            named += names
        classes = self.outcome.problem.classes
        rest = set(self.diagnosis.unexplained.against)
        return bool(rest & TIME_SHOWS) or any(classes[name].has_memory for name in named)


def _signed(direction: Array, durations: Array) -> Array:
    """Durations with the sign of the direction."""
    return np.where(direction == DEFLATE, DEFLATE, INFLATE) * durations


def _ladder(problem: FitProblem, before: Scored, diagnosis: Diagnosis) -> tuple[Step, ...]:
    """Errors of the model as it was and with each missing effect in turn, or with what helps."""
    naive = {"valve_pulse": "naive flow", "base_torque": "static chain"}
    base = naive.get(problem.data.experiment, "linear base" if problem.base == "linear" else "base")
    added = [Step(f"+ {one.name}", one.rmse_after) for one in diagnosis.story or diagnosis.helps]
    return (Step(" + ".join([base, *before.effects]), before.held_out.rmse), *added)
