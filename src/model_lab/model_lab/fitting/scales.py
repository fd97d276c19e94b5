"""Coordinates in which the parameters of a fit are searched, and their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from model_lab.aliases import Array, Mask


@dataclass(frozen=True)
class Scales:
    """Search coordinates of parameters: the logarithm of a parameter that spans decades, the value
    of any other. low, high: bounds. width: of the usual range.
    """

    low: Array
    high: Array
    width: Array
    logarithmic: Mask

    @classmethod
    def of(cls, parameters: Sequence[Any]) -> Scales:
        """The search coordinates of free parameters."""
        log = np.array([parameter.logarithmic for parameter in parameters], bool)
        ends = np.array([[p.low, p.high, *p.typical] for p in parameters], float).reshape(-1, 4)
        ends[log] = np.log(ends[log])
        return cls(ends[:, 0], ends[:, 1], np.maximum(ends[:, 3] - ends[:, 2], 1e-12), log)

    def inward(self, values: Array) -> Array:
        """Search coordinates (..., k) of parameter values (..., k)."""
        with np.errstate(divide="ignore"):
            return np.where(
                self.logarithmic, np.log(np.where(self.logarithmic, values, 1.0)), values
            )

    def outward(self, coordinates: Array) -> Array:
        """Parameter values (..., k) of search coordinates (..., k)."""
        return np.where(
            self.logarithmic, np.exp(np.where(self.logarithmic, coordinates, 0.0)), coordinates
        )


def held(scales: Scales, coordinates: Array, gradient: Array) -> Mask:
    """Which parameters lie on a bound and would leave it in the direction `gradient`."""
    below = (coordinates <= scales.low) & (gradient < 0.0)
    return below | ((coordinates >= scales.high) & (gradient > 0.0))
