"""Learning what is missing: candidates screened, the best fitted as a whole, and judged held out.

A candidate is a curve at a stage against an axis, of few values that are fitted together with the
calibration and the model's effects by the lab's own fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.diagnosis.black_boxes import held_out_with
from model_lab.diagnosis.errors import MATERIAL, error_of, excess, material
from model_lab.diagnosis.search import Scored, score_base
from model_lab.experiments.forward import FreeParameter
from model_lab.fitting.fit import Fit, Likelihood, fit
from model_lab.fitting.problem import FitProblem, hold_out, pose_problem, with_lower_floor
from model_lab.learning.candidates import Scene
from model_lab.learning.effect_file import Shape, effect_of
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model

NAME = "learned"
COARSE = 5  # knots at first
KNOTS = (3, 5, 8, 12)  # tried for the best
NEAR = 1.5  # held-out error over the best one's, up to which they are
SAMPLES, OF_A_RUN = 12000, 250  # that are searched, at least so many of each run
FITTED = 8  # candidates that are fitted as a whole
GOOD = 1.4  # held-out error over the best one's, up to which the simplest curve is chosen
ALIKE = 1.05  # held-out error over that of the chosen one, up to which another is tied
REMOVED = 0.5  # share of the excess error that a curve must remove


@dataclass(frozen=True)
class Candidate:
    """A curve that was fitted with everything else."""

    shape: Shape
    scored: Scored
    error: float

    @property
    def values(self) -> Array:
        """Values (k,) of the curve."""
        return self.scored.fit.values[self.scored.parameters_of(NAME)]

    @property
    def cost(self) -> float:
        """Minus twice the log likelihood, what its parameters cost (Schwarz), and its surprise."""
        found = self.scored.fit
        complexity = np.log(found.residual.size) * len(found.values)
        return float(found.deviance + complexity + self.shape.surprise)

    @property
    def covariance(self) -> Array:
        """Of these values (k, k)."""
        mine = self.scored.parameters_of(NAME)
        found = self.scored.fit
        scale = np.where(found.likelihood.scales.logarithmic[mine], self.values, 1.0)
        return np.asarray(found.covariance[np.ix_(mine, mine)] * np.outer(scale, scale))

    @property
    def spread(self) -> Array:
        """Their standard errors (k,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class Learning:
    """What was learned: the chosen curve, none with a `reason`, and the others, best first."""

    problem: FitProblem
    base: Scored
    chosen: Candidate | None
    others: tuple[Candidate, ...]
    reason: str

    def is_tied(self, other: Candidate) -> bool:
        """Whether the data cannot tell another curve from the chosen one."""
        return self.chosen is not None and other.error <= ALIKE * self.chosen.error


def learn(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]] | None = None,
    tell: Tell = tell_nobody,
) -> Learning:
    """Learn the curve that is missing in a model, if one helps on held-out data.

    Raises ValueError for data that the model cannot use.
    """
    tell("fitting the model as it is", 0, 0)
    searched = thinned(data, SAMPLES, OF_A_RUN)
    problem, given = pose_problem(searched, model, classes or effect_classes())
    names = [effect.name for effect in given]
    base = score_base(problem, names)
    found = _searched(problem, base, tell)
    lower = with_lower_floor(problem, found[0].scored.fit) if found else None
    if lower is not None:
        problem = lower
        base = score_base(problem, names)
        found = _searched(problem, base, tell)
    return _judged(problem, base, found)


def _searched(problem: FitProblem, base: Scored, tell: Tell) -> list[Candidate]:
    """Candidates fitted as a whole, the best first."""
    if not material(problem, base):
        return []
    scene = Scene.of(problem, base.fit)
    shapes = list(scene.shapes(COARSE))
    promise = []
    for number, shape in enumerate(shapes, 1):
        tell(f"trying {_words(shape)}", number, len(shapes))
        promise.append(_promise(problem, base, shape))
    order = sorted(range(len(shapes)), key=lambda n: promise[n])
    chosen = order[:FITTED]
    found = []
    for number, index in enumerate(chosen, 1):
        tell(f"fitting {_words(shapes[index])}", number, len(chosen))
        found.append(_coarse(problem, base, shapes[index]))
    best = min((one.error for one in found), default=0.0)
    near = [one for one in found if one.error <= NEAR * best]
    for number, one in enumerate(near, 1):
        tell(f"refining {_words(one.shape)}", number, len(near))
        found[found.index(one)] = _refined(problem, base, scene, one)
    return _in_order(found)


def _in_order(found: list[Candidate]) -> list[Candidate]:
    """The simplest of those that predict well, then the others by their error."""
    best = min((one.error for one in found), default=0.0)
    good = [one for one in found if one.error <= GOOD * best]
    others = [one for one in found if one.error > GOOD * best]
    return sorted(good, key=lambda one: one.cost) + sorted(others, key=lambda one: one.error)


def _words(shape: Shape) -> str:
    return f"{shape.form} of {shape.stage} against {shape.against}"


def _with(problem: FitProblem, shape: Shape) -> FitProblem:
    """The problem in which the name of the learned effect stands for a shape."""
    return replace(problem, classes={**problem.classes, NAME: effect_of(shape, NAME)})


def _promise(problem: FitProblem, base: Scored, shape: Shape) -> float:
    """Held-out error that a curve promises when its answer is taken as linear."""
    likelihood = _with(problem, shape).likelihood((*base.effects, NAME))
    start, mine = _start(likelihood.parameters, base)
    scales = likelihood.scales
    center = scales.inward(start)
    step = 0.2 * scales.width[mine]
    trials = np.tile(center, (len(mine) + 1, 1))
    trials[np.arange(1, len(mine) + 1), mine] += step
    residual = likelihood.residuals(scales.outward(trials))
    columns = (residual[0] - residual[1:]).T
    if shape.form == "lag":
        columns = (base.fit.residual - residual[:1]).T
    size = np.sqrt(np.mean(columns**2, axis=0))
    used = size > 1e-9 * problem.floor.total
    if not used.any():
        return np.inf
    left = held_out_with(base.fit, columns[:, used] / size[used])
    return float(np.sqrt(np.mean(left**2)))


def _start(parameters: Sequence[FreeParameter], known: Scored) -> tuple[Array, list[int]]:
    """Values (k,) of parameters as they are known, and which of them are the curve's."""
    fitted = dict(zip(known.fit.likelihood.names, known.fit.values.tolist(), strict=True))
    start = np.array([fitted.get(p.name, p.start) for p in parameters])
    return start, [index for index, p in enumerate(parameters) if p.effect == NAME]


def _coarse(problem: FitProblem, base: Scored, shape: Shape) -> Candidate:
    """The model with a curve of few knots, by least squares: banded noise would take a large error
    for slow noise.
    """
    likelihood = _with(problem, shape).likelihood((*base.effects, NAME))
    start, _ = _start(likelihood.parameters, base)
    return _candidate(problem, base, shape, fit(_squares(problem, likelihood), start[None]))


def _fitted(problem: FitProblem, base: Scored, shape: Shape, before: Candidate) -> Candidate:
    """The model with a curve, from one of other knots."""
    likelihood = _with(problem, shape).likelihood((*base.effects, NAME))
    start, mine = _start(likelihood.parameters, before.scored)
    start[mine] = _resampled(before, shape)
    return _candidate(problem, base, shape, fit(likelihood, start[None]))


def _candidate(problem: FitProblem, base: Scored, shape: Shape, found: Fit) -> Candidate:
    scored = Scored((*base.effects, NAME), found, hold_out(found))
    return Candidate(shape, scored, error_of(problem, scored))


def _squares(problem: FitProblem, likelihood: Likelihood) -> Likelihood:
    """The likelihood of white noise."""
    spectrum = problem.spectrum.in_one_band()
    white = np.full(spectrum.band_count, problem.floor.total**2)
    return Likelihood(likelihood.forward, spectrum, white)


def _resampled(before: Candidate, shape: Shape) -> Array:
    """Values of a curve at other knots; names stay."""
    if shape.places == before.shape.places:
        return before.values
    return np.interp(shape.places, before.shape.places, before.values)


def _refined(problem: FitProblem, base: Scored, scene: Scene, found: Candidate) -> Candidate:
    """The candidate with as many knots as the data call for: the simplest curve that does."""
    best: Candidate | None = None
    last = found
    for knots in KNOTS:
        shape = scene.refined(found.shape, knots)
        if best is not None and len(shape.places) == len(last.shape.places):
            continue
        last = _fitted(problem, base, shape, last)
        if best is None or last.cost < best.cost:
            best = last
    return best or found


def _judged(problem: FitProblem, base: Scored, found: list[Candidate]) -> Learning:
    reason = ""
    if not material(problem, base):
        reason = f"the model is adequate: its held-out error is within {MATERIAL:g} times the floor"
    elif not found or excess(problem, found[0].scored) > (1.0 - REMOVED) * excess(problem, base):
        reason = "no curve takes off half of the error on held-out data"
    if reason:
        return Learning(problem, base, None, tuple(found), reason)
    return Learning(problem, base, found[0], tuple(found[1:]), "")
