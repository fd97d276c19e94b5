"""Next experiment: the one in which the effects still tied differ most, in units of noise.

Two explanations that fit equally well still differ where nothing was measured. In each run that
could be made (`bench.trial_runs`) the separation of a pair is

    d**2 = D' (C + J1 S1 J1' + J2 S2 J2')**-1 D,

with the difference D of their predictions, the noise C of a run, and how far each explanation can
still adapt: its Jacobian J and the covariance S of its parameters. The experiment whose worst pair
is furthest apart is proposed; where several are far enough, the one with the fewest changes.

Explanations between which the fit has decided are tied where their equations may be of another form
(`Rules.tie_share_other_form`). No run parts them while even the better one leaves more than noise;
else one that shows an error as large as the floor does.

Every run begins with the chamber open to the air. The reading of the pressure sensor at that moment
separates explanations that predict different ones, if no earlier run began so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.bench.trial_runs import TrialRun, run_of, trial_runs
from model_lab.diagnosis.criteria import leaves_more_than_noise
from model_lab.diagnosis.forward_selection import criterion
from model_lab.diagnosis.priors import read_at_rest
from model_lab.diagnosis.search import Scored, score_with, score_without
from model_lab.fitting.noise_floor import Spectrum, make_spectrum
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES
from softhand_model.effects import InputEffect

HISTORY_SAMPLES = 40
READINGS = 400  # at which an explanation is asked for the pressure in the chamber


@dataclass(frozen=True)
class Experiment:
    """A proposed run.

    separation: of the tied pair that it separates least, in standard deviations of the noise.
    floors: root mean square difference of such a pair over the noise floor. breaks: whether the
    diagnosis with this run will tell all of them apart. separates: groups of
    names that the run separates. at_rest: by name, what the pressure sensor reads [Pa] on an open
    chamber; empty if that does not differ.
    """

    trial: TrialRun
    separation: float
    floors: float
    breaks: bool
    separates: tuple[tuple[str, ...], ...]
    at_rest: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """The entry in the JSON of the diagnosis and of `plan`; inputs by column, all in SI
        units.
        """
        trial = self.trial
        duration = trial.columns["time"][-1] if "time" in trial.columns else None
        driving = next(iter(name for name in ("pressure", "stretch") if name in trial.columns), "")
        return {
            "protocol": trial.protocol,
            "description": trial.description,
            "changes": list(trial.changes),
            "specimen": trial.specimen.name,
            "mount": trial.specimen.mount,
            "wall": _number(trial.specimen.values.get("wall")),
            "length": _number(trial.specimen.values.get("length")),
            "temperature": float(trial.temperature),
            **({"mode": trial.mode} if trial.mode else {}),
            **({"wrist_rpy": list(trial.wrist_rpy)} if trial.specimen.hand else {}),
            "duration": _number(duration),
            "peak": _furthest(trial.columns[driving]) if driving else None,
            "separation": self.separation,
            "floors": self.floors,
            "breaks": self.breaks,
            "separates": [list(group) for group in self.separates],
            "at_rest": dict(self.at_rest),
            "inputs": {name: values.tolist() for name, values in trial.columns.items()},
        }


def proposal(
    problem: FitProblem, final: Scored, ties: Sequence[Sequence[str]]
) -> dict[str, Any] | None:
    """The entry `next_experiment` of a diagnosis; None if nothing is tied.

    final: the chosen model. ties: for each of the last len(ties) effects of `final.effects`, the
    names of effects that explain as much in its place.
    """
    found = next_experiment(problem, explanations(problem, final, ties))
    return None if found is None else found.as_json()


def explanations(
    problem: FitProblem, final: Scored, ties: Sequence[Sequence[str]]
) -> list[dict[str, Scored]]:
    """For each effect that is tied: fitted models by name, with the effect itself or another one in
    its place.
    """
    added = final.effects[len(final.effects) - len(ties) :]
    groups = []
    for effect, others in zip(added, ties, strict=True):
        if not others:
            continue
        without = score_without(problem, final, effect)
        tried = {name: score_with(problem, without, name) for name in others[: RULES.planned_ties]}
        fitted = {name: model for name, model in tried.items() if isinstance(model, Scored)}
        if fitted:
            groups.append({effect: final, **fitted})
    return groups


def next_experiment(
    problem: FitProblem, groups: Sequence[Mapping[str, Scored]]
) -> Experiment | None:
    """The run that best separates the explanations in each group; None if there is no group, or no
    run that could be made.
    """
    trials = trial_runs(problem.data, problem.base)
    if not groups or not trials:
        return None
    bank = _Bank(problem, trials)
    pairs = [pair for group in groups for pair in combinations(group.values(), 2)]
    apart = np.array([bank.apart(*pair) for pair in pairs])
    telling = [_telling(problem, pair, *both) for pair, both in zip(pairs, apart, strict=True)]
    worst, told = np.min(apart[:, 0], axis=0), np.min(telling, axis=0)
    cost = np.array([len(trial.changes) for trial in trials])
    reached = np.minimum(told, RULES.separation_enough)
    best = np.lexsort([-worst, cost, -np.round(reached / RULES.separation_enough, 1)])[0]
    return Experiment(
        _named_anew(trials[best], problem.data),
        float(worst[best]),
        float(np.min(apart[:, 1, best])),
        bool(told[best] >= RULES.separation_breaks),
        tuple(tuple(group) for group in groups),
        bank.readings_at_rest(groups),
    )


def _telling(
    problem: FitProblem, pair: Sequence[Scored], separation: Array, floors: Array
) -> Array:
    """How far each trial (trials,) takes a pair apart, in standard deviations of the noise as far
    as the diagnosis will heed it.
    """
    better, worse = sorted(pair, key=criterion)
    if criterion(worse) - criterion(better) < problem.rules.tie_deviance:
        return separation
    if leaves_more_than_noise(problem, better):
        return np.zeros_like(separation)
    return np.minimum(separation, RULES.separation_breaks * floors)


class _Bank:
    """All trials, in which pairs of explanations are compared over the readings that there are."""

    def __init__(self, problem: FitProblem, trials: Sequence[TrialRun]) -> None:
        self._problem, self._trials = problem, trials
        self._from: dict[float, _Planned] = {}

    def apart(self, first: Scored, second: Scored) -> Array:
        """Separation, and distance over the noise floor, of two explanations: (2, trials).

        A pressure sensor never reads less than on a chamber that is open to the air. If the two
        explanations predict different readings there, readings in between would rule out one of
        them, and a lack of such readings the other.
        """
        low, high = sorted(_open_reading(self._problem, s) for s in (first, second))
        surely = self._planned(high).apart(first, second)
        if not self._is_told(low, high):
            return surely
        lower = self._planned(low).apart(first, second)
        lower[0] = np.minimum(lower[0], 1.0 / RULES.zero_agreement)
        return np.maximum(surely, lower)

    def readings_at_rest(self, groups: Sequence[Mapping[str, Scored]]) -> dict[str, float]:
        """Reading [Pa] of a gauge on an open chamber, by explanation, where it separates a pair."""
        found = {
            name: _open_reading(self._problem, scored)
            for group in groups
            for name, scored in group.items()
        }
        low, high = min(found.values()), max(found.values())
        return found if self._is_told(low, high) else {}

    def _is_told(self, low: float, high: float) -> bool:
        zero = max(abs(low), abs(high))
        differ = high - low > RULES.zero_agreement * zero
        return differ and not len(read_at_rest(self._problem.data, zero))

    def _planned(self, lowest: float) -> _Planned:
        lowest = max(lowest, 0.0)
        if lowest not in self._from:
            trials = [_from(trial, lowest) for trial in self._trials]
            self._from[lowest] = _Planned(self._problem, trials)
        return self._from[lowest]


def _open_reading(problem: FitProblem, scored: Scored) -> float:
    """Pressure [Pa] that a sensor shows of an open chamber, if the explanation holds: there are no
    lower readings that could tell it from others.
    """
    peaks = [
        run.columns["pressure"].max() for run in problem.data.runs if "pressure" in run.columns
    ]
    if not peaks:
        return 0.0
    reading = np.linspace(-1.0, 1.0, 2 * READINGS + 1) * float(max(peaks))
    chamber = reading
    fitted = scored.fit.likelihood.forward.effects_at(scored.fit.values[None])  # type: ignore[attr-defined]
    for effect in fitted:
        if isinstance(effect, InputEffect) and not effect.has_memory:
            chamber = np.ravel(effect.chamber_pressure(chamber[None, None], {}, 0.0))
    vented = reading[chamber < 0.0]
    return float(vented[-1] + reading[READINGS + 1]) if len(vented) else 0.0


def _from(trial: TrialRun, lowest: float) -> TrialRun:
    """The trial with readings from a lowest one [Pa]."""
    if "pressure" not in trial.columns:
        return trial
    return replace(
        trial, columns={**trial.columns, "pressure": np.maximum(trial.columns["pressure"], lowest)}
    )


def _named_anew(trial: TrialRun, data: MeasurementSet) -> TrialRun:
    """The trial under a name that no protocol of the set has: it is no repeat of one."""
    name = trial.protocol
    while name in data.protocols():
        name += "_planned"
    return replace(trial, protocol=name)


class _Planned:
    """All trials as runs of one set, each of a specimen of its own, behind what came before."""

    def __init__(self, problem: FitProblem, trials: Sequence[TrialRun]) -> None:
        self._problem = problem
        self._known: dict[tuple[str, ...], Array] = {}
        data = problem.data
        earlier = data.runs if problem.base == "linear" else ()
        specimens, runs = dict(data.specimens), list(earlier)
        for index, trial in enumerate(trials):
            name = f"trial {index}"
            run = run_of(trial, name, data.outputs)
            if problem.base == "linear":  # its coefficients belong to specimens by name
                runs.append(run)
                continue
            specimens[name] = replace(trial.specimen, name=name)
            before = _history(data, trial, f"before {name}")
            runs += [replace(before, specimen=name)] if before is not None else []
            runs.append(replace(run, specimen=name))
        self.data = replace(data, specimens=specimens, runs=tuple(runs))
        self._parts = [
            np.flatnonzero(self.data.table.run == index)
            for index, run in enumerate(self.data.runs)
            if run.name.startswith("trial ")
        ]

    def apart(self, first: Scored, second: Scored) -> Array:
        """Separation, and distance over the noise floor, of two explanations: (2, trials)."""
        rows = [self._rows(scored) for scored in (first, second)]
        spectrum = make_spectrum(self.data.table, rows[0][0])
        level = np.sqrt(self._levels(spectrum))
        white = [spectrum.coefficients(each) / level for each in rows]
        return np.array(
            [
                [_separation(white[0][:, part], white[1][:, part]) for part in self._parts],
                [_rms(rows[0][0, part] - rows[1][0, part]) for part in self._parts],
            ]
        ) / np.array([[1.0], [self._problem.floor.total]])

    def _rows(self, scored: Scored) -> Array:
        if scored.effects not in self._known:
            self._known[scored.effects] = self._predicted(scored)
        return self._known[scored.effects]

    def _predicted(self, scored: Scored) -> Array:
        """Rows (1 + k, samples): prediction, and Jacobian times the root of the covariance. What a
        trial needs and the set does not show, as the other direction of pulses, is at its start.
        """
        forward = replace(self._problem, data=self.data).likelihood(scored.effects).forward
        fit = scored.fit
        scales = fit.likelihood.scales
        center, step = scales.inward(fit.values), fit.likelihood.slope_step * scales.width
        values = scales.outward(np.vstack([center, center + np.diag(step)]))
        order = [p.name for p in fit.likelihood.parameters]
        columns = [
            values[:, order.index(p.name)] if p.name in order else np.full(len(values), p.start)
            for p in forward.parameters
        ]
        rows = forward.predict(np.stack(columns, axis=1))
        jacobian = (rows[1:] - rows[:1]) / step[:, None]
        level, vectors = np.linalg.eigh(fit.covariance)
        root = vectors * np.sqrt(np.maximum(level, 0.0))
        return np.vstack([rows[:1], root.T @ jacobian])

    def _levels(self, spectrum: Spectrum) -> Array:
        """Noise variance (samples,) of every coefficient; bands not seen are like the finest."""
        known = self._problem.spectrum.band_output
        variance = self._problem.floor.variance
        of_band = np.empty(spectrum.band_count)
        for output in np.unique(spectrum.band_output):
            mine = np.flatnonzero(spectrum.band_output == output)
            seen = variance[known == output]
            of_band[mine] = seen[np.minimum(np.arange(len(mine)), len(seen) - 1)]
        return of_band[spectrum.bands]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _separation(first: Array, second: Array) -> float:
    """Separation of two explanations, rows as of `_Planned._predicted` in units of noise."""
    target = first[0] - second[0]
    give = np.vstack([first[1:], second[1:]])
    taken = give @ target
    inner = np.eye(len(give)) + give @ give.T
    square = target @ target - taken @ np.linalg.solve(inner, taken)
    return float(np.sqrt(max(square, 0.0)))


def _history(data: MeasurementSet, trial: TrialRun, name: str) -> Run | None:
    """A quick run to the largest input of the trial's specimen so far, which it remembers; None for
    a specimen that is new or that nothing drives.
    """
    driving = next((name for name in ("pressure", "stretch") if name in trial.columns), None)
    own = [run for run in data.runs if run.specimen == trial.specimen.name]
    if driving is None or not own or data.experiment == "base_torque":
        return None
    rest = float(trial.columns[driving][0])
    most = max(float(run.columns[driving].max()) for run in own)
    rise = np.interp(
        np.arange(HISTORY_SAMPLES), [0, HISTORY_SAMPLES / 2, HISTORY_SAMPLES], [0, 1, 0]
    )
    columns = {
        "time": np.arange(HISTORY_SAMPLES) * float(np.max(trial.columns["time"])) / HISTORY_SAMPLES,
        driving: rest + (most - rest) * rise,
    } | {name: np.zeros(HISTORY_SAMPLES) for name in data.outputs}
    return Run(name, "", name, trial.temperature, columns, mode=trial.mode)


def _furthest(course: Array) -> float:
    """The value of a course (n,) that lies furthest from where it begins."""
    return float(course[np.argmax(np.abs(course - course[0]))])


def _number(value: Any) -> float | None:
    return float(value) if value is not None and np.ndim(value) == 0 else None
