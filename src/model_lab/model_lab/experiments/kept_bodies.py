"""A cache of the bodies of hands and of their shapes, for all models of sets with the same inputs.

The models that a search compares differ in few bodies: if one actuator is softer, all other chains
are as before.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.samples import USUAL_MODULUS_SCALES
from softhand_model.chain.chain import ChainModel
from softhand_model.equilibrium.hand_statics import Shape
from softhand_model.hand.hand import HandDescription
from softhand_model.motion.moving_body import MovingBody

MOST_SETS = 16  # of which bodies are kept at a time
SCALES = 16  # of the modulus, at which shapes are calculated
SCALE_ERROR = 1e-7  # [m] of places, and of the entries of frames

Result = TypeVar("Result")


class Recent(Generic[Result]):
    """A cache of results by key, which keeps the most recently used ones."""

    def __init__(self, most: int) -> None:
        self._most, self._results = most, dict[Hashable, Result]()

    def once(self, key: Hashable, make: Callable[[], Result]) -> Result:
        """The kept result for the key; without one, that of `make`, which is then kept."""
        found = self._results.pop(key) if key in self._results else make()
        while len(self._results) >= self._most:
            del self._results[next(iter(self._results))]
        self._results[key] = found
        return found


class ShapesOverScales:
    """Shapes of a moving body as a function of the scale of its modulus, with all else equal.

    Fits of many models ask for many scales. After SCALES shapes were asked for, polynomials through
    the shapes at SCALES Chebyshev points replace the calculation within USUAL_MODULUS_SCALES, if
    they reproduce two more shapes to within SCALE_ERROR.
    """

    def __init__(self) -> None:
        self._asked, self._nodes = 0, np.zeros(0)
        self._columns: Array | None = None

    def at(self, make: Callable[[float], Shape | None], scale: float) -> Shape | None:
        """The shape of the body with its modulus multiplied by `scale` [-].

        make: function of a scale that calculates the shape, and returns None where there is no
        equilibrium. It is called unless the polynomials are there and cover this scale.
        """
        low, high = USUAL_MODULUS_SCALES
        self._asked += 1
        if self._asked == SCALES + 1:
            self._interpolate(make)
        if self._columns is None or not low <= scale <= high:
            return make(scale)
        return self._between(self._columns, scale)

    def _interpolate(self, make: Callable[[float], Shape | None]) -> None:
        low, high = USUAL_MODULUS_SCALES
        angles = (np.arange(SCALES) + 0.5) * np.pi / SCALES
        self._nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angles)
        self._weights = (-1.0) ** np.arange(SCALES) * np.sin(angles)
        between = 0.5 * (self._nodes[[0, SCALES // 2]] + self._nodes[[1, SCALES // 2 + 1]])
        found = [make(float(scale)) for scale in (*self._nodes, *between)]
        shapes = [shape for shape in found if shape is not None]
        if len(shapes) < len(found):
            return
        columns = np.stack(
            [np.concatenate([one.places[..., None, :], one.frames], axis=2) for one in shapes]
        )
        nodes, exact = columns[:SCALES], columns[SCALES:]
        for scale, expected in zip(between.tolist(), exact, strict=True):
            met = self._between(nodes, scale)
            apart = np.abs(met.places - expected[:, :, 0]), np.abs(met.frames - expected[:, :, 1:])
            if not all(np.all(way < SCALE_ERROR) for way in apart):  # none, without markers
                return
        self._columns = nodes

    def _between(self, columns: Array, scale: float) -> Shape:
        """The polynomials through columns (SCALES, rows, n, 4, 3) at a scale."""
        away = scale - self._nodes
        if not away.all():
            found = columns[int(np.argmin(np.abs(away)))]
        else:
            shares = self._weights / away
            found = np.tensordot(shares / shares.sum(), columns, 1)
        return Shape(found[:, :, 0], found[:, :, 1:])


@dataclass(frozen=True)
class KeptBodies:
    """Caches for one hand and the inputs of one set: models of the hand's chains, its bodies, and
    the shapes of the bodies in all runs.

    Keys of models and bodies have the parameters that effects change; keys of shapes have all
    parameters. over_scales: shapes as functions of the factor on the modulus. parts: skins of
    bodies, and paths along which they move.
    """

    hand: HandDescription
    models: Recent[ChainModel]
    bodies: Recent[MovingBody]
    shapes: Recent[Any]
    over_scales: Recent[ShapesOverScales]
    parts: dict[Hashable, Any]


_SETS: Recent[KeptBodies] = Recent(MOST_SETS)


def kept_bodies(hand: HandDescription, about: Hashable, most: int) -> KeptBodies:
    """The caches of a hand.

    about: number of segments and inputs, as a key. most: largest number of bodies, and of shapes,
    in the caches.
    """
    return _SETS.once(
        (id(hand), about),  # the hand stays as it is while it is kept
        lambda: KeptBodies(hand, Recent(most), Recent(most), Recent(most), Recent(most), {}),
    )
