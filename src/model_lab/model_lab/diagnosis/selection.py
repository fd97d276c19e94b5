"""Selection of the missing effects: single ones and pairs forwards, once backwards, then ties.

An effect is only named if it brings more than the best of all candidates does in mere noise, whose
distribution is drawn. Besides, the smallest value of each effect that would have been detected.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from model_lab.aliases import Array, Mask, Tell, tell_nobody
from model_lab.diagnosis.result import Detectable
from model_lab.diagnosis.search import (
    Scored,
    Signature,
    Unseen,
    score_all,
    score_base,
    score_without,
)
from model_lab.fitting.fit import PSEUDO_OBSERVATIONS
from model_lab.fitting.noise_floor import Spectrum
from model_lab.fitting.problem import FitProblem

Search = Callable[..., list[Scored | Unseen]]
"""`score_all` with the processes to use, and whom to tell."""

DRAWS = 2000  # sets of mere noise
SMALLEST_SHOWN = 0.5  # rms of an effect over the floor that makes an error material
SIGNIFICANCE = 0.01  # against the best of all candidates in mere noise
PARAMETER_PENALTY = 3.0  # deviance that a parameter must bring when effects compete
FEWEST_FOLDS = 3
MATERIAL = 1.12  # held-out error over the floor beyond which something is worth looking for
REMOVED = 0.5  # share of the excess error that an effect must remove
BEAM = 3  # single effects from which pairs are tried
WORTHWHILE = 0.2  # of the largest improvement, that such an effect must bring
FITTED = 5  # second effects that are fitted for each of them
TIE = 8.0  # deviance within which two explanations are not told apart
TIE_SHARE = 0.02  # the same over what they gain: equations are no better than that


@dataclass(frozen=True)
class Selection:
    """The search and its outcome.

    base: the model as it was; singles: every effect alone; unseen: those that cannot show; final:
    the chosen model (base if none); p_values of singles by name; ties: for each effect of the final
    model the names that explain as much in its place, nearest first.
    """

    base: Scored
    singles: tuple[Scored, ...]
    unseen: tuple[Unseen, ...]
    final: Scored
    p_values: dict[str, float]
    threshold: float
    ties: tuple[tuple[str, ...], ...]

    @property
    def proven(self) -> list[Scored]:
        """Plausible single effects that bring more than mere noise does, the best first."""
        return _proven(self.singles, self.threshold)


def select(
    problem: FitProblem,
    effects: Sequence[str],
    given: Sequence[str],
    seed: int,
    jobs: int,
    tell: Tell = tell_nobody,
) -> Selection:
    """Search the effects for what is missing in a model that has the given ones."""
    base = score_base(problem, given)
    search = partial(score_all, jobs=jobs, tell=tell)
    tried = search(problem, base, effects)
    singles = tuple(sorted((s for s in tried if isinstance(s, Scored)), key=_criterion))
    unseen = tuple(s for s in tried if isinstance(s, Unseen))
    maxima = null_maxima([s.signature for s in singles if s.signature], problem.spectrum, seed)
    threshold = float(np.quantile(maxima, 1.0 - SIGNIFICANCE))
    p_values = {s.added: p_value(maxima, s.improvement) for s in singles}
    final = _grow(problem, base, singles, threshold, search)
    ties = _ties(problem, final, base, singles, search)
    return Selection(base, singles, unseen, final, p_values, threshold, ties)


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


def material(problem: FitProblem, scored: Scored) -> bool:
    """Whether a model's error is so far above the floor that something may be missing."""
    return error_of(problem, scored) > MATERIAL * problem.floor.total


def _proven(scored: Sequence[Scored], threshold: float) -> list[Scored]:
    return [s for s in scored if s.plausible and s.improvement > threshold]


def _criterion(scored: Scored) -> float:
    return scored.fit.deviance + PARAMETER_PENALTY * len(scored.fit.values)


def _grow(
    problem: FitProblem, base: Scored, singles: Sequence[Scored], threshold: float, search: Search
) -> Scored:
    """The model with the effects that are missing, one or two at a time."""
    good = _proven(singles, threshold)
    if not good or not material(problem, base):
        return base
    best = good[0]
    names = [s.added for s in singles]
    if material(problem, best):
        firsts = [s for s in good[:BEAM] if s.improvement > WORTHWHILE * best.improvement]
        pairs = _pairs(problem, firsts, names, threshold, search)
        if pairs and _is_better(problem, pairs[0], best, threshold):
            return _without_idle(problem, pairs[0])
    return best if share_left(problem, best, base) <= 1.0 - REMOVED else base


def _is_better(problem: FitProblem, pair: Scored, single: Scored, threshold: float) -> bool:
    """Whether a pair explains so much more than the best single effect that it takes two."""
    gained = single.fit.deviance - pair.fit.deviance
    return gained > threshold and share_left(problem, pair, single) < 1.0 - REMOVED


def _pairs(
    problem: FitProblem,
    firsts: Sequence[Scored],
    names: Sequence[str],
    threshold: float,
    search: Search,
) -> list[Scored]:
    """Plausible pairs that begin with one of `firsts`, the best first."""
    found: list[Scored] = []
    for first in firsts:
        if found and not material(problem, min(found, key=_criterion)):
            break  # they reach the floor
        others = [name for name in names if name not in first.effects]
        tried = search(problem, first, others, limit=FITTED)
        found += _proven([s for s in tried if isinstance(s, Scored)], threshold)
    return sorted(found, key=_criterion)


def _without_idle(problem: FitProblem, scored: Scored) -> Scored:
    """The same without effects that, once the others are there, remove little."""
    for effect in scored.effects:
        fewer = score_without(problem, scored, effect)
        if share_left(problem, scored, fewer) > 1.0 - REMOVED:
            return fewer
    return scored


def _ties(
    problem: FitProblem, final: Scored, base: Scored, singles: Sequence[Scored], search: Search
) -> tuple[tuple[str, ...], ...]:
    added = [name for name in final.effects if name not in base.effects]
    margin = max(TIE, TIE_SHARE * (_criterion(base) - _criterion(final)))
    result = []
    for effect in added:
        if len(added) == 1:
            instead = list(singles)
        else:
            without = score_without(problem, final, effect)
            others = [s.added for s in singles if s.added not in final.effects]
            tried = search(problem, without, others, limit=FITTED)
            instead = [s for s in tried if isinstance(s, Scored)]
        near = [
            s
            for s in sorted(instead, key=_criterion)
            if s.added != effect and _criterion(s) - _criterion(final) < margin
        ]
        result.append(tuple(s.added for s in near))
    return tuple(result)


def null_maxima(signatures: Sequence[Signature], spectrum: Spectrum, seed: int) -> Array:
    """Largest fall of the deviance over all candidates (draws,), sorted, in sets of mere noise.

    Noise of every band is drawn with a level that is itself only known from that band's
    coefficients and the floor's pseudo-observations. Each candidate is represented by its
    signatures, scaled as suits it best.
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
        known = count + PSEUDO_OBSERVATIONS
        spread = np.sqrt(known / random.chisquare(known, DRAWS))
        drawn += spread[:, None] * (random.standard_normal((DRAWS, len(root))) @ root.T)
    return np.sort(np.max(drawn**2, axis=1))


def p_value(maxima: Array, improvement: float) -> float:
    """Share of noise sets in which some candidate improves as much; one of them at least."""
    beyond = len(maxima) - int(np.searchsorted(maxima, improvement))
    return (beyond + 1) / (len(maxima) + 1)


def detectable_effects(problem: FitProblem, selection: Selection) -> list[Detectable]:
    """For each effect that could show, the weakest value of its first parameter that would have."""
    found = []
    for scored in selection.singles:
        effect = problem.classes[scored.added]
        if effect.parameters and scored.signature is not None:
            smallest = _weakest(scored, selection.threshold, SMALLEST_SHOWN * problem.floor.total)
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
