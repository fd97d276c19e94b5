"""Variation of a dimension along an actuator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array


class Profile(Protocol):
    """A dimension [m] as a function of the position x [m] from the base."""

    def __call__(self, x: ArrayLike) -> Array:
        """Value [m] at x [m]; positions outside the actuator take the value at its end."""


@dataclass(frozen=True)
class ConstantProfile:
    """The same value [m] everywhere."""

    value: float

    def __call__(self, x: ArrayLike) -> Array:
        """Value [m] at x [m]."""
        return np.full(np.shape(x), self.value)


@dataclass(frozen=True)
class TableProfile:
    """Straight lines between points (x [m], value [m]) with rising x."""

    x: tuple[float, ...]
    value: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.x) < 2 or len(self.x) != len(self.value) or np.any(np.diff(self.x) <= 0.0):
            raise ValueError(
                f"profile: expected at least two [x, value] with growing x, got x = {list(self.x)}"
            )

    def __call__(self, x: ArrayLike) -> Array:
        """Value [m] at x [m]."""
        return np.interp(np.asarray(x, float), self.x, self.value)


@dataclass(frozen=True)
class TaperedProfile:
    """The profiles of section 7.3: maximum*(1 - taper*x/length)**(1/root) [m].

    Circumference: taper 1, root 3 (ERRATUM: the text prints x/x_tip for 1 - x/x_tip, with x from
    the base); width: taper 0.925, root 8.

    >>> round(float(TaperedProfile(0.02, 0.09, 0.925, 8)(0.09)), 4)
    0.0145
    """

    maximum: float
    length: float
    taper: float
    root: float

    def __call__(self, x: ArrayLike) -> Array:
        """Value [m] at x [m]."""
        relative = np.clip(np.asarray(x, float) / self.length, 0.0, 1.0)
        return self.maximum * (1.0 - self.taper * relative) ** (1.0 / self.root)
