"""Parameters under which the rubber would give way: the elastic side must grow with the stretch."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from softhand_model.effects.effect import Effect
from softhand_model.effects.staged import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain

HIGHEST_STRETCH = 4.0  # up to which the elastic side has to grow
STEPS = 60


def grows(
    effects: Iterable[Effect], shape: SectionShape, mode: str = "pure_shear"
) -> NDArray[np.bool_]:
    """Whether the elastic side grows up to a stretch of 4 at all sections: (lanes,), of one lane
    for effects with single values.

    shape: arrays (1, rows, sections); mode: of `effects.stages.Strain`. Virgin rubber, at once.
    """
    staged = StagedEffects(effects)
    growing = _in_lanes(np.array(True))
    for effect in staged.elastic:
        growing = growing & _in_lanes(np.asarray(effect.allows(shape)))
    before = None
    for stretch in np.linspace(1.0, HIGHEST_STRETCH, STEPS + 1):
        stress = staged.stress(Strain(np.full((1, 1, 1), stretch), mode), shape, 0.0)
        if before is not None:
            growing = growing & _in_lanes(stress > before)
        before = stress
    return growing


def _in_lanes(everywhere: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether it holds at all rows and sections of each lane."""
    lanes = np.shape(everywhere)[0] if np.ndim(everywhere) == 3 else 1
    return np.all(np.reshape(everywhere, (lanes, -1)), axis=1)
