"""Search of a missing effect: its signature, and the model refitted with it and held out.

The signature is what an effect would change beyond the model it is added to. It tells where a fit
starts, and whether the effect shows at all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from multiprocessing import get_context

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.diagnosis.priors import is_resolved, seen_at_rest, unusual
from model_lab.fitting.fit import Fit, Likelihood, fit
from model_lab.fitting.held_out import HeldOut, hold_out
from model_lab.fitting.problem import FitProblem, base_starts
from model_lab.rules import RULES, Rules
from softhand_model.effects import Effect, Parameter

GRID = {0: 1, 1: 7, 2: 4, 3: 3}  # trial values of each parameter, by their number
LARGEST_GRID = 16
ROUNDING = 1e-9


@dataclass(frozen=True)
class Signature:
    """How the predictions of a model change if an effect is added, at trial values of the k
    parameters of the effect.

    values (trials, k): trial values. usual (2, k): lower and upper ends of the usual ranges of the
    parameters. change (trials, samples): change in whitened coefficients, without the part that the
    model's own parameters can imitate. size (trials,): root mean square of `change` in the unit of
    the outputs. raw (trials,): root mean square of the whole change, in this unit, too.
    """

    values: Array
    usual: Array
    change: Array
    size: Array
    raw: Array


def trial_values(effect: type[Effect]) -> Array:
    """Trial values (trials, k) on a grid over the usual ranges of an effect's k parameters.

    A single parameter is tried at its bounds too, as an effect may be far stronger than usual.
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


def signature(likelihood: Likelihood, fit: Fit, effect: type[Effect]) -> Signature:
    """How predictions change if an effect is added, all other parameters being those of `fit`.

    likelihood: of the model with the effect. fit: of the model without it.
    """
    trials = trial_values(effect)
    lanes = with_trials(likelihood, fit, effect.name, trials)
    moved = fit.residual - likelihood.residuals(lanes)
    possible = np.all(np.isfinite(moved), axis=1)  # others leave no equilibrium: no start for a fit
    if possible.any():
        trials, moved = trials[possible], moved[possible]
    spectrum = likelihood.spectrum
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


def with_trials(likelihood: Likelihood, fit: Fit, effect: str, trials: Array) -> Array:
    """Parameters (trials, k) of `likelihood`: trial values for one effect, values of the fit for
    the others.
    """
    fitted = dict(zip(fit.likelihood.names, fit.values.tolist(), strict=True))
    parameters = likelihood.parameters
    known = np.array([fitted.get(p.name, p.start) for p in parameters], float)
    lanes = np.tile(known, (len(trials), 1))
    lanes[:, [index for index, p in enumerate(parameters) if p.effect == effect]] = trials
    return lanes


def starts(found: Signature, fit: Fit) -> Array:
    """Trial values (n, k) from which the fit of the effect starts; n is 1 or 2.

    Among the trial values within the usual ranges, these are the best one if its signature is taken
    as it is, and the best one if each signature is scaled to fit best. They may be the same one.
    """
    as_it_is, scaled = _improvements(found, fit)
    usual = np.all((found.values >= found.usual[0]) & (found.values <= found.usual[1]), axis=1)
    scores = (np.where(usual, score, -np.inf) for score in (as_it_is, scaled))
    best = dict.fromkeys(int(np.argmax(score)) for score in scores)
    return found.values[list(best)]


def promise(found: Signature, fit: Fit) -> tuple[float, float]:
    """Best possible gain of an effect, computed before it is fitted: (largest decrease of the
    deviance, largest share of the mean square error that it removes).

    Each of its signatures (changes of the prediction at trial values) is scaled twice: so that the
    likelihood rises most, and so that the error falls most. The two differ for an effect that moves
    whole runs: it changes the error by much but the likelihood by little, as runs scatter anyway.
    """
    spectrum = fit.likelihood.spectrum
    change = found.change * np.sqrt(fit.variance)[spectrum.bands]
    left = [
        fit.coefficients - _amplitude(change, fit.coefficients, weight)[:, None] * change
        for weight in (1.0 / fit.variance[spectrum.bands], np.ones(change.shape[1]))
    ]
    power = spectrum.power(np.concatenate(left))
    values = np.broadcast_to(fit.values, (len(power), len(fit.values)))
    fall = fit.deviance - fit.likelihood.deviance(power, values)
    share = power.sum(axis=1) / max(float(np.sum(fit.coefficients**2)), 1e-300)
    return float(np.max(fall)), 1.0 - float(np.min(share))


def _amplitude(change: Array, coefficients: Array, weight: Array) -> Array:
    """Factor (trials,) on each change (trials, samples) at which it meets coefficients (samples,)
    best; not below 0.
    """
    square = (change**2) @ weight
    along = (change * weight) @ coefficients
    return np.maximum(along, 0.0) / np.where(square > 0.0, square, 1.0)


def _improvements(found: Signature, fit: Fit) -> tuple[Array, Array]:
    """Fall of the weighted squares (trials,) by each signature as it is, and scaled at best."""
    weight = np.sqrt(1.0 / fit.variance)[fit.likelihood.spectrum.bands]
    along = found.change @ (fit.coefficients * weight)
    square = np.sum(found.change**2, axis=1)
    scaled = np.where(along > 0.0, along**2 / np.where(square > 0.0, square, 1.0), 0.0)
    return 2.0 * along - square, scaled


def invisible(found: Signature, floor: float, rules: Rules = RULES) -> str | None:
    """Reason why an effect is not visible in these runs at any strength, as a clause such as
    `changes nothing in these runs`; None if it is visible. floor: noise floor [SI unit of the
    outputs].
    """
    if found.raw.max() < rules.visible_share * floor:
        return "changes nothing in these runs"
    if found.size.max() < rules.visible_share * floor:
        return "acts like the calibration or the effects already in the model"
    return None


@dataclass(frozen=True)
class Scored:
    """A fitted model with its prediction of held-out data.

    known: whether, for every effect, some parameter can be estimated. resolved: whether none of its
    effects has a time that is too short for the samples (`priors.is_resolved`). improvement: by how
    much the effect that was added last lowered the deviance. signature: that of the effect that was
    added last. unusual: deviance for what makes the model unlikely besides its error (`priors`).
    rules: thresholds of the judgement.
    """

    effects: tuple[str, ...]
    fit: Fit
    held_out: HeldOut
    known: bool = True
    resolved: bool = True
    improvement: float = 0.0
    signature: Signature | None = None
    unusual: float = 0.0
    rules: Rules = RULES

    @property
    def added(self) -> str:
        """Name of the effect that was added last."""
        return self.effects[-1]

    @property
    def plausible(self) -> bool:
        """Whether the parameters of its effects lie off their bounds and can be estimated."""
        return self._off_bounds and self.known and self.resolved

    @property
    def possible(self) -> bool:
        """Whether it is plausible, or would be if its effects had been sampled closely enough."""
        return self._off_bounds and (self.known or not self.resolved)

    @property
    def _off_bounds(self) -> bool:
        parameters = self.fit.likelihood.parameters
        return not any(
            p.effect and limit for p, limit in zip(parameters, self.fit.at_limit, strict=True)
        )

    def parameters_of(self, effect: str) -> list[int]:
        """Indices of an effect's parameters."""
        parameters = self.fit.likelihood.parameters
        return [index for index, p in enumerate(parameters) if p.effect == effect]


@dataclass(frozen=True)
class Unseen:
    """An effect that these data cannot show when it is added to the model it was tried with;
    reason: why, as a clause.
    """

    name: str
    reason: str


def score_base(
    problem: FitProblem, effects: Sequence[str] = (), start: Array | None = None
) -> Scored:
    """Fit the model with some effects, and predict held-out data.

    start: values (k,) from which the fit starts. None: the fitted values of the model if it has all
    of them, otherwise the usual start values.
    """
    likelihood = problem.likelihood(effects)
    parameters = likelihood.parameters
    if start is None and all(p.name in problem.fitted for p in parameters):
        start = np.array([problem.fitted[p.name] for p in parameters], float)
    starts_of_fit = base_starts(parameters) if start is None else start[None]
    found, held_out = _fitted(problem, likelihood, tuple(effects), starts_of_fit)
    return Scored(
        tuple(effects),
        found,
        held_out,
        unusual=unusual(found) - seen_at_rest(problem.data, found, problem.rules),
        rules=problem.rules,
    )


def _fitted(
    problem: FitProblem, likelihood: Likelihood, effects: tuple[str, ...], first: Array
) -> tuple[Fit, HeldOut]:
    """The model with these effects, fitted from starts (n, k), and its held-out error."""

    def make() -> tuple[Fit, HeldOut]:
        found = fit(likelihood, first)
        return found, hold_out(found)

    return problem.once(make, "fit", effects, first.tobytes())


def signature_of(problem: FitProblem, before: Scored, effect: str) -> Signature:
    """The signature of an effect that is added to the fitted model `before`."""

    def make() -> Signature:
        likelihood = problem.likelihood((*before.effects, effect))
        return signature(likelihood, before.fit, problem.classes[effect])

    return problem.once(make, "signature", before.effects, effect, before.fit.values.tobytes())


def score_with(problem: FitProblem, before: Scored, effect: str) -> Scored | Unseen:
    """Fit the model `before` with one more effect; an `Unseen` with the reason if the effect cannot
    show.
    """
    effects = (*before.effects, effect)
    likelihood = problem.likelihood(effects)
    found = signature_of(problem, before, effect)
    reason = invisible(found, problem.floor.total, problem.rules)
    if reason is not None:
        return Unseen(effect, reason)
    first = with_trials(likelihood, before.fit, effect, starts(found, before.fit))
    after, held_out = _fitted(problem, likelihood, effects, first)
    gained = before.fit.deviance - after.deviance
    rules, kind, beside = problem.rules, problem.classes[effect], bool(before.effects)
    resolved = before.resolved and is_resolved(problem.data, after, kind, beside, rules)
    known = before.known and is_known(after, kind, rules)
    odds = unusual(after) - seen_at_rest(problem.data, after, rules)
    return Scored(effects, after, held_out, known, resolved, gained, found, odds, rules)


def is_known(fit: Fit, effect: type[Effect], rules: Rules = RULES) -> bool:
    """Whether the data distinguish the effect from no effect: the standard error of some parameter
    is below a share of its distance from the neutral value (`Rules.known_error`).

    Without this criterion two effects that compensate each other could both be accepted with
    arbitrarily large parameters.
    """
    scales, spread = fit.likelihood.scales, np.sqrt(np.diag(fit.covariance))
    place = {parameter.name: index for index, parameter in enumerate(fit.likelihood.parameters)}
    for parameter in effect.parameters:
        index = place[f"{effect.name}.{parameter.name}"]
        distance = abs(fit.values[index] - (parameter.neutral or 0.0))
        linear = rules.known_error * distance
        allowed = rules.known_log_error if scales.logarithmic[index] else linear
        if spread[index] < allowed:
            return True
    return not effect.parameters


def score_without(problem: FitProblem, before: Scored, effect: str) -> Scored:
    """Fit the model `before` without one of its effects."""
    kept = tuple(name for name in before.effects if name != effect)
    likelihood = problem.likelihood(kept)
    values = dict(zip(before.fit.likelihood.names, before.fit.values, strict=True))
    start = np.array([values.get(p.name, p.start) for p in likelihood.parameters])
    return score_base(problem, kept, start)


def score_all(
    problem: FitProblem,
    before: Scored,
    effects: Sequence[str],
    jobs: int = 1,
    limit: int = 0,
    tell: Tell = tell_nobody,
) -> list[Scored | Unseen]:
    """Fit the model `before` with each of the effects added in turn; results in the order of the
    effects tried.

    jobs: number of processes. limit: most effects to fit, those whose signatures promise most; 0:
    all.
    """
    if limit and len(effects) > limit:
        effects = _most_promising(problem, before, effects, limit)

    def told(effect: str, number: int) -> str:
        tell(f"fitting {' with '.join([effect, *before.effects])}", number, len(effects))
        return effect

    if jobs < 2 or len(effects) < 2:
        return [
            score_with(problem, before, told(effect, number))
            for number, effect in enumerate(effects, 1)
        ]
    return _in_processes(problem, before, effects, jobs, told)


def _most_promising(
    problem: FitProblem, before: Scored, effects: Sequence[str], limit: int
) -> list[str]:
    """The effects that promise most likelihood, and then those that promise most of the error."""
    promised = {}
    for effect in effects:
        promised[effect] = promise(signature_of(problem, before, effect), before.fit)
    few = problem.rules.fitted_by_error
    by_error = sorted(effects, key=lambda effect: -promised[effect][1])[:few]
    by_likelihood = sorted(effects, key=lambda effect: -promised[effect][0])
    chosen = by_likelihood[: limit - few]
    return list(dict.fromkeys([*chosen, *by_error, *by_likelihood]))[:limit]


_task: tuple[FitProblem, Scored] | None = (
    None  # inherited by forked processes, never changed in them
)


def _in_processes(
    problem: FitProblem,
    before: Scored,
    effects: Sequence[str],
    jobs: int,
    told: Callable[[str, int], str],
) -> list[Scored | Unseen]:
    """As `score_all`; results come back without their likelihood, which the parent knows."""
    global _task
    _task = (problem, before)
    with get_context("fork").Pool(jobs) as pool:
        coming = pool.imap(_work, effects)
        results = []
        for number, effect in enumerate(effects, 1):
            told(effect, number)
            results.append(next(coming))
    _task = None
    return [
        result
        if isinstance(result, Unseen)
        else replace(result, fit=replace(result.fit, likelihood=problem.likelihood(result.effects)))
        for result in results
    ]


def _work(effect: str) -> Scored | Unseen:
    if _task is None:
        raise RuntimeError(
            "a worker process of the search was started before its task was set: expected "
            "score_all to start it"
        )
    result = score_with(*_task, effect)
    if isinstance(result, Unseen):
        return result
    # the likelihood holds classes of a user's file, which no other process can read
    return replace(result, fit=replace(result.fit, likelihood=None))  # type: ignore[arg-type]
