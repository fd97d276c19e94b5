"""A fit problem and fitted models whose errors are stated, for tests of what decides on them.

The floor is 1 in all bands. An error has so much in the gains of runs and so much in their shape,
the latter even over all frequencies.
"""

from dataclasses import dataclass
from string import ascii_lowercase
from types import SimpleNamespace

import numpy as np
from scipy.fft import idct
from toy_forward import toy_set

from model_lab.diagnosis.search import Scored, Signature, Unseen
from model_lab.experiments.forward import FreeParameter
from model_lab.fitting.fit import Fit, Scales
from model_lab.fitting.held_out import HeldOut
from model_lab.fitting.noise_floor import REPEATS, STATED, NoiseFloor, make_spectrum
from model_lab.fitting.problem import FitProblem
from softhand_model.effects import effect_classes

CALIBRATION = 2  # parameters of every model beside one for each effect
SAMPLES = 100  # of a run


def made_up_problem(folds=6, gain_known=True, dof=6.0, level=1.0, unrepeated=STATED):
    """A problem of two runs a fold, with a noise floor known from so many degrees of freedom."""
    data = toy_set(np.random.default_rng(0), runs=2 * folds, samples=SAMPLES)
    spectrum = make_spectrum(data.table, np.ones(data.table.samples))
    bands = np.ones(spectrum.band_count)
    seen, source = (dof, REPEATS) if gain_known else (0.0, unrepeated)
    floor = NoiseFloor(level, level, 0.0, level, level**2 * bands, seen * bands, source)
    classes = {**effect_classes(), **{letter: timeless(letter) for letter in ascii_lowercase}}
    return FitProblem(data, "toy", (), classes, spectrum, floor, {})


def timeless(name):
    """What the selection asks of an effect's class, of one without parameters."""
    return SimpleNamespace(name=name, parameters=(), endless=False, cause="", stands_for=())


def residual(problem, shape, gain=0.0):
    """Residual (samples,) with so large an error (root mean square) in shape and gain."""
    runs = problem.data.table.runs
    coefficients = np.full((runs, SAMPLES), shape * np.sqrt(SAMPLES / (SAMPLES - 1)))
    coefficients[:, 0] = gain * np.sqrt(SAMPLES)
    return idct(coefficients, type=2, norm="ortho", axis=-1).ravel()


def beyond(excess, floor=1.0):
    """The error that exceeds the floor by this excess."""
    return float(np.hypot(floor, excess))


@dataclass(frozen=True)
class Said:
    """What is stated of a model: its error in shape and gain, that of the fit if it is another,
    its deviance, whether its effects are known and off their limits, and the standard error of
    their parameters, which are 1 between bounds at 0 and 10.
    """

    shape: float
    deviance: float = 0.0
    gain: float = 0.0
    fitted: float | None = None
    known: bool = True
    at_limit: bool = False
    more_parameters: int = 0
    std: float = 0.0


def made_up_model(problem, effects, said, before=None, signature=None):
    """The fitted model of which this is said; improvement is against the one before."""
    owners = [None] * CALIBRATION + list(effects) + [None] * said.more_parameters
    limits = [bool(said.at_limit and owner == effects[-1]) for owner in owners]
    parameters = [
        FreeParameter(owner or "calibration", "", 0.0, 10.0, 1.0, (0.0, 1.0), False, owner)
        for owner in owners
    ]
    likelihood = SimpleNamespace(
        parameters=parameters, scales=Scales.of(parameters), spectrum=problem.spectrum
    )
    held_out = residual(problem, said.shape, said.gain)
    fitted = held_out if said.fitted is None else residual(problem, said.fitted, said.gain)
    unused = np.zeros(0)
    fit = Fit(
        likelihood,
        np.ones(len(owners)),
        said.deviance,
        fitted,
        unused,
        np.ones(problem.spectrum.band_count),
        unused,
        said.std**2 * np.eye(len(owners)),
        np.array(limits),
    )
    improvement = 0.0 if before is None else before.fit.deviance - said.deviance
    held = HeldOut(held_out, unused)
    return Scored(tuple(effects), fit, held, said.known, True, improvement, signature)


def signature_of(problem, seed, strengths=(1.0,)):
    """Signature of one parameter, along a direction of its own, at these values."""
    direction = np.random.default_rng(seed).standard_normal(problem.data.table.samples)
    values = np.array(strengths)[:, None]
    size = values[:, 0]
    change = values * direction / np.linalg.norm(direction)
    return Signature(values, np.array([[0.0], [1.0]]), change, size, size)


class Landscape:
    """Models by their effects, one letter each, in place of the search's fits.

    Those that are not stated cannot be seen. `tried` holds the effects of all that were asked for.
    """

    def __init__(self, problem, models):
        self._problem = problem
        self._said = {frozenset(name): said for name, said in models.items()}
        self.tried = []

    def base(self, problem, effects=(), start=None):
        return made_up_model(problem, effects, self._said[frozenset(effects)])

    def all(self, problem, before, effects, jobs=1, limit=0, tell=None):
        return [self._one(before, effect) for effect in (effects[:limit] if limit else effects)]

    def without(self, problem, before, effect):
        kept = tuple(name for name in before.effects if name != effect)
        return made_up_model(problem, kept, self._said[frozenset(kept)])

    def _one(self, before, effect):
        effects = (*before.effects, effect)
        self.tried.append("".join(effects))
        said = self._said.get(frozenset(effects))
        if said is None:
            return Unseen(effect, "changes nothing in these runs")
        found = signature_of(self._problem, ord(effect))
        return made_up_model(self._problem, effects, said, before, found)
