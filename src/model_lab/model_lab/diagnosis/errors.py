"""Errors by which models are judged: beyond the noise floor, and shares of it that are left."""

from __future__ import annotations

import numpy as np
from scipy.stats import f as variance_ratio

from model_lab.aliases import Array, Mask
from model_lab.diagnosis.search import Scored
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.sample_table import BLOCKS

FEWEST_FOLDS = 3
MATERIAL = 1.12  # held-out error over the floor beyond which something is worth looking for
NEAR_FLOOR = 1.3  # held-out error over the floor that counts as explained
STILL_NEAR = 3.75  # held-out error over the floor beyond which nothing counts as explained
SHAPE_MARGIN = 1.25  # held-out error but for gains over a floor that knows nothing of gains
LIKELY = 0.02  # chance from which on errors are taken for the scatter of repeats
SURE = 5e-3  # chance at which errors are taken to exceed the scatter of repeats
REMOVED = 0.5  # share of the excess error that an effect must remove
OF_ANOTHER_FORM = 0.35  # share of the excess error that an effect of another form may leave


def has_few_folds(problem: FitProblem) -> bool:
    """Whether what is held out is extrapolated: of two protocols one says little of the other."""
    return len(problem.data.table.folds) < FEWEST_FOLDS


def error_of(problem: FitProblem, scored: Scored) -> float:
    """Error by which a model is judged: the held-out one; with few folds, that of the fit."""
    return scored.fit.rmse if has_few_folds(problem) else scored.held_out.rmse


def shape_error(problem: FitProblem, scored: Scored) -> float:
    """The same but for the gains of runs, in which they scatter most."""
    residual = scored.fit.residual if has_few_folds(problem) else scored.held_out.residual
    spectrum = problem.spectrum
    power = spectrum.power(spectrum.coefficients(residual[None]))[0]
    return float(np.sqrt(power[~_gains(problem)].sum() / problem.data.table.samples))


def _gains(problem: FitProblem) -> Mask:
    """Bands (bands,) of the gains of runs: the first of every output."""
    output = problem.spectrum.band_output
    return np.asarray(np.searchsorted(output, output) == np.arange(len(output)))


def excess(problem: FitProblem, scored: Scored) -> float:
    """Error beyond the noise floor, in the unit of the outputs."""
    return _beyond(error_of(problem, scored), problem.floor.total)


def share_left(problem: FitProblem, after: Scored, before: Scored) -> float:
    """Share of a model's excess error that another leaves: of all of it, or of that of its shape,
    whichever is less. Where runs scatter in gain, the shape tells more.
    """
    counts = problem.spectrum.counts() * ~_gains(problem)
    shape = float(np.sqrt(counts @ problem.floor.variance / problem.data.table.samples))
    left = [
        (excess(problem, after), excess(problem, before)),
        (_beyond(shape_error(problem, after), shape), _beyond(shape_error(problem, before), shape)),
    ]
    return min(part / whole if whole > 0.0 else 1.0 for part, whole in left)


def _beyond(error: float, floor: float) -> float:
    return float(np.sqrt(max(error**2 - floor**2, 0.0)))


def foretells(problem: FitProblem, after: Scored, before: Scored) -> bool:
    """Whether effects predict what was held out, though it is extrapolated: they remove of its
    excess error what they must, and leave no more than effects may at all. A drift that is fitted
    to a slip of one run says nothing of the other.
    """
    floor = problem.floor.total
    rest, whole = (_beyond(scored.held_out.rmse, floor) for scored in (after, before))
    return rest <= (1.0 - REMOVED) * whole and after.held_out.rmse <= STILL_NEAR * floor


def lowers(problem: FitProblem, after: Scored, before: Scored) -> bool:
    """Whether a model's error, or that of its shape, falls by what is material at all."""
    errors = error_of, shape_error
    return any(error(problem, before) > MATERIAL * error(problem, after) for error in errors)


def material(problem: FitProblem, scored: Scored) -> bool:
    """Whether a model's error is so far above the floor that something may be missing."""
    return error_of(problem, scored) > MATERIAL * problem.floor.total


def is_noise(problem: FitProblem, scored: Scored) -> bool:
    """Whether what a model leaves may be noise, as far as the floor is known."""
    floor = problem.floor
    if error_of(problem, scored) <= NEAR_FLOOR * floor.total:
        return True
    if floor.gain_known:
        # of the fit: what is held out differs by what few runs do to the parameters
        return beyond_repeats(problem, scored.fit.residual) >= LIKELY
    if problem.data.table.holdout == BLOCKS:  # of one run, whose gain is no scatter
        return False
    return shape_error(problem, scored) <= SHAPE_MARGIN * floor.total


def beyond_repeats(problem: FitProblem, residual: Array, lost: float = 0.0) -> float:
    """Chance (p-value) at which a residual (samples,) exceeds the scatter of repeats, in any band.

    lost: share by which the mean square of noise is larger in what was held out.
    """
    spectrum, floor = problem.spectrum, problem.floor
    power = spectrum.power(spectrum.coefficients(residual[None]))[0]
    counts = spectrum.counts()
    seen = floor.dof > 0.0
    ratio = power[seen] / counts[seen] / ((1.0 + lost) * floor.variance[seen])
    chances = variance_ratio.sf(ratio, counts[seen], floor.dof[seen])
    return float(min(np.min(chances) * len(chances), 1.0))
