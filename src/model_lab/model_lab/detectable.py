"""What would have shown: the weakest value of each effect that a set lets one see."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from model_lab.diagnosis import Detectable
from model_lab.question import Question
from model_lab.search import Scored
from model_lab.selection import Selection

Array = NDArray[np.float64]

SMALLEST_SHOWN = 0.5  # rms of an effect over the floor that makes an error material


def detectable_effects(question: Question, selection: Selection) -> list[Detectable]:
    """For each effect that could show, the weakest value of its first parameter that would have."""
    found = []
    for scored in selection.singles:
        effect = question.classes[scored.added]
        if effect.parameters and scored.signature is not None:
            smallest = _weakest(scored, selection.threshold, SMALLEST_SHOWN * question.floor.total)
            if smallest is not None:
                found.append(Detectable(effect.name, effect.parameters[0].name, smallest))
    return found


def _weakest(scored: Scored, threshold: float, material_size: float) -> float | None:
    """Value of the first parameter at which signature and size just suffice, between trials."""
    signature = scored.signature
    if signature is None:
        return None
    strength = np.minimum(
        np.sum(signature.change**2, axis=1) / threshold, (signature.size / material_size) ** 2
    )
    middle = np.all(signature.values[:, 1:] == _medians(signature.values[:, 1:]), axis=1)
    values, strength = signature.values[middle, 0], strength[middle]
    shown = np.flatnonzero(strength >= 1.0)
    if not len(shown):
        return None
    weakest = int(shown[np.argmin(strength[shown])])
    hidden = np.flatnonzero(strength < 1.0)
    if not len(hidden):
        return float(values[weakest])
    other = int(hidden[np.argmax(strength[hidden])])
    share = np.log(strength[weakest]) / np.log(strength[weakest] / strength[other])
    return float(values[weakest] + share * (values[other] - values[weakest]))


def _medians(values: Array) -> Array:
    """Middle trial value (k,) of each column, one of those that occur."""
    return np.array([np.unique(column)[len(np.unique(column)) // 2] for column in values.T])
