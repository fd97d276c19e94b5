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
    """A model with effects that were added to it and fitted to data.

    model: the model in SI units, as simulator, monitor and lab take it. additions: one entry per
    added effect, in the order in which they were added.
    """

    model: Model
    additions: tuple[Addition, ...]

    @property
    def errors(self) -> list[float]:
        """Held-out root mean square error before the first effect was added, and after each one, in
        `unit`.
        """
        display = _display(self.additions[0])
        left = [self.additions[0].before, *(one.after for one in self.additions)]
        return [display.factor * one.held_out.rmse for one in left]

    @property
    def unit(self) -> str:
        """Unit of `errors`: the one that the user stated for the (first) output."""
        return _display(self.additions[0]).unit

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the model file. Raises ValueError if the file exists, unless `force`."""
        write_model(Path(path), self.model, force=force)

    def text(self) -> str:
        """The text that `print` shows: errors before and after each effect, and the noise floor."""
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
    """A model by the path of its file, or by the name of a shipped one such as `base`, `gravity`,
    `linear`; a model that is loaded or fitted already is returned as it is.

    effects: Python files with effects of your own, which are run. Raises ValueError for a file that
    is no valid model; the message names file, key, what was expected and what came.
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
    """The measurement set with the outputs that a model predicts in place of the measured ones.

    Args:
        data: measurement set, of which inputs and specimens are used, but not the measured outputs.
        model: shipped name, file, or what `add` returned; its calibration is used as it is, without
            a fit.
        own: Python files of those effects in the model file that are your own.

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
    """The model with effects added one after the other; each time, all effects and the calibration
    of the model are fitted together.

    Args:
        effects: names of the effects to add, or the `effects` of a diagnosis.
        data: measurements to fit to.
        model: the model to which they are added.
        own: Python files with effects of your own, which are run.

    Raises:
        ValueError: no effect is given; one is unknown, already there, or does not show in the data.
    """
    given = [effects] if isinstance(effects, str | NamedEffect) else list(effects)
    names = [one if isinstance(one, str) else one.name for one in given]
    if not names:
        raise ValueError(
            "effects: expected at least one effect to add, got none; if they come from a "
            "diagnosis, it named no missing effect"
        )
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
