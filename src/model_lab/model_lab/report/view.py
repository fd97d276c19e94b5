"""What the figures of a report show: curves of each run, errors of each model, as plain arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_lab.comparison.compare import Accuracy, accuracy
from model_lab.diagnosis.diagnose import Outcome
from model_lab.diagnosis.result import EFFECTS_MISSING, Diagnosis
from model_lab.diagnosis.search import Scored, Unseen, score_with
from model_lab.fitting.problem import Question
from model_lab.localisation.axes import driving_input, resting_share
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, MeasurementSet
from model_lab.measurements.units import Display, display_of

Array = NDArray[np.float64]

MOSTLY = 0.5  # share of samples at rest, from which curves over pressure are heaps of dots
TIME_SHOWS = {"time_since_step", "time_in_run", "pressure_rate", "direction"}


@dataclass(frozen=True)
class Trace:
    """One output of one run: its samples in the layout of the set."""

    run: int
    output: int
    samples: slice


@dataclass(frozen=True)
class Panel:
    """Runs that repeat each other, seen by one output."""

    title: str
    traces: tuple[Trace, ...]


@dataclass(frozen=True)
class Step:
    """A rung of the ladder of errors: held-out root mean square [unit of the outputs]."""

    label: str
    rmse: float


@dataclass(frozen=True)
class View:
    """A diagnosis with the set that was searched, and the models that a report compares.

    after: the model with the missing effects, None if none are named.
    """

    outcome: Outcome
    steps: tuple[Step, ...] = field(init=False)

    def __post_init__(self) -> None:
        steps = _ladder(self.outcome.question, self.before, self.after)
        object.__setattr__(self, "steps", steps)

    @property
    def data(self) -> MeasurementSet:
        """The set; of long recordings as many samples as were searched."""
        return self.outcome.question.data

    @property
    def diagnosis(self) -> Diagnosis:
        """What is said."""
        return self.outcome.diagnosis

    @property
    def before(self) -> Scored:
        """The model as it was, with its calibration fitted."""
        return self.outcome.selection.base

    @property
    def after(self) -> Scored | None:
        """The model with the missing effects."""
        named = self.diagnosis.verdict == EFFECTS_MISSING
        return self.outcome.selection.final if named else None

    @property
    def best(self) -> Scored:
        """The best model that the diagnosis stands by."""
        return self.after or self.before

    @property
    def models(self) -> tuple[tuple[str, Scored], ...]:
        """Models to compare by the names of their colours: before, and after if there is one."""
        after = (("after", self.after),) if self.after else ()
        return (("before", self.before), *after)

    @property
    def display(self) -> Display:
        """How outputs are shown."""
        return display_of(self.data.unit)

    @property
    def measured(self) -> Array:
        """Measured outputs (samples,) in SI units."""
        return self.before.fit.problem.forward.measured

    def accuracy(self, scored: Scored) -> Accuracy:
        """How near a model comes to runs that it was not fitted to."""
        output = [np.full(t.samples.stop - t.samples.start, t.output) for t in self.traces()]
        return accuracy(self.measured, scored.held_out.residual, np.concatenate(output))

    def predicted(self, scored: Scored) -> Array:
        """What a model predicts (samples,) for runs that it was not fitted to."""
        return self.measured - scored.held_out.residual

    def traces(self) -> list[Trace]:
        """All runs and outputs in the order of the samples."""
        found, start = [], 0
        for index, run in enumerate(self.data.runs):
            for output in range(len(self.data.outputs)):
                found.append(Trace(index, output, slice(start, start + run.samples)))
                start += run.samples
        return found

    def panels(self) -> list[Panel]:
        """Repeats together, one panel for each output."""
        by_run: dict[int, list[Trace]] = {}
        for trace in self.traces():
            by_run.setdefault(trace.run, []).append(trace)
        panels = []
        for group in self.data.groups():
            for output in range(len(self.data.outputs)):
                title = self._title(group, output)
                panels.append(Panel(title, tuple(by_run[run][output] for run in group)))
        return panels

    def _title(self, group: Sequence[int], output: int) -> str:
        """Specimen and protocol, as far as they differ in the set; temperature if it varies."""
        run = self.data.runs[group[0]]
        parts = [run.protocol] if len(self.data.protocols()) > 1 else []
        if len(self.data.specimens) > 1 or not parts:
            parts.append(run.specimen)
        temperatures = [entry.temperature for entry in self.data.runs]
        if max(temperatures) - min(temperatures) > 1.0:
            parts.append(display_of("K").shown(run.temperature))
        if len(self.data.outputs) > 1:
            parts.append(self.data.outputs[output].removeprefix("torque_"))
        return ", ".join(parts)

    def abscissa(self) -> tuple[str, Display, list[Array]]:
        """Name, unit and values, run by run, of what curves are drawn against.

        Time where the error has to do with it, where several inputs act or the input mostly rests;
        else what drives the runs.
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
        name = "stretch" if data.experiment == "uniaxial" else "pressure"
        display = Display("-") if name == "stretch" else display_of("Pa")
        return name, display, [driving_input(run, data.experiment) for run in data.runs]

    def _over_time(self) -> bool:
        data = self.data
        if data.experiment == "base_torque" or resting_share(data) > MOSTLY:
            return True
        return self._time_matters()

    def _time_matters(self) -> bool:
        named = [entry.name for entry in self.diagnosis.effects]
        for names in self.diagnosis.tied:
            named += names
        classes = self.outcome.question.classes
        rest = set(self.diagnosis.unexplained.against)
        return bool(rest & TIME_SHOWS) or any(classes[name].has_memory for name in named)


def _signed(direction: Array, durations: Array) -> Array:
    """Durations with the sign of the direction."""
    return np.where(direction == DEFLATE, DEFLATE, INFLATE) * durations


def _ladder(question: Question, before: Scored, after: Scored | None) -> tuple[Step, ...]:
    """Errors of the model as it was and with each missing effect in turn."""
    naive = {"valve_pulse": "naive flow", "base_torque": "static chain"}
    base = naive.get(
        question.data.experiment, "linear base" if question.base == "linear" else "base"
    )
    steps = [Step(" + ".join([base, *before.effects]), before.held_out.rmse)]
    if after is None:
        return tuple(steps)
    added = [name for name in after.effects if name not in before.effects]
    between = before
    for effect in added[:-1]:
        scored = score_with(question, between, effect)
        if isinstance(scored, Unseen):  # seen only together with the next
            return (*steps, Step("+ " + " + ".join(added), after.held_out.rmse))
        between = scored
        steps.append(Step(f"+ {effect}", between.held_out.rmse))
    return (*steps, Step(f"+ {added[-1]}", after.held_out.rmse))
