"""Effects as candidates: which could show in a set at all, where their search starts, and what
they achieve on noise alone.

What candidates achieve on noise alone: the largest improvement that any of them finds in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from model_lab.fitting.fit import Fit, Problem
from model_lab.fitting.noise_floor import Spectrum
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect, Parameter

Array = NDArray[np.float64]

GRID = {0: 1, 1: 7, 2: 4, 3: 3}  # trial values of each parameter, by their number
LARGEST_GRID = 16
ROUNDING = 1e-9
SMALLEST_SIGNATURE = 0.25  # of the noise floor: what an effect must change to be seen at all


@dataclass(frozen=True)
class Signature:
    """What an effect would change beyond the model it is added to.

    values (trials, k): its parameters. change (trials, samples): whitened coefficients, less what
    the model's own parameters take up. size (trials,): root mean square of that in the outputs'
    unit; raw (trials,): before the model's parameters take their part. usual (2, k): ends of the
    usual ranges.
    """

    values: Array
    usual: Array
    change: Array
    size: Array
    raw: Array


def inapplicable(effect: type[Effect], data: MeasurementSet, base: str) -> str | None:
    """Why an effect cannot show in this set, before any calculation; None if it may."""
    if effect.unseen_in.get(data.experiment):
        return effect.unseen_in[data.experiment]
    if data.experiment not in effect.experiments:
        return f"does not act in {data.experiment}"
    if effect.has_memory and not data.has_time:
        return "the set has no time column, and it depends on what was before"
    if base not in effect.bases:
        return f"has no meaning beside the base {base}"
    return None


def trial_values(effect: type[Effect]) -> Array:
    """Trial values (trials, k) over the typical ranges of an effect's parameters.

    A single parameter is tried at its bounds too: an effect may be far stronger than usual.
    """
    count = len(effect.parameters)
    points = [_points(parameter, GRID.get(count, 2)) for parameter in effect.parameters]
    if not points:
        return np.zeros((1, 0))
    grid = np.array(list(product(*points)))
    if len(grid) > LARGEST_GRID:
        grid = grid[:: int(np.ceil(len(grid) / LARGEST_GRID))]
    return grid


def _points(parameter: Parameter, count: int) -> Array:
    low, high = parameter.typical or (parameter.low, parameter.high)
    points = (np.geomspace if parameter.logarithmic else np.linspace)(low, high, count)
    if count == GRID[1]:
        points = np.unique([parameter.low, *points, parameter.high])
    return np.asarray(points[points != parameter.neutral])


def signature(problem: Problem, fit: Fit, effect: type[Effect]) -> Signature:
    """Signatures of an effect of `problem` at trial values, the other parameters as in `fit`.

    fit is that of the model without the effect.
    """
    trials = trial_values(effect)
    lanes = with_trials(problem, fit, effect.name, trials)
    moved = fit.residual - problem.residuals(lanes)
    spectrum = problem.spectrum
    weight = np.sqrt(1.0 / fit.variance)[spectrum.bands]
    change = spectrum.coefficients(moved) * weight
    change[~np.isfinite(change)] = 0.0
    raw = np.sqrt(np.mean(moved**2, axis=1))
    own = spectrum.coefficients(np.ascontiguousarray(fit.jacobian.T)) * weight
    basis = np.linalg.qr(own.T)[0] if len(own) else np.zeros((change.shape[1], 0))
    change = change - (change @ basis) @ basis.T
    size = np.sqrt(np.mean((change / weight) ** 2, axis=1))
    ends = np.array([p.typical or (p.low, p.high) for p in effect.parameters], float)
    usual = ends.reshape(-1, 2).T + ROUNDING * np.ptp(ends.reshape(-1, 2), axis=1) * [[-1], [1]]
    return Signature(trials, usual, change, size, raw)


def with_trials(problem: Problem, fit: Fit, effect: str, trials: Array) -> Array:
    """Parameters (trials, k) of `problem`: those of a fit by name, trial values for one effect."""
    fitted = dict(zip(names(fit.problem), fit.values.tolist(), strict=True))
    parameters = problem.forward.parameters
    known = np.array([fitted.get(p.name, p.start) for p in parameters], float)
    lanes = np.tile(known, (len(trials), 1))
    lanes[:, [index for index, p in enumerate(parameters) if p.effect == effect]] = trials
    return lanes


def names(problem: Problem) -> list[str]:
    """Names of a problem's parameters."""
    return [parameter.name for parameter in problem.forward.parameters]


def starts(found: Signature, fit: Fit) -> Array:
    """Trial values (n, k) of the effect from which the search begins: at most two usual ones."""
    as_it_is, scaled = _improvements(found, fit)
    usual = np.all((found.values >= found.usual[0]) & (found.values <= found.usual[1]), axis=1)
    scores = (np.where(usual, score, -np.inf) for score in (as_it_is, scaled))
    best = dict.fromkeys(int(np.argmax(score)) for score in scores)
    return found.values[list(best)]


def promised_improvement(found: Signature, fit: Fit) -> float:
    """Fall of the deviance that the best signature, made smaller or larger, would bring."""
    return float(np.max(_improvements(found, fit)[1]))


def _improvements(found: Signature, fit: Fit) -> tuple[Array, Array]:
    """Fall of the weighted squares (trials,) by each signature as it is, and scaled at best."""
    weight = np.sqrt(1.0 / fit.variance)[fit.problem.spectrum.bands]
    along = found.change @ (fit.coefficients * weight)
    square = np.sum(found.change**2, axis=1)
    scaled = np.where(along > 0.0, along**2 / np.where(square > 0.0, square, 1.0), 0.0)
    return 2.0 * along - square, scaled


def invisible(found: Signature, floor: float) -> str | None:
    """Why an effect does not show in these runs however strong it is; None if it does."""
    if found.raw.max() < SMALLEST_SIGNATURE * floor:
        return "changes nothing in these runs"
    if found.size.max() < SMALLEST_SIGNATURE * floor:
        return "acts like the calibration or the effects already in the model"
    return None


DRAWS = 2000


def null_maxima(signatures: Sequence[Signature], spectrum: Spectrum, seed: int) -> Array:
    """Largest fall of the deviance over all candidates (draws,), sorted, in sets of mere noise.

    Noise of every band is drawn with a level that is itself only known from that band's
    coefficients. Each candidate is represented by its signatures, scaled as suits it best.
    """
    changes = [found.change[found.size > 0.0] for found in signatures]
    stacked = np.concatenate([change for change in changes if len(change)] or [np.zeros((0, 1))])
    if not len(stacked):
        return np.zeros(DRAWS)
    stacked = stacked / np.linalg.norm(stacked, axis=1, keepdims=True)
    random = np.random.default_rng(seed)
    drawn = np.zeros((DRAWS, len(stacked)))
    for band, count in enumerate(spectrum.counts()):
        part = stacked[:, spectrum.bands == band]
        level, vectors = np.linalg.eigh(part @ part.T)
        root = vectors * np.sqrt(np.maximum(level, 0.0))
        spread = np.sqrt(count / random.chisquare(count, DRAWS))
        drawn += spread[:, None] * (random.standard_normal((DRAWS, len(root))) @ root.T)
    return np.sort(np.max(drawn**2, axis=1))


def p_value(maxima: Array, improvement: float) -> float:
    """Share of noise sets in which some candidate improves as much; one of them at least."""
    beyond = len(maxima) - int(np.searchsorted(maxima, improvement))
    return (beyond + 1) / (len(maxima) + 1)
