"""Models: read from files, and with effects added to them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model_lab.api.data import Data, set_of
from model_lab.api.shown import Shown
from model_lab.comparison.add import Addition, add_effect, write_model
from model_lab.diagnosis.result import NamedEffect
from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import Display
from model_lab.own_effects import all_classes, file_of_each, own_classes
from model_lab.report.sentences import effect_words
from softhand_common.progress import Progress
from softhand_model.model_file import Model
from softhand_model.model_file import load_model as read_model

Files = Sequence[str | Path]


@dataclass(frozen=True, repr=False)
class FittedModel(Shown):
    """A model with effects that were added, fitted to data.

    model: the same as simulator, monitor and lab take it, in SI units. additions: each effect as it
    was added, in order.
    """

    model: Model
    additions: tuple[Addition, ...]

    @property
    def errors(self) -> list[float]:
        """Held-out error before, and after each effect, in `unit`."""
        display = _display(self.additions[0])
        left = [self.additions[0].before, *(one.after for one in self.additions)]
        return [display.factor * one.held_out.rmse for one in left]

    @property
    def unit(self) -> str:
        """Unit of the errors: that of the output as the user stated it."""
        return _display(self.additions[0]).unit

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the model file; ValueError if there is one already, unless `force`."""
        write_model(Path(path), self.model, force=force)

    def text(self) -> str:
        """What it prints."""
        errors = [f"{error:.3g}" for error in self.errors]
        lines = [
            f"added {effect_words(one.effect)}: held-out error {before} -> {after} {self.unit}"
            for one, before, after in zip(self.additions, errors, errors[1:], strict=False)
        ]
        last = self.additions[-1]
        floor = _display(last).factor * last.problem.floor.total
        return "\n".join([*lines, f"noise floor {floor:.3g} {self.unit}"])


def _display(addition: Addition) -> Display:
    data = addition.problem.data
    return data.display(data.outputs[0])


Given = FittedModel | Model | str | Path
"""A model as a user may give it: fitted, loaded, or the name of a shipped one or of a file."""


def load_model(model: Given = "base", effects: Files = ()) -> Model:
    """A model by its file, or by the name of a shipped one such as `base`, `gravity`, `linear`.

    effects: Python files with effects of your own, which are run. Raises ValueError that names
    file, key, expected and got.
    """
    if isinstance(model, FittedModel):
        return model.model
    if isinstance(model, Model):
        return model
    paths = [Path(path) for path in effects]
    found = read_model(model, own_classes(paths))
    named = {effect.name for effect in found.effects}
    files = {name: path for name, path in file_of_each(paths).items() if name in named}
    return replace(found, files={**found.files, **files})


def predict(
    data: Data | MeasurementSet | str | Path, model: Given = "base", own: Files = ()
) -> Data:
    """What a model says in place of what was measured: the same set with predicted outputs.

    Args:
        data: of which the inputs and specimens are used; the numbers in its outputs are not.
        model: shipped name, file, or what `add` returned; its calibration is taken as it is.
        own: Python files with effects of your own that the model file names.

    Raises ValueError for data that the model cannot use.
    """
    measured, known = set_of(data), load_model(model, own)
    effects = [one for one in known.effects if measured.experiment in one.experiments]
    forward = Forward(measured, known.base, (), effects, known.calibration, free_calibration=False)
    (values,) = forward.predict(np.zeros((1, 0)))
    table, runs = measured.table, []
    outputs = {
        name: np.concatenate([run.measured([name])[0] for run in measured.runs])
        for name in measured.outputs
    }
    for course in table.courses:
        outputs[measured.outputs[course.output]][table.row[course.samples]] = values[course.samples]
    ends = np.cumsum([run.samples for run in measured.runs])
    for run, end in zip(measured.runs, ends.tolist(), strict=True):
        said = {name: outputs[name][end - run.samples : end] for name in measured.outputs}
        runs.append(replace(run, columns={**run.columns, **said}))
    return Data(replace(measured, runs=tuple(runs), noise={}, wild=()))


def add(
    effects: str | NamedEffect | Iterable[str | NamedEffect],
    data: Data | MeasurementSet | str | Path,
    model: Given = "base",
    own: Files = (),
) -> FittedModel:
    """The model with effects added, one after the other, all fitted together with its calibration.

    Args:
        effects: names, or the `effects` of a diagnosis.
        data: what to fit to.
        model: to add to.
        own: Python files with effects of your own, which are run.

    Raises:
        ValueError: no effect is given; one is unknown, already there, or does not show in the data.
    """
    given = [effects] if isinstance(effects, str | NamedEffect) else list(effects)
    names = [one if isinstance(one, str) else one.name for one in given]
    if not names:
        raise ValueError("effects: expected at least one, got none; a diagnosis may name none")
    known, measured = load_model(model, own), set_of(data)
    paths = [Path(path) for path in own]
    files = {name: path for name, path in file_of_each(paths).items() if name in names}
    additions: list[Addition] = []
    for name in names:
        with Progress("adding") as progress:
            one = add_effect(name, measured, known, all_classes(known, paths), progress)
        known = replace(one.model, files={**known.files, **files})
        additions.append(one)
    return FittedModel(known, tuple(additions))
