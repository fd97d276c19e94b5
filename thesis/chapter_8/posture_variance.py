"""Dimensions of grasp postures against those of their actuation, and the part of the difference
that is due to the object (8.2.3, 8.2.4, Fig. 8.14).

The thesis compares residual variances of two principal component analyses, of fingertips and of
actuation. A nonlinear map from four channels needs more than four linear components by itself. So
the same air in an empty hand is the control: only dimensions of postures with an object beyond
those of the control count as interaction.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thesis.chapter_8.gaussian_process import cross_validated_errors

Array = NDArray[np.float64]

LINEAR = "linear in actuation"
NONLINEAR = "not linear in actuation, interaction not shown"
INTERACTION = "interaction with the object"
LEVEL = 0.05  # of tests; intervals have 95 %
EXPLAINED = 0.95  # share of the variance up to which components are counted


def residual_variance(points: Array) -> Array:
    """Share (..., d + 1) of the variance of points (..., n, d) that remains after removing their
    first 0 to d principal components.

    >>> points = np.array([[0.0, 3.0], [0.0, -3.0], [1.0, 0.0], [-1.0, 0.0]])
    >>> residual_variance(points).round(12).tolist()
    [1.0, 0.1, 0.0]
    """
    variances, _ = _components(points)
    return _shares(variances, variances.sum(axis=-1))


def noise_floor(trials: Array) -> Array:
    """Noise part of `residual_variance` of the mean of two trials (2, ..., n, d): the variance
    beyond each component of half their difference, whose covariance is that of the mean's noise.
    """
    return _residual_and_noise(trials)[1]


def _residual_and_noise(trials: Array) -> tuple[Array, Array]:
    variances, directions = _components(trials.mean(axis=0))
    noise = (0.5 * (trials[0] - trials[1]) @ directions) ** 2
    total = variances.sum(axis=-1)
    return _shares(variances, total), _shares(noise.sum(axis=-2), total)


def _components(points: Array) -> tuple[Array, Array]:
    """Sums of squares (..., d) along the principal components of points (..., n, d), the largest
    first, and their directions (..., d, d) as columns.
    """
    centred = _centred(points)
    values, directions = np.linalg.eigh(np.swapaxes(centred, -1, -2) @ centred)
    return np.maximum(values[..., ::-1], 0.0), directions[..., ::-1]


def _centred(points: Array) -> Array:
    return np.asarray(points - points.mean(axis=-2, keepdims=True))


def _shares(parts: Array, total: Array) -> Array:
    """Share of a total that remains beyond its first 0, 1, ... parts; 0 for a total of 0, as of a
    resample with a single grasp.
    """
    beyond = np.cumsum(parts[..., ::-1], axis=-1)[..., ::-1]
    none = np.zeros_like(beyond[..., :1])
    whole = np.where(total > 0.0, total, np.inf)[..., None]
    return np.concatenate([beyond, none], axis=-1) / whole


def participation_ratio(points: Array) -> float:
    """Effective number of dimensions of points (n, d): squared sum over sum of squares of the
    variances of their components.

    >>> participation_ratio(np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]))
    2.0
    """
    variances, _ = _components(points)
    return float(variances.sum() ** 2 / (variances**2).sum())


def components_to(points: Array, share: float = EXPLAINED) -> int:
    """Principal components of points (n, d) that together explain a share of their variance."""
    return int(np.argmax(residual_variance(points) <= 1.0 - share + 1e-12))


@dataclass(frozen=True)
class Estimate:
    """A value, its 95 % interval under the bootstrap, and how likely it is 0 or less: the share of
    resamples in which it is (one-sided). A resample has some grasps twice and so spans less than
    the grasps do: the interval is that of the resamples about their mean, laid about the value;
    `p` is of the resamples as they are, and so on the safe side.
    """

    value: float
    low: float
    high: float
    p: float

    @classmethod
    def of(cls, value: float, resampled: Array) -> Estimate:
        """From the values of resamples (b,)."""
        low, high = _interval(value, resampled)
        p = (1 + np.count_nonzero(resampled <= 0)) / (1 + len(resampled))
        return cls(float(value), float(low), float(high), float(p))

    @property
    def shown(self) -> bool:
        """Whether it is above 0."""
        return self.p < LEVEL


def _interval(value: Any, resampled: Array) -> tuple[Array, Array]:
    """Ends of the 95 % interval of resamples (b, ...) about their mean, laid about the value."""
    low, high = np.quantile(resampled, [LEVEL / 2, 1 - LEVEL / 2], axis=0)
    return value + low - resampled.mean(axis=0), value + high - resampled.mean(axis=0)


@dataclass(frozen=True)
class GraspPostures:
    """Fingertips of n grasps, two trials each, and what their actuation was.

    Args:
        actuation: (n, channels) [-], inflation as shares of the limits.
        held: (2, n, d) [m], with the object.
        empty: (2, n, d) [m], the same air without an object.
        resamples: of the bootstrap over grasps.
        seed: of it.

    Raises:
        ValueError: the shapes do not fit.
    """

    actuation: Array
    held: Array
    empty: Array
    resamples: int = 2000
    seed: int = 0

    def __post_init__(self) -> None:
        expected = (2, len(self.actuation), self.held.shape[-1])
        for name in ("held", "empty"):
            if getattr(self, name).shape != expected:
                raise ValueError(
                    f"{name}: expected shape {expected}, got {getattr(self, name).shape}"
                )

    @property
    def channels(self) -> int:
        """Of the actuation; the postures' components beyond so many are what is looked at."""
        return self.actuation.shape[1]

    @cached_property
    def _drawn(self) -> NDArray[np.intp]:
        """Grasps (resamples, n) of each resample; the same for all, so that they are paired."""
        count = len(self.actuation)
        return np.random.default_rng(self.seed).integers(0, count, (self.resamples, count))

    @cached_property
    def _residuals(self) -> dict[str, tuple[Array, Array]]:
        """Residual variance and noise floor (resamples + 1, d + 1) of both; first of the grasps."""
        whole = np.arange(len(self.actuation))[None]
        drawn = np.concatenate([whole, self._drawn])
        return {
            name: _residual_and_noise(trials[:, drawn])
            for name, trials in (("held", self.held), ("empty", self.empty))
        }

    def curve(self, name: str) -> tuple[Array, Array, Array]:
        """Residual variance (d + 1,) of `held` or `empty`, and the ends of its 95 % interval."""
        found = self._residuals[name][0]
        return found[0], *_interval(found[0], found[1:])

    def floor(self, name: str) -> Array:
        """Noise floor (d + 1,) of `held` or `empty`."""
        return self._residuals[name][1][0]

    def actuation_curve(self) -> Array:
        """Residual variance (channels + 1,) of the actuation."""
        return residual_variance(self.actuation)

    @cached_property
    def beyond(self) -> dict[str, Estimate]:
        """Residual variance beyond as many components as there are channels, less its noise."""
        return {name: Estimate.of(found[0], found[1:]) for name, found in self._beyond.items()}

    @cached_property
    def _beyond(self) -> dict[str, Array]:
        at = self.channels
        return {
            name: residual[:, at] - floor[:, at]
            for name, (residual, floor) in self._residuals.items()
        }

    @cached_property
    def excess(self) -> Estimate:
        """What postures with an object have beyond, more than those of the empty hand; paired."""
        found = self._beyond["held"] - self._beyond["empty"]
        return Estimate.of(found[0], found[1:])

    def beyond_length(self, name: str) -> float:
        """The same residual as a length [m]: rms over grasps of the distance of all fingertips."""
        mean = _centred(getattr(self, name).mean(axis=0))
        share = max(0.0, self.beyond[name].value)
        return float(np.sqrt(share * (mean**2).sum() / len(mean)))

    @cached_property
    def unpredicted(self) -> dict[str, float]:
        """Share of the fingertips' variance that a regression does not predict from actuation, less
        what is noise.
        """
        return {name: float(found[0]) for name, found in self._unpredicted.items()}

    @cached_property
    def unpredicted_excess(self) -> Estimate:
        """What of it there is with an object more than in the empty hand; paired."""
        found = self._unpredicted["held"] - self._unpredicted["empty"]
        return Estimate.of(found[0], found[1:])

    @cached_property
    def _unpredicted(self) -> dict[str, Array]:
        drawn = np.concatenate([np.arange(len(self.actuation))[None], self._drawn])
        found = {}
        for name in ("held", "empty"):
            first, second = getattr(self, name)
            mean = 0.5 * (first + second)
            noise = (0.25 * (first - second) ** 2).sum(axis=1)
            errors = cross_validated_errors(self.actuation, mean) - noise
            spread = (_centred(mean) ** 2).sum(axis=1)
            whole = spread[drawn].sum(axis=1)
            found[name] = errors[drawn].sum(axis=1) / np.where(whole > 0.0, whole, np.inf)
        return found

    @property
    def kind(self) -> str:
        """What the postures are: LINEAR, NONLINEAR or INTERACTION."""
        if not self.beyond["held"].shown:
            return LINEAR
        return INTERACTION if self.excess.shown else NONLINEAR


def correlations(actuation: Array) -> Array:
    """Correlation (channels, channels) of the channels; 0 for one that is always the same."""
    centred = _centred(actuation)
    lengths = np.linalg.norm(centred, axis=0)
    scaled = centred / np.where(lengths > 0, lengths, np.inf)
    return scaled.T @ scaled + np.diag((lengths == 0).astype(float))
