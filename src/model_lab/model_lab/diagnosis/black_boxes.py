"""Black-box baselines: how much of the residual any effect of some input could explain.

A black box is a sum of features of one class of inputs, linear in their coefficients. It is fitted
to the residual of a model, together with the model's own parameters, and judged on held-out data
like any model. So it tells how much of the error depends on its inputs, by whatever equation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array
from model_lab.diagnosis.search import Scored
from model_lab.fitting.fit import Fit, inverse
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, MeasurementSet, Run
from model_lab.rules import RULES

BLACK_BOX_PIECES = 6
PLAY_SHARES = (0.05, 0.15, 0.3, 0.6)  # widths of the plays over the range of the input
FILTERS = 6  # time constants, evenly in their logarithm
WAVES = 6  # half periods of a drift over the session
FEWEST_SAMPLES = 3  # of a run, for slopes
REWEIGHTED = 4  # times
RIDGE = 1e-4  # of the coefficients, with features scaled to unit mean square
AXIS_OF = {"pulse": "pressure", "time_in_run": "time_since_step"}  # others are axes themselves


@dataclass(frozen=True)
class BlackBox:
    """A black box fitted to a model's residual.

    residual (samples,): the held-out residual with it. features: their number.
    """

    name: str
    residual: Array
    features: int

    @property
    def against(self) -> str:
        """Name of the axis (see `localisation.axes`) that its inputs belong to."""
        return AXIS_OF.get(self.name, self.name)

    @property
    def rmse(self) -> float:
        """Held-out root mean square error."""
        return float(np.sqrt(np.mean(self.residual**2)))


def black_boxes_of(problem: FitProblem, base: Scored, scored: Scored) -> tuple[BlackBox, ...]:
    """Black boxes fitted to a model's residual, the best first."""
    predicted = problem.data.table.value - base.fit.residual
    return problem.once(
        lambda: tuple(fit_black_boxes(scored.fit, problem.data, predicted)),
        "black boxes",
        scored.effects,
        scored.fit.values.tobytes(),
    )


def fit_black_boxes(fit: Fit, data: MeasurementSet, predicted: Array) -> list[BlackBox]:
    """The black boxes whose inputs these data have, sorted by their held-out error.

    Args:
        fit: fit of a model; the black boxes are fitted to its residual (measured less fitted).
        data: the measurements.
        predicted: outputs (samples,) [SI unit of the set] of the model without added effects, on
            which some black boxes depend.
    """
    found = []
    for name, feature in FEATURES.items():
        columns = _collect(feature, data, predicted)
        if columns is not None:
            found.append(BlackBox(name, held_out_with(fit, columns), columns.shape[1]))
    return sorted(found, key=lambda black_box: black_box.rmse)


@dataclass(frozen=True)
class _Inputs:
    """One output of one run, as input of the features; driving and predicted relative to their
    scale.
    """

    data: MeasurementSet
    index: int
    driving: Array
    predicted: Array
    time: Array | None

    @property
    def run(self) -> Run:
        return self.data.runs[self.index]


def _collect(
    feature: Callable[[_Inputs], Array | None], data: MeasurementSet, predicted: Array
) -> Array | None:
    """Feature columns (samples, features) scaled to unit mean square, without the constant ones."""
    parts = []
    scale = np.sqrt(np.mean(predicted**2)) or 1.0
    driving = [data.driving(run) for run in data.runs]
    low, high = min(d.min() for d in driving), max(d.max() for d in driving)
    for course in data.table.courses:
        relative = (driving[course.run] - low) / ((high - low) or 1.0)
        part = predicted[course.samples] / scale
        time = data.runs[course.run].columns.get("time")
        columns = feature(_Inputs(data, course.run, relative, part, time))
        if columns is None:
            return None
        parts.append(_in_block(columns, course.output, len(data.outputs)))
    stacked = np.concatenate(parts)
    size: Array = np.sqrt(np.mean(stacked**2, axis=0))
    used = size > 1e-9
    return np.asarray(stacked[:, used] / size[used], float) if used.any() else None


def _in_block(columns: Array, output: int, outputs: int) -> Array:
    """Features of one output beside zeros for the others, so that each has its own coefficients."""
    result = np.zeros((len(columns), outputs * columns.shape[1]))
    result[:, output * columns.shape[1] : (output + 1) * columns.shape[1]] = columns
    return result


def held_out_with(fit: Fit, columns: Array) -> Array:
    """Held-out residual (samples,) of the linearised model and feature columns (samples, features),
    fitted together.

    The fit is weighted by the noise that both together leave, found by iteration.
    """
    spectrum = fit.likelihood.spectrum
    design = np.hstack([fit.jacobian, columns])
    rows = spectrum.coefficients(np.ascontiguousarray(design.T))
    weight = 1.0 / fit.variance[spectrum.bands]
    for _ in range(REWEIGHTED):
        left = fit.coefficients - _solved(fit, rows, weight) @ rows
        weight = 1.0 / fit.likelihood.variance(spectrum.power(left[None]))[0][spectrum.bands]
    residual = fit.residual.copy()
    for fold in range(len(spectrum.table.folds)):
        mine = spectrum.table.fold == fold
        residual[mine] -= design[mine] @ _solved(fit, rows, np.where(mine, 0.0, weight))
    return residual


def _solved(fit: Fit, rows: Array, weight: Array) -> Array:
    """Changes of the model's parameters, and coefficients of the features, from coefficients
    (k, samples) of both with weights (samples,).
    """
    own = len(fit.values)
    size = np.sum(rows**2 * weight, axis=1)
    ridge = np.concatenate([1.0 / fit.likelihood.prior**2, RIDGE * size[own:]])
    normal = (rows * weight) @ rows.T + np.diag(ridge)
    return np.asarray(inverse(normal, 1e-12) @ (rows @ (weight * fit.coefficients)))


def _spline(position: Array) -> Array:
    """Cubic B-splines (n, BLACK_BOX_PIECES + 3) over 0..1."""
    from scipy.interpolate import BSpline  # here, as it takes long to load

    inner = np.linspace(0.0, 1.0, BLACK_BOX_PIECES + 1)
    knots = np.concatenate([[0.0] * 3, inner, [1.0] * 3])
    return np.asarray(BSpline.design_matrix(np.clip(position, 0.0, 1.0), knots, 3).todense())


def _pressure(inputs: _Inputs) -> Array | None:
    return _spline(inputs.driving)


def _pulse(inputs: _Inputs) -> Array | None:
    """Smooth function of duration and pressures, for each direction."""
    columns = inputs.run.columns
    if inputs.data.experiment != "valve_pulse":
        return None
    terms = []
    for direction in (INFLATE, DEFLATE):
        mine = columns["direction"] == direction
        one, time = mine * 1.0, mine * columns["duration"]
        high, low = columns["p_in"] / 1e5, columns["p_out"] / 1e5
        terms += [one, time, one * high, one * low, time * high, time * low, time**2]
        terms += [time * high**2, time * low**2, time * high * low]
    return np.stack(terms, axis=1)


def _rate(inputs: _Inputs) -> Array | None:
    if inputs.time is None or any(run.samples < FEWEST_SAMPLES for run in inputs.data.runs):
        return None
    slope = np.asarray(np.gradient(inputs.driving, inputs.time + _strictly(inputs.time)))
    rate = slope / (np.abs(slope).max() or 1.0)
    return np.stack([rate, np.abs(rate), rate * inputs.driving, np.sign(rate)], axis=1)


def _strictly(time: Array) -> Array:
    return np.linspace(0.0, 1e-9, len(time))


def _memory_of_time(inputs: _Inputs) -> Array | None:
    """Prediction less its low-pass filtered values, for time constants that the runs resolve."""
    if inputs.time is None or any(run.samples < FEWEST_SAMPLES for run in inputs.data.runs):
        return None
    longest = max(run.columns["time"][-1] - run.columns["time"][0] for run in inputs.data.runs)
    shortest = min(float(np.median(np.diff(run.columns["time"]))) for run in inputs.data.runs)
    constants = np.geomspace(2.0 * max(shortest, 1e-4 * longest), 0.5 * longest, FILTERS)
    lagging = [_low_pass(inputs.predicted, inputs.time, tau) for tau in constants]
    return np.stack([inputs.predicted - slow for slow in lagging], axis=1)


def _low_pass(values: Array, time: Array, tau: float) -> Array:
    slow, state = np.empty_like(values), 0.0
    keep = np.exp(-np.diff(time, prepend=time[0]) / tau)
    for index, (value, kept) in enumerate(zip(values, keep, strict=True)):
        state = value + (state - value) * kept
        slow[index] = state
    return slow


def _direction(inputs: _Inputs) -> Array | None:
    """Plays of several widths, for errors that depend on where the input reversed."""
    if inputs.time is None and inputs.data.experiment == "valve_pulse":
        return None
    plays = [inputs.driving - _play(inputs.driving, share) for share in PLAY_SHARES]
    return np.stack([*plays, *(play * inputs.driving for play in plays)], axis=1)


def _play(values: Array, width: float) -> Array:
    result, state = np.empty_like(values), 0.0
    for index, value in enumerate(values):
        state = min(max(state, value - width / 2.0), value + width / 2.0)
        result[index] = state
    return result


def _largest(inputs: _Inputs) -> Array | None:
    """How far the input is below the largest that the specimen has seen."""
    earlier = [
        inputs.data.driving(run).max()
        for run in inputs.data.runs[: inputs.index]
        if run.specimen == inputs.run.specimen
    ]
    raw = inputs.data.driving(inputs.run)
    largest = np.maximum.accumulate(np.maximum(raw, max(earlier, default=raw.min())))
    top = max(inputs.data.driving(run).max() for run in inputs.data.runs)
    below = (largest - raw) / (top or 1.0)
    return np.stack([below, below**2, below * inputs.predicted], axis=1)


def _temperature(inputs: _Inputs) -> Array | None:
    temperatures = np.concatenate([run.warmth for run in inputs.data.runs])
    if np.ptp(temperatures) < 1.0:
        return None
    warm = (inputs.run.warmth - temperatures.mean()) / np.ptp(temperatures)
    return warm[:, None] * np.stack([np.ones_like(inputs.predicted), inputs.predicted], axis=1)


def _specimen(inputs: _Inputs) -> Array | None:
    names = list(inputs.data.specimens)
    if len(names) < 2:
        return None
    chosen = np.array([name == inputs.run.specimen for name in names], float)
    both = np.stack([inputs.predicted, inputs.driving**2], axis=1)
    return (both[:, :, None] * chosen).reshape(len(both), -1)


def _run_order(inputs: _Inputs) -> Array | None:
    """Slow drift over the session of zero and gain."""
    runs = len(inputs.data.runs)
    if runs < RULES.drift_runs:
        return None
    within = np.linspace(0.0, 1.0, len(inputs.predicted))
    session = (inputs.index + within) / runs
    waves = [np.cos(np.pi * order * session) for order in range(1, min(runs // 3, WAVES) + 1)]
    return np.stack([*waves, session * inputs.predicted], axis=1)


def _time(inputs: _Inputs) -> Array | None:
    """Drift within a run."""
    if inputs.time is None:
        return None
    longest = max(np.ptp(run.columns["time"]) for run in inputs.data.runs)
    since = (inputs.time - inputs.time[0]) / (longest or 1.0)
    return np.stack([since, since**2, since * inputs.predicted], axis=1)


FEATURES: dict[str, Callable[[_Inputs], Array | None]] = {
    "pressure": _pressure,
    "pulse": _pulse,
    "pressure_rate": _rate,
    "time_since_step": _memory_of_time,
    "direction": _direction,
    "largest_pressure": _largest,
    "temperature": _temperature,
    "specimen": _specimen,
    "run_order": _run_order,
    "time_in_run": _time,
}
