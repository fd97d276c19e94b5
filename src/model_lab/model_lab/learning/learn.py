"""Learning a missing curve: candidates are screened, the best are fitted together with the model,
and judged by held-out errors.

A candidate is a curve at a stage of the model against an axis. Its few values are fitted together
with the calibration and the model's effects by the lab's own fit. Real actuators differ from a
model in more than one way, so further curves are learned while the error is well above the floor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.diagnosis.black_boxes import held_out_with
from model_lab.diagnosis.criteria import error_of, excess, material
from model_lab.diagnosis.search import Scored, score_base
from model_lab.experiments.forward import FreeParameter
from model_lab.fitting.fit import Fit, Likelihood, fit
from model_lab.fitting.held_out import hold_out
from model_lab.fitting.problem import FitProblem, pose_problem, with_lower_floor
from model_lab.learning.candidates import Scene
from model_lab.learning.courses import answer_of, where_it_bends
from model_lab.learning.effect_file import (
    GROWS,
    MOST_CURVES,
    Kind,
    Shape,
    effect_of,
)
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.slips.find import find_slips
from model_lab.slips.slip import Slip
from softhand_model.effects import Effect, effect_classes
from softhand_model.model_file import Model

NAME = "learned"
FIRST_KNOTS = 5  # knots at first
KNOT_COUNTS = (3, 5, 8, 12)  # tried for the best
MOST_SAMPLES, FEWEST_SAMPLES_A_RUN = 6000, 150  # that are searched, at least so many of each run
FITTED_FIRST, FITTED_FURTHER = (
    8,
    4,
)  # candidates that are fitted as a whole: of a first curve, of others
KNOT_MOVES = 2  # times that knots are moved to where a curve bends


@dataclass(frozen=True)
class Candidate:
    """A curve that was fitted together with the model.

    error: held-out error with it. answer: how it changes predictions, see `answer_of`.
    """

    name: str
    shape: Shape
    scored: Scored
    error: float
    answer: str = ""

    @property
    def values(self) -> Array:
        """Values (k,) of the curve at its knots."""
        return self.scored.fit.values[self.scored.parameters_of(self.name)]

    @property
    def cost(self) -> float:
        """Number by which curves are compared, less is better: minus twice the log likelihood, a
        penalty for its parameters (Schwarz), and its surprise.
        """
        found = self.scored.fit
        complexity = np.log(found.residual.size) * len(found.values)
        return float(found.deviance + complexity + self.surprise)

    @property
    def surprise(self) -> float:
        """Minus twice the logarithm of the prior of such a curve."""
        return self.shape.surprise_of(self.answer)

    @property
    def covariance(self) -> Array:
        """Covariance (k, k) of the values."""
        mine = self.scored.parameters_of(self.name)
        found = self.scored.fit
        scale = np.where(found.likelihood.scales.logarithmic[mine], self.values, 1.0)
        return np.asarray(found.covariance[np.ix_(mine, mine)] * np.outer(scale, scale))

    @property
    def spread(self) -> Array:
        """Standard errors (k,) of the values."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class Learning:
    """What was learned.

    chosen: the chosen curve; None if there is none. reason: why there is none; else "". others: the
    other curves that were fitted, best first. further: curves that were learned in addition, each
    fitted together with those before. slips: mistakes in the description of the data, which were
    taken out before.
    """

    problem: FitProblem
    base: Scored
    chosen: Candidate | None
    others: tuple[Candidate, ...]
    reason: str
    further: tuple[Candidate, ...] = ()
    slips: tuple[Slip, ...] = ()

    @property
    def curves(self) -> tuple[Candidate, ...]:
        """All learned curves, with their values from the last fit, in which all are fitted
        together.
        """
        found = (self.chosen, *self.further) if self.chosen is not None else ()
        return tuple(replace(one, scored=found[-1].scored) for one in found)

    @property
    def kinds(self) -> frozenset[Kind]:
        """(stage, axis) of each learned curve, and of each curve tied with the chosen one."""
        tied = (one for one in self.others if self.is_tied(one))
        return frozenset(one.shape.kind for one in (*self.curves, *tied))

    @property
    def final(self) -> Scored:
        """The model with all learned curves; the model as it was if nothing was learned."""
        return self.curves[-1].scored if self.chosen is not None else self.base

    def is_tied(self, other: Candidate) -> bool:
        """Whether another curve predicts as well as the chosen one; False if none was chosen."""
        return self.chosen is not None and _alike(self.problem, self.chosen, other)


def learn(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]] | None = None,
    tell: Tell = tell_nobody,
) -> Learning:
    """Learn the curve that a model lacks, if one lowers the error on held-out data, after slips
    such as wrong units are taken out of the data, as in `compare`.

    classes: effect classes by name; None: the built-in ones. Raises ValueError for data that the
    model cannot use, and for data with several outputs.
    """
    if len(data.outputs) > 1:
        raise ValueError(
            f"experiment: expected one with a single output to learn from, got {data.experiment}, "
            f"which has {', '.join(data.outputs)}; `diagnose` names known effects in it"
        )
    checked = find_slips(data, model, tell)
    tell("fitting the model as it is", 0, 0)
    searched = thinned(checked.data, MOST_SAMPLES, FEWEST_SAMPLES_A_RUN)
    problem, given = pose_problem(searched, model, classes or effect_classes())
    names = [effect.name for effect in given]
    base = score_base(problem, names)
    found = _searched(problem, base, NAME, tell)
    lower = with_lower_floor(problem, found[0].scored.fit) if found else None
    if lower is not None:
        problem, base = lower, score_base(lower, names)
        found = _in_order(problem, [_fitted(problem, base, one.shape, one) for one in found])
    learned = replace(_judged(problem, base, found), slips=checked.slips)
    return _with_further(learned, tell)


def _with_further(learning: Learning, tell: Tell) -> Learning:
    """What was learned, with another curve as long as much is left and one takes half of that."""
    problem = learning.problem
    while learning.chosen is not None and len(learning.curves) < MOST_CURVES:
        last = learning.curves[-1]
        if last.scored.held_out.rmse <= problem.rules.learned_error * problem.floor.total:
            break
        problem = _with(problem, last.shape, last.name)
        name = f"{NAME}_{len(learning.curves) + 1}"
        found = _searched(problem, last.scored, name, tell, learning.kinds)
        helping = _helping(problem, last.scored, found)
        if not helping:
            break
        learning = replace(learning, further=(*learning.further, helping[0]))
    return learning


def _searched(
    problem: FitProblem, base: Scored, name: str, tell: Tell, known: Set[Kind] = frozenset()
) -> list[Candidate]:
    """Candidates fitted as a whole, the best first; beside known ones no others of their kinds, and
    no unlikely ones.
    """
    if not material(problem, base):
        return []
    scene = Scene.of(problem, base.fit)
    shapes = list(scene.shapes(FIRST_KNOTS))
    if known:
        most = problem.rules.unlikely_curve
        shapes = [s for s in shapes if s.kind not in known and s.surprise_of(GROWS) < most]
    promise = []
    for number, shape in enumerate(shapes, 1):
        tell(f"trying {_words(shape)}", number, len(shapes))
        promise.append(_promise(problem, base, shape, name))
    order = sorted(range(len(shapes)), key=lambda n: promise[n])
    chosen = order[: FITTED_FURTHER if known else FITTED_FIRST]
    found = []
    for number, index in enumerate(chosen, 1):
        tell(f"fitting {_words(shapes[index])}", number, len(chosen))
        found.append(_coarse(problem, base, shapes[index], name))
    best = min((one.error for one in found), default=0.0)
    near = [one for one in found if one.error <= problem.rules.learned_refined * best]
    for number, one in enumerate(near, 1):
        tell(f"refining {_words(one.shape)}", number, len(near))
        found[found.index(one)] = _refined(problem, base, scene, one)
    return _in_order(problem, found)


def _alike(problem: FitProblem, first: Candidate, other: Candidate) -> bool:
    """Whether another curve predicts as well as one; below the floor all do."""
    rules = problem.rules
    least = rules.learned_noise * problem.floor.total
    return other.error <= max(rules.learned_tie * first.error, least)


def _in_order(problem: FitProblem, found: list[Candidate]) -> list[Candidate]:
    """The simplest of those that predict well, then the others by their error; an unlikely
    one comes first only if no likelier one is tied with it.
    """
    best = min((one.error for one in found), default=0.0)
    rules = problem.rules
    limit = max(rules.learned_good * best, rules.learned_noise * problem.floor.total)
    good = sorted((one for one in found if one.error <= limit), key=lambda one: one.cost)
    others = sorted((one for one in found if one.error > limit), key=lambda one: one.error)
    if good:
        tied = [one for one in good if _alike(problem, good[0], one)]
        first = next((one for one in tied if one.surprise < rules.unlikely_curve), good[0])
        good = [first, *(one for one in good if one is not first)]
    return good + others


def _words(shape: Shape) -> str:
    return f"{shape.form} of {shape.stage} against {shape.against}"


def _with(problem: FitProblem, shape: Shape, name: str) -> FitProblem:
    """The problem with a learned effect of a shape added under a name."""
    return replace(problem, classes={**problem.classes, name: effect_of(shape, name)})


def _promise(problem: FitProblem, base: Scored, shape: Shape, name: str) -> float:
    """Held-out error that a curve promises when its answer is taken as linear."""
    likelihood = _with(problem, shape, name).likelihood((*base.effects, name))
    start, mine = _start(likelihood.parameters, base, name)
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


def _start(
    parameters: Sequence[FreeParameter], known: Scored, name: str
) -> tuple[Array, list[int]]:
    """Values (k,) of parameters as they are known, and which of them are the curve's."""
    fitted = dict(zip(known.fit.likelihood.names, known.fit.values.tolist(), strict=True))
    start = np.array([fitted.get(p.name, p.start) for p in parameters])
    return start, [index for index, p in enumerate(parameters) if p.effect == name]


def _coarse(problem: FitProblem, base: Scored, shape: Shape, name: str) -> Candidate:
    """The model with a curve of few knots, by least squares: banded noise would take a large error
    for slow noise.
    """
    likelihood = _with(problem, shape, name).likelihood((*base.effects, name))
    start, _ = _start(likelihood.parameters, base, name)
    return _candidate(problem, base, shape, name, fit(_squares(problem, likelihood), start[None]))


def _fitted(problem: FitProblem, base: Scored, shape: Shape, before: Candidate) -> Candidate:
    """The model with a curve, from one of other knots."""
    name = before.name
    likelihood = _with(problem, shape, name).likelihood((*base.effects, name))
    start, mine = _start(likelihood.parameters, before.scored, name)
    start[mine] = _resampled(before, shape)
    return _candidate(problem, base, shape, name, fit(likelihood, start[None]))


def _candidate(problem: FitProblem, base: Scored, shape: Shape, name: str, found: Fit) -> Candidate:
    scored = Scored((*base.effects, name), found, hold_out(found))
    answer = answer_of(problem.data.table.value, base.fit.residual, found.residual)
    return Candidate(name, shape, scored, error_of(problem, scored), answer)


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
    """The candidate with as many knots as the data call for: the simplest curve that does.

    One that calls for the most is tried with its knots where it bends.
    """
    best: Candidate | None = None
    last = found
    for knots in KNOT_COUNTS:
        shape = scene.refined(found.shape, knots)
        if best is not None and len(shape.places) == len(last.shape.places):
            continue
        last = _fitted(problem, base, shape, last)
        if best is None or last.cost < best.cost:
            best = last
    for _ in range(KNOT_MOVES):
        if best is None or len(best.shape.places) < KNOT_COUNTS[-1]:
            break
        moved = replace(best.shape, places=where_it_bends(best.shape.places, best.values))
        last = _fitted(problem, base, moved, best)
        if last.cost >= best.cost:
            break
        best = last
    return best or found


def _helping(problem: FitProblem, before: Scored, found: Sequence[Candidate]) -> list[Candidate]:
    """Curves that take off enough of a model's error."""
    allowed = (1.0 - problem.rules.learned_removed) * excess(problem, before) ** 2
    return [one for one in found if excess(problem, one.scored) ** 2 <= allowed]


def _judged(problem: FitProblem, base: Scored, found: list[Candidate]) -> Learning:
    """The first candidate that takes off enough of the error, or the reason why there is none."""
    helping = _helping(problem, base, found)
    if material(problem, base) and helping:
        others = tuple(one for one in found if one is not helping[0])
        return Learning(problem, base, helping[0], others, "")
    reason = "no curve removes half of the mean square error on held-out data"
    if not material(problem, base):
        most = problem.rules.material_error
        reason = f"the model is adequate: its held-out error is within {most:g} times the floor"
    return Learning(problem, base, None, tuple(found), reason)
