"""What is asked of a measurement set, and the noise floor by which answers are judged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.fit import Fit, Problem, fit
from model_lab.forward import Forward
from model_lab.input_noise import steadied
from model_lab.measurement import MeasurementSet
from model_lab.noise import NoiseFloor, noise_floor
from model_lab.series import series_of
from model_lab.spectrum import Spectrum, make_spectrum
from softhand_model.effects import Effect
from softhand_model.model_file import Model
from softhand_model.spring_model import THESIS, SpringModel

Array = NDArray[np.float64]

LOWER = 0.9  # floor after an effect over the floor before, from which on the lower one holds


@dataclass(frozen=True)
class Question:
    """What is asked of a set: base model, effects that stay, and how noise is judged.

    fitted: values of the parameters of the model as it is, by name, as found on the way.
    """

    data: MeasurementSet
    base: str
    fixed: tuple[Effect, ...]
    classes: Mapping[str, type[Effect]]
    spectrum: Spectrum
    floor: NoiseFloor
    fitted: Mapping[str, float]
    joints: SpringModel = THESIS

    def problem(self, effects: Iterable[str]) -> Problem:
        """The fitting problem with these effects free."""
        chosen = [self.classes[name] for name in effects]
        forward = Forward(self.data, self.base, chosen, self.fixed, joints=self.joints)
        return Problem(forward, self.spectrum, self.floor.variance, self.floor.gain_known)


def pose_question(
    data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]
) -> tuple[Question, tuple[Effect, ...]]:
    """The question with its noise floor, and the model's effects that are fitted along.

    The floor is seen from the residual of the model as it is, with its calibration fitted. Noise of
    the input is taken off first.
    """
    data = steadied(data)
    given = tuple(effect for effect in model.effects if effect.name in model.std)
    fixed = tuple(effect for effect in model.effects if effect.name not in model.std)
    known = {**classes, **{effect.name: type(effect) for effect in given}}
    free = [type(effect) for effect in given]
    forward = Forward(data, model.base, free, fixed, joints=model.springs)
    starts = base_starts(forward.parameters)
    layout = series_of(data)
    predicted = forward.predict(starts[:1])[0]
    spectrum = make_spectrum(layout, predicted)
    rough = noise_floor(data, spectrum, forward.measured - predicted)
    better = fit(Problem(forward, spectrum, rough.variance, rough.gain_known), starts)
    spectrum = make_spectrum(layout, forward.measured - better.residual)
    floor = noise_floor(data, spectrum, better.residual)
    names = [parameter.name for parameter in forward.parameters]
    fitted = dict(zip(names, better.values.tolist(), strict=True))
    question = Question(data, model.base, fixed, known, spectrum, floor, fitted, model.springs)
    return question, given


def sharper(question: Question, better: Fit) -> Question | None:
    """The question with the floor below a better model, where that is clearly lower.

    Repeats may differ by an effect, such as what earlier runs have left in the rubber.
    """
    floor = noise_floor(question.data, question.spectrum, better.residual)
    return replace(question, floor=floor) if floor.total < LOWER * question.floor.total else None


def base_starts(parameters: Sequence[Any]) -> Array:
    """Starts (n, k) of a search: parameters as they are, and with softer and stiffer batches."""
    start = np.array([p.start for p in parameters], float)
    scales = np.array([p.name.startswith("modulus_scale") for p in parameters], bool)
    if not scales.any():
        return start[None]
    return np.stack([np.where(scales, factor * start, start) for factor in (1.0, 0.9, 1.1)])
