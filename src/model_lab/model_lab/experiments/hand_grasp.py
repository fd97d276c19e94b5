"""Grasps of a whole hand: wrench at the wrist, pressures, and where the object is."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from model_lab.aliases import Array, Mask
from model_lab.experiments.grasp_rollouts import (
    FINER_ENGINES,
    OTHER_ENGINE,
    USUAL_ENGINE,
    Engine,
    Tried,
    columns_of,
    of_gauge,
    rollouts,
)
from model_lab.experiments.hand_pose import in_lane
from model_lab.experiments.own_errors import OwnErrors
from model_lab.experiments.samples import modulus_of_runs, modulus_scales
from model_lab.measurements.hands import GRASP, OBJECT_PLACE, WRIST_POSE
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.specimens import DOCUMENT, require_columns
from model_lab.rules import RULES
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import matrices
from softhand_model.effects import Effect, Parameter
from softhand_model.effects.hand import HandEffect, effects_of_hand
from softhand_model.model_file import Model

SIMULATED_MODULI = (0.85, 1.0, 1.15)  # that are simulated
HALVINGS = 2  # of the way between values at which a run ends as measured, and otherwise; by hand
BEYOND_USUAL = 1.3  # ends of what is simulated over usual ones, from the neutral value


class HandGrasp:
    """Outputs (lanes, samples) of hands that grasp, run after run: wrenches at the wrist [N and N
    m], pressures [Pa] and places of the object [m], each times its factor of `scales_of`.

    A simulator replays the path of the wrist and the air of each run, with all effects whose
    parameters are fixed. For each free parameter, and for the modulus, the change that it alone
    causes is simulated at a few values, in the first run of each protocol, and interpolated between
    them (PCHIP), so that contacts that open and close from step to step do not disturb the fit.
    Values at which a run ends otherwise than measured, held or lost, are left out of its curve, and
    values between these and the next ones are simulated in its protocol, too. A prediction
    is the fixed model plus the sum of these changes (`closer_grasp` simulates the model that is
    named). Effects on what the wrist's sensor reads are computed exactly.

    Raises DocumentError for a missing column or object, ValueError where no simulator is installed.
    """

    def __init__(self, data: MeasurementSet, engine: Engine = USUAL_ENGINE) -> None:
        require_columns(data, data.inputs, f"the model of {data.experiment}")
        if data.grasped is None:
            raise DocumentError(
                f"{data.folder / DOCUMENT}: expected an entry `object`, got none; "
                "add object: cylinder"
            )
        self._data, self._engine = data, engine
        self._courses: dict[Hashable, _Course] = {}
        turns = np.concatenate([columns_of(run, WRIST_POSE[3:]) for run in data.runs])
        self._turn = np.moveaxis(matrices(turns.T), -1, 0)
        self._batch = np.concatenate(
            [np.full(run.samples, data.specimens[run.specimen].batch) for run in data.runs]
        )
        first = {member: group[0] for group in data.groups() for member in group}
        self._scales = _scales(data)
        self._last: Array | None = None
        sizes = [run.samples for run in data.runs]
        self._run = np.repeat(np.arange(len(sizes)), sizes)
        self._twin = [first[n] if sizes[first[n]] == sizes[n] else n for n in range(len(sizes))]

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Names of the calibration with the values from which a search starts."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Predictions (lanes, samples): calibration (lanes,) by name, effects in lanes."""
        sought = [effect for effect in effects if any(map(np.ndim, effect.values.values()))]
        stays = [effect for effect in effects if effect not in sought]
        numbers = [*calibration.values(), *(v for e in sought for v in e.values.values())]
        lanes = max((np.size(number) for number in numbers), default=1)
        seen = np.tile(self._stated(stays), (lanes, 1, 1))
        for name, scales in calibration.items():
            mine = self._batch == name.removeprefix("modulus_scale[").removesuffix("]")
            moved = self._by_modulus(stays)(np.broadcast_to(np.ravel(scales), lanes))
            seen[:, mine] += moved[:, mine]
        for effect in sought:
            for parameter in [] if of_gauge(effect) else effect.parameters:
                values = np.broadcast_to(np.ravel(effect.values[parameter.name]), lanes)
                seen += self._by_parameter(stays, type(effect), parameter)(values)
        predicted = np.empty((lanes, self._data.table.samples))
        for lane in range(lanes):
            read = self._read(seen[lane], [in_lane(effect, lane) for effect in effects])
            predicted[lane] = self._in_table(read)
        self._last = predicted[0]
        return predicted

    @property
    def unsettled(self) -> dict[int, str]:
        """Runs, by index, that end otherwise than in the last prediction, held or lost, in words.
        Few such runs are near a border between the two, and no evidence of an effect; none is told
        if there are more than a share `Rules.border_runs`.
        """
        if self._last is None:
            return {}
        ends = zip(held(self._data), held(self._data, self._last), strict=True)
        found = {
            number: f"the object was {'held' if seen else 'lost'}, and not as predicted"
            for number, (seen, told) in enumerate(ends)
            if seen != told
        }
        return found if len(found) <= RULES.border_runs * len(self._data.runs) else {}

    def _stated(self, effects: Sequence[Effect]) -> Array:
        """What is seen (rows, outputs) with these effects and the stated modulus."""
        return np.concatenate(_of_every(self._data, (effects, 1.0), self._engine))

    def _of_firsts(self, tried: Sequence[Tried], firsts: Sequence[Collection[int]]) -> Array:
        """Simulated outputs (tried, rows, outputs) for each of several effects and moduli, in some
        first runs of protocols; every run gets those of the first one of its protocol, or NaN.
        """
        asked = [(n, *one) for one, mine in zip(tried, firsts, strict=True) for n in sorted(mine)]
        found = iter(rollouts(self._data, asked, self._engine))
        seen = np.full((len(tried), len(self._run), len(self._data.outputs)), np.nan)
        for one, mine in enumerate(firsts):
            for first in sorted(mine):
                outputs = next(found)
                for run in np.flatnonzero(np.equal(self._twin, first)):
                    seen[one, self._run == run] = outputs
        return seen

    def _changes(
        self,
        effects: Sequence[Effect],
        tried: Sequence[Tried],
        firsts: Sequence[Collection[int]] | None = None,
    ) -> tuple[Array, Mask]:
        """Changes (tried, rows, outputs) by other effects and moduli, and which of them are usable
        in a run (tried, runs): those with which it ends as measured, held or lost. If it ends
        otherwise without them, too, all are, as changes are from there. firsts: first runs of
        protocols that are simulated, for each that is tried; others are NaN; None: all.
        """
        every = set(self._twin)
        firsts = [every] * len(tried) if firsts is None else firsts
        seen = self._of_firsts([(effects, 1.0), *tried], [every, *firsts])
        measured = held(self._data)
        alike = np.array([np.equal(measured, held(self._data, self._in_table(o))) for o in seen])
        return np.asarray(seen[1:] - seen[0]), alike[1:] | ~alike[0]

    def _in_table(self, seen: Array) -> Array:
        """Outputs (samples,) [N] of what is seen (rows, outputs)."""
        table = self._data.table
        return np.asarray((self._scales * seen.T)[table.output, table.row])

    def _by_modulus(self, effects: Sequence[Effect]) -> _Course:
        tried = [(effects, scale) for scale in SIMULATED_MODULI]
        key = (*_told(effects),)
        if key not in self._courses:
            changes, usable = self._changes(effects, tried)
            self._courses[key] = _Course(np.array(SIMULATED_MODULI), changes, usable[:, self._run])
        return self._courses[key]

    def _by_parameter(
        self, effects: Sequence[Effect], kind: type[Effect], parameter: Parameter
    ) -> _Course:
        key = (*_told(effects), kind.name, parameter.name)
        if key not in self._courses:
            every: Collection[int] = set(self._twin)
            firsts = dict.fromkeys(simulated_values(parameter), every)
            changes, usable = self._at_values(effects, kind, parameter, firsts)
            for _ in range(HALVINGS):
                firsts |= self._between(parameter, firsts, usable)
                changes, usable = self._at_values(effects, kind, parameter, firsts)
            for _ in range(HALVINGS if parameter.logarithmic else 0):
                course = _Course(np.array(sorted(firsts)), changes, usable[:, self._run])
                tried = self._halfway_in_one(parameter, firsts, changes, usable)
                more = firsts | tried  # not kept unless in all protocols, whose courses are alike
                probed, _ = self._at_values(effects, kind, parameter, more)
                firsts |= dict.fromkeys(self._far_from(course, more, tried, probed), every)
                changes, usable = self._at_values(effects, kind, parameter, firsts)
            self._courses[key] = _Course(np.array(sorted(firsts)), changes, usable[:, self._run])
        return self._courses[key]

    def _halfway_in_one(
        self,
        parameter: Parameter,
        firsts: Mapping[float, Collection[int]],
        changes: Array,
        usable: Mask,
    ) -> dict[float, Collection[int]]:
        """Values halfway between neighbours that are simulated in all protocols, each with the
        first run of the one that changes most between the two, of those in which both are usable.
        """
        every, values = set(self._twin), sorted(firsts)
        found: dict[float, Collection[int]] = {}
        for low, high in pairwise(range(len(values))):
            way = self._sizes(changes[high] - changes[low])
            known = [first for first in every if usable[[low, high], first].all()]
            if known and all(set(firsts[values[end]]) == every for end in (low, high)):
                middle = _halfway(parameter, values[low], values[high])
                found[middle] = {max(known, key=lambda first: way[first])}
        return found

    def _far_from(
        self,
        course: _Course,
        firsts: Mapping[float, Collection[int]],
        tried: Mapping[float, Collection[int]],
        changes: Array,
    ) -> list[float]:
        """Those of the tried values at which a course errs by more than a share `Rules.bent_share`
        of what is changed between the two next to them.
        """
        values, found = sorted(firsts), []
        told = course(np.array(values))
        for value, (first,) in tried.items():
            at = values.index(value)
            error = self._sizes(told[at] - changes[at])[first]
            way = self._sizes(changes[at + 1] - changes[at - 1])[first]
            if error > RULES.bent_share * way:
                found.append(value)
        return found

    def _sizes(self, seen: Array) -> Array:
        """Root mean square (runs,) [N] of changes of what is seen (rows, outputs)."""
        squares = np.mean((self._scales * seen.T) ** 2, axis=0)
        count = len(self._data.runs)
        return np.sqrt(np.array([squares[self._run == run].mean() for run in range(count)]))

    def _between(
        self, parameter: Parameter, firsts: Mapping[float, Collection[int]], usable: Mask
    ) -> dict[float, Collection[int]]:
        """Values halfway between two of which one is usable (values, runs) and one not, with the
        first runs of protocols in which that is so.
        """
        found: dict[float, set[int]] = {}
        for run, first in enumerate(self._twin):
            mine = {
                v: u
                for v, u in zip(sorted(firsts), usable[:, run], strict=True)
                if first in firsts[v]
            }
            for low, high in pairwise(mine):
                if mine[low] != mine[high]:
                    found.setdefault(_halfway(parameter, low, high), set()).add(first)
        return dict(found)

    def _at_values(
        self,
        effects: Sequence[Effect],
        kind: type[Effect],
        parameter: Parameter,
        firsts: Mapping[float, Collection[int]],
    ) -> tuple[Array, Mask]:
        """`_changes` by the values of a parameter, in ascending order; firsts: first runs of
        protocols in which each value is simulated.
        """
        values, neutral = sorted(firsts), float(parameter.neutral or 0.0)
        still = {other.name: other.neutral for other in kind.parameters}
        alike = values[0] < neutral and not parameter.logarithmic  # both ways: one is simulated
        moved = [value for value in values if (value > neutral if alike else value != neutral)]
        tried = [
            ([*effects, kind(**{**still, parameter.name: value})], 1.0)  # type: ignore[arg-type]
            for value in moved
        ]
        changes, usable = self._changes(effects, tried, [firsts[value] for value in moved])
        if alike:
            changes = np.concatenate([-changes[::-1], changes])
            usable = np.concatenate([usable[::-1], usable])
        place = values.index(neutral)
        return np.insert(changes, place, 0.0, axis=0), np.insert(usable, place, True, axis=0)

    def _read(self, seen: Array, effects: Sequence[Effect]) -> Array:
        """What is read (rows, outputs) of what there is: the gauge at the wrist may err."""
        wrench, gain = seen[:, :6], 1.0
        for effect in effects_of_hand(effects):
            gain *= effect.wrench_gain()
            bias = effect.wrench_bias().reshape(2, 3)
            wrench = wrench + (self._turn[:, None] @ bias[..., None]).reshape(-1, 6)
        return np.hstack([gain * wrench, seen[:, 6:]])


def _told(effects: Sequence[Effect]) -> Sequence[Hashable]:
    """What distinguishes effects that stay."""
    return sorted((effect.name, *map(float, effect.values.values())) for effect in effects)


class _Course:
    """Changes (lanes, rows, outputs) at values (lanes,) of a parameter, through those (values,
    rows, outputs) that were simulated; beyond them as at the last. Of a row those without a result
    are left out, and those that are not usable (values, rows), if two others stay. The change by a
    mass is proportional to it, so no logarithm is taken.
    """

    def __init__(self, values: Array, changes: Array, usable: Mask) -> None:
        known = np.isfinite(changes).all(axis=2)
        usable = usable & known
        usable = np.where(usable.sum(axis=0) < 2, known, usable)
        self._through: list[tuple[Mask, PchipInterpolator]] = []
        for used in np.unique(usable, axis=1).T:
            if used.sum() < 2:
                continue
            rows = (used[:, None] == usable).all(axis=0)
            through = PchipInterpolator(values[used], changes[used][:, rows])
            self._through.append((rows, through))
        self._shape = changes.shape[1:]

    def __call__(self, values: Array) -> Array:
        found = np.full((len(values), *self._shape), np.nan)
        for rows, through in self._through:
            found[:, rows] = through(np.clip(values, through.x[0], through.x[-1]))
        return found


def simulated_values(parameter: Parameter) -> list[float]:
    """Values of a parameter at which it is simulated: its neutral value, and one or two values
    somewhat beyond the ends of its usual range.
    """
    low, high = parameter.typical or (parameter.low, parameter.high)
    neutral = float(parameter.neutral or 0.0)
    inward, outward = (np.log, np.exp) if parameter.logarithmic else (np.asarray, np.asarray)
    ends = np.array([high]) if low >= neutral else np.array([low, high])
    found = outward(inward(neutral) + BEYOND_USUAL * (inward(ends) - inward(neutral)))
    inside = np.clip(found, parameter.low, parameter.high)
    return np.unique(np.append(inside.round(12), neutral)).tolist()


def _halfway(parameter: Parameter, low: float, high: float) -> float:
    """The value in the middle between two of a parameter."""
    return float(np.sqrt(low * high)) if parameter.logarithmic else 0.5 * (low + high)


def within_simulated(classes: Mapping[str, type[Effect]]) -> dict[str, type[Effect]]:
    """The effect classes, with bounds of their parameters that exclude values beyond the simulated
    ones.
    """
    return {name: _bounded(kind) for name, kind in classes.items()}


def _bounded(kind: type[Effect]) -> type[Effect]:
    if GRASP not in kind.experiments or not issubclass(kind, HandEffect) or kind.of_measurement:
        return kind
    bounded = []
    for parameter in kind.parameters:
        values = simulated_values(parameter)
        low, high = parameter.typical or (parameter.low, parameter.high)
        usual = (max(low, values[0]), min(high, values[-1]))
        bounded.append(replace(parameter, low=values[0], high=values[-1], typical=usual))
    parts = {"parameters": tuple(bounded), "__doc__": kind.__doc__}
    return type(kind.__name__, (kind,), parts)


def simulated(
    data: MeasurementSet, effects: Sequence[Effect], scale: float | Array, engine: Engine
) -> Array:
    """Simulated outputs (samples,) [N] of a set, as its sensors would read them, with these effects
    and a factor `scale` [-] on the modulus, one or (runs,).
    """
    grasp, scales = HandGrasp(data, engine), np.broadcast_to(scale, len(data.runs)).tolist()
    asked = [(run, effects, one) for run, one in enumerate(scales)]
    read = grasp._read(np.concatenate(rollouts(data, asked, engine)), effects)
    return grasp._in_table(read)


def _of_every(data: MeasurementSet, one: Tried, engine: Engine) -> list[Array]:
    """Simulated outputs (samples, outputs) of all runs."""
    return rollouts(data, [(run, *one) for run in range(len(data.runs))], engine)


def closer_grasp(
    data: MeasurementSet,
    calibration: Mapping[str, Array],
    effects: Sequence[Effect],
    predicted: Array,
) -> tuple[Array, None]:
    """Predictions (samples,) of a fitted model in which each run is simulated with the fitted
    values; `predicted` (samples,), which is interpolated, in runs that then end otherwise than
    measured, held or lost. Errors of the predictions stay as they are (None).
    """
    scales = modulus_of_runs(data, calibration)[0, :, 0]
    found = simulated(data, effects, scales, USUAL_ENGINE)
    alike = np.equal(held(data), held(data, found))
    return np.where(alike[data.table.run], found, predicted), None


def _scales(data: MeasurementSet) -> Array:
    """Factors (outputs, rows) from columns of a set to values of its table."""
    return np.concatenate([data.scales_of(run) for run in data.runs], axis=1)


def grasp_errors(data: MeasurementSet, model: Model) -> OwnErrors:
    """Errors of the predictions themselves, which repeats do not show. Each is the change of the
    predictions by one source: another start of the object along x, or along y; more segments,
    unless the set states how many; a shorter step; the other engine, if it is installed. They are
    simulated in every run, as where an object begins decides how roughly it is touched.
    """
    acting = [effect for effect in model.effects if data.experiment in effect.experiments]
    engines = [*FINER_ENGINES, *([OTHER_ENGINE] if find_spec(OTHER_ENGINE.name) else [])]
    if data.hand_segments:  # a simulated hand, which has these
        engines = [engine for engine in engines if engine.segments == USUAL_ENGINE.segments]
    tried = [(data, engine) for engine in engines]
    tried += [(_shifted(data, name), USUAL_ENGINE) for name in OBJECT_PLACE[:2]]
    table, scales = data.table, _scales(data)
    stated, *moved = (
        np.concatenate(_of_every(other, (acting, 1.0), engine))
        for other, engine in ((data, USUAL_ENGINE), *tried)
    )
    rows = [(scales * (one - stated).T)[table.output, table.row] for one in moved]
    return OwnErrors(np.stack(rows))


def weighted(data: MeasurementSet, model: Model) -> MeasurementSet:
    """The set with weights by which samples count less where predictions err much themselves:

        w = 1 / sqrt(1 + (e / e0)^2),

    with the errors e of `grasp_errors`, root mean square over a time `Rules.grasp_phase` about each
    sample of an output in a run, and their median e0 over the set. So weighted errors are at
    most about e0 everywhere, and a protocol in which engines differ much does not hide what another
    one shows.
    """
    bare = replace(data, runs=tuple(replace(run, weights=1.0) for run in data.runs))
    squares = np.sum(grasp_errors(bare, model).rows ** 2, axis=0)
    near = []
    for number, run in enumerate(bare.runs):
        time = run.columns["time"]
        mine = np.abs(time[:, None] - time) <= 0.5 * RULES.grasp_phase
        near.append(bare.table.of_run(squares, number) @ mine / mine.sum(axis=0))
    usual = np.median(np.concatenate(near, axis=1))
    if not usual > 0.0:
        return bare
    runs = (
        replace(run, weights=1.0 / np.sqrt(1.0 + square / usual))
        for run, square in zip(bare.runs, near, strict=True)
    )
    return replace(bare, runs=tuple(runs))


def _shifted(data: MeasurementSet, name: str) -> MeasurementSet:
    """The set with the object elsewhere along an axis."""
    runs = (
        replace(run, columns={**run.columns, name: run.columns[name] + RULES.object_start})
        for run in data.runs
    )
    return replace(data, runs=tuple(runs))


def held(data: MeasurementSet, predicted: Array | None = None) -> list[bool]:
    """Whether each run ends with the object held: it has risen by more than `Rules.lifted_share` of
    the way that the wrist has gone up. predicted: outputs (samples,) to judge; None: the measured
    ones.
    """
    values = data.table.value if predicted is None else predicted
    found = []
    for number, run in enumerate(data.runs):
        course = data.table.of_run(values, number) / data.scales_of(run)
        height = course[data.outputs.index(OBJECT_PLACE[2])]
        wrist = run.columns[WRIST_POSE[2]]
        up = height[-1] - height[0]
        found.append(bool(up > RULES.lifted_share * (wrist[-1] - wrist.min())))
    return found
