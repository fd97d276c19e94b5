"""Presses of a whole hand on a level plate: force and torque at the wrist along its path."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np

from model_lab.aliases import Array, Indices, IntArray
from model_lab.experiments.hand_motion import MOST_KEPT, SMALLER
from model_lab.experiments.hand_pose import HandPose, at_lane, in_lane, shifted
from model_lab.experiments.own_errors import OwnErrors
from model_lab.experiments.samples import SampleRows
from model_lab.measurements.hands import WRIST_POSE, Plate
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.specimens import DOCUMENT
from model_lab.rules import RULES
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import from_rpy, matrices, rotate
from softhand_model.chain.chain import ChainModel
from softhand_model.chain.free_response import HIGHEST_OVER_LIMIT
from softhand_model.dynamics.press import Skin
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.hand import effects_of_hand, friction_factor
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from softhand_model.motion.moving_body import MovingBody
from softhand_model.motion.pressed_body import (
    Pressed,
    PressedBody,
    PressPath,
    press_path,
    skin_of,
)

PRESS_SEGMENTS, PRESS_STEP = 8, 0.05  # of an actuator; [s] at the most, in between samples
FINE_PRESS_SEGMENTS, FINE_PRESS_STEP = 16, 0.02  # with which the error of these is taken off
KEPT_PRESSES = 1024  # of bodies in all runs
SLOPE_STEP = 0.01  # of a parameter's usual range, over which roundings of contact average out
_KEPT: dict[Hashable, tuple[HandDescription, Array]] = {}


class HandPress(HandPose):
    """Wrench at the wrist (lanes, samples) of hands that are pressed on a level plate: a lane is
    one set of parameters, samples are those of all runs in turn.

    Forces are in N, torques are divided by TORQUE_ARM and in N, too; both in the axes of the world.
    The model (`softhand_model.motion.pressed_body`) divides each finger into a few rigid segments
    that follow the path of the wrist, and takes the whole hand to accelerate as the wrist does. It
    has no contacts between parts of the hand, and none of the palm. For the hand as the set states
    it, the wrench is also computed with more segments and shorter steps; the difference is added to
    all predictions. A prediction is NaN where a pressure is too high for any hand, or where a joint
    does not come to rest even in smaller steps.

    segments: number of segments per actuator; None: PRESS_SEGMENTS, or that of the simulated hand.
    step: time step [s], without that correction; None: PRESS_STEP, with it.
    unsettled: by index of a run that is NaN in the last prediction, the joint that did not come to
    rest, as text.

    Raises DocumentError for a missing column or plate, for too few samples or samples too far apart
    in time, and for a palm that would touch the plate.
    """

    most_kept, slope_step = KEPT_PRESSES, SLOPE_STEP

    def __init__(
        self, data: MeasurementSet, segments: int | None = None, step: float | None = None
    ) -> None:
        self._step, self._corrected = step or PRESS_STEP, step is None
        self.unsettled: dict[int, str] = {}
        super().__init__(data, segments or data.hand_segments or PRESS_SEGMENTS)

    def _take_rows(self) -> None:
        """All samples of all runs, and the paths of their wrists."""
        data = self._data
        place = f"{data.folder / DOCUMENT}"
        if data.plate is None:
            raise DocumentError(
                f"{place}: expected an entry `plate`, got none; add plate: {{friction: 0.6}}"
            )
        self._plate = data.plate
        for run in data.runs:
            _check(data, run)
        self._run = SampleRows(data).run
        self._pressures = np.array(
            [np.concatenate([run.columns[name] for run in data.runs]) for name in data.pressures]
        )
        self._batch = np.array([data.specimens[run.specimen].batch for run in data.runs])[self._run]
        largest = HIGHEST_OVER_LIMIT * self._hand.max_pressures()
        self._possible = bool((np.abs(self._pressures).max(axis=1) < largest).all())
        self._first = _first_alike(data)
        for first in set(self._first):
            mine = [self._run == run for run, other in enumerate(self._first) if other == first]
            mean = np.mean([self._pressures[:, rows] for rows in mine], axis=0)
            for rows in mine:
                self._pressures[:, rows] = mean
        turns = np.concatenate([_pose(run)[:, 3:] for run in data.runs])
        self._turn = np.moveaxis(matrices(turns.T), -1, 0)

    def _driven(self) -> Hashable:
        runs = tuple(
            (_driven(self._data, run), run.temperature, self._data.specimens[run.specimen].batch)
            for run in self._data.runs
        )
        return runs, self._plate.height, self._step

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Forces and torques (lanes, samples): calibration (lanes,) by name, effects in lanes."""
        if not self._possible:
            lanes = max((np.size(number) for number in calibration.values()), default=1)
            return np.full((lanes, self._data.table.samples), np.nan)
        self.unsettled = {}
        found = super().predict(calibration, effects)
        if self._corrected:
            found = found + _taken_off(self._data, self._segments)
        if self._plate.tared:
            found = found - found[:, _begins(self._data)]
        wild = np.asarray(np.isnan(found).any(axis=0))
        for run in {part.run for part in self._data.table.series if wild[part.samples].any()}:
            self.unsettled.setdefault(run, "the hand has no equilibrium")
        return found

    def _read(self, wrench: Array, effects: Sequence[Effect]) -> Array:
        """What the gauge reads (rows, 6) of a wrench."""
        read, gain = wrench, 1.0
        for effect in effects_of_hand(effects):
            gain *= effect.wrench_gain()
            bias = effect.wrench_bias().reshape(2, 3)
            read = read + (self._turn[:, None] @ bias[..., None]).reshape(-1, 6)
        return np.asarray(gain * read)

    def _lane(
        self, calibration: Mapping[str, Array], effects: Sequence[Effect], lane: int
    ) -> Array:
        acting = [in_lane(effect, lane) for effect in effects]
        wrench = np.empty((len(self._batch), 6))
        for batch in dict.fromkeys(self._batch.tolist()):
            rows = np.flatnonzero(self._batch == batch)
            scale = at_lane(calibration.get(f"modulus_scale[{batch}]", 1.0), lane)
            wrench[rows] = np.sum([*self._places(scale, acting, rows).values()], axis=0)
        table = self._data.table
        columns = self._data.output_scales[:, None] * self._read(wrench, acting).T
        return np.asarray(columns[table.output, table.row])

    def _around(self, effects: Sequence[Effect]) -> Hashable:
        higher = sum(effect.plate_offset() for effect in effects_of_hand(effects))
        return self._plate.friction * friction_factor(effects), self._plate.height + higher

    def _body(
        self, hand: HandDescription, models: Mapping[str, ChainModel], damping: float, around: Any
    ) -> MovingBody:
        chains = tuple(models)
        skins = self._kept.parts
        if chains not in skins:  # which no effect changes
            skins[chains] = skin_of(hand, chains, self._segments)
        return _OnPlate(hand, models, damping, around, skins[chains])

    def _moved(
        self, body: Any, pressures: Array, gravity: float, scale: float, rows: Indices
    ) -> Any:
        mine = np.unique(self._run[rows]).tolist()
        first = sorted({self._first[index] for index in mine})
        known: dict[int, Pressed] = {}
        for smaller in (1.0, *SMALLER):
            wild = [index for index in first if index not in known or known[index].unsettled]
            runs = [self._data.runs[index] for index in wild]
            pressed = body.press(
                [self._path(index, smaller * self._step) for index in wild],
                [run.columns["time"] for run in runs],
                [pressures[:, self._run[rows] == index] for index in wild],
                body.height,
                body.friction,
                scale,
                [run.temperature for run in runs],
                gravity,
            )
            known |= dict(zip(wild, pressed, strict=True))
            if not any(one.unsettled for one in pressed):
                break
        return {index: known[self._first[index]] for index in mine}

    def _path(self, index: int, step: float) -> PressPath:
        """The path of a run's wrist in steps [s] at the most."""
        paths = self._kept.parts
        if (index, step) not in paths:
            paths[index, step] = _path(self._data.runs[index], step)
        found: PressPath = paths[index, step]
        return found

    def _scaled(self, whole: Hashable, at_scale: Callable[[float], Any], scale: float) -> Any:
        return at_scale(scale)  # no polynomial follows contact

    def _markers_of(
        self, body: MovingBody, shape: Any, effects: Sequence[Effect], rows: int
    ) -> dict[str, Array]:
        """The wrench (rows, 6) of a body, by its first actuator; NaN without an equilibrium."""
        if shape is None:
            return {body.actuators[0]: np.full((rows, 6), np.nan)}
        self.unsettled |= {run: one.unsettled for run, one in shape.items() if one.unsettled}
        return {body.actuators[0]: np.concatenate([one.wrench for one in shape.values()])}


class _OnPlate(PressedBody):
    """A body with the plate that it is pressed on: its friction [-] and height [m]."""

    def __init__(
        self,
        hand: HandDescription,
        models: Mapping[str, ChainModel],
        damping: float,
        plate: tuple[float, float],
        skin: Skin,
    ) -> None:
        super().__init__(hand, models, damping, skin)
        self.friction, self.height = plate


def _plate_of(data: MeasurementSet) -> Plate:
    """The plate of a set; raises DocumentError without one."""
    if data.plate is None:
        raise DocumentError(
            f"{data.folder / DOCUMENT}: expected an entry `plate`, got none; "
            "add plate: {friction: 0.6}"
        )
    return data.plate


def _first_alike(data: MeasurementSet) -> list[int]:
    """For each run the first one that is driven like it: along the same path, in the same batch,
    by pressures that differ less (rms) than the zeros of sensors may. They are pressed once, at
    their mean pressures.
    """
    firsts: dict[Hashable, list[int]] = {}
    found = []
    for index, run in enumerate(data.runs):
        path = b"".join(run.columns[name].tobytes() for name in ("time", *WRIST_POSE))
        known = firsts.setdefault((path, run.temperature, data.specimens[run.specimen].batch), [])
        for first in known:
            other = data.runs[first].columns
            apart = [np.mean((run.columns[name] - other[name]) ** 2) for name in data.pressures]
            if max(apart) < RULES.pressure_zero**2:
                found.append(first)
                break
        else:
            known.append(index)
            found.append(index)
    return found


def _driven(data: MeasurementSet, run: Run) -> bytes:
    """What drives a run."""
    names = ("time", *data.pressures, *WRIST_POSE)
    return sha256(b"".join(run.columns[name].tobytes() for name in names)).digest()


def _begins(data: MeasurementSet) -> IntArray:
    """For each sample (samples,) the first one of the same run and output."""
    firsts: dict[tuple[int, int], int] = {}
    found = np.empty(data.table.samples, int)
    for part in data.table.series:
        found[part.samples] = firsts.setdefault((part.run, part.output), part.start)
    return found


def _pose(run: Run) -> Array:
    """Places [m] and orientations of the wrist (samples, 7)."""
    return np.stack([run.columns[name] for name in WRIST_POSE], axis=1)


def _path(run: Run, step: float) -> PressPath:
    pose = _pose(run)
    return press_path(run.columns["time"], pose[:, :3], pose[:, 3:], step)


def _check(data: MeasurementSet, run: Run) -> None:
    """Raise DocumentError for a run that cannot be followed."""
    place = f"{data.folder / DOCUMENT}: runs.{run.name}"
    time = run.columns["time"]
    if len(time) < RULES.motion_samples or np.diff(time).max() > RULES.press_gap:
        raise DocumentError(
            f"{place}: expected at least {RULES.motion_samples} samples, {RULES.press_gap:g} s "
            f"apart at the most, got {len(time)}"
            + (f" up to {np.diff(time).max():.3g} s apart" if len(time) > 1 else "")
        )
    if any(run.wrist_rpy):
        raise DocumentError(
            f"{place}: wrist_rpy: expected either this key or the columns wrist.*, got both"
        )
    pose = _pose(run)
    down = np.moveaxis(matrices(pose[:, 3:].T), -1, 0)[:, 2]
    heights = pose[:, 2] + np.array(_palm(data.hand)).reshape(-1, 3) @ down.T
    lowest = float(heights.min(initial=np.inf)) - _plate_of(data).height
    if lowest < 0.0:
        raise DocumentError(
            f"{place}: expected a palm above the plate, as only fingers and thumb may touch it, "
            f"got a palm that goes {-1e3 * lowest:.3g} mm below it"
        )


def _palm(hand: HandDescription) -> list[Array]:
    """Points (3,) [m] of the palm's plate and sheet, in the wrist frame."""
    points = []
    if hand.plate is not None:
        half = 0.5 * np.array(hand.plate.size)
        signs = np.array(np.meshgrid(*3 * [[-1.0, 1.0]])).reshape(3, -1).T
        points += list(np.array(hand.plate.position) + signs * half)
    if hand.sheet is not None:
        sheet, turn = hand.sheet, from_rpy(hand.sheet.rpy)
        for x, z in sheet.profile(9):
            for side in (-0.5, 0.5):
                own = np.array([x, side * sheet.width, z])
                points.append(np.array(sheet.position) + rotate(turn, own))
    return points


def _taken_off(
    data: MeasurementSet,
    segments: int,
    calibration: Mapping[str, Array] | None = None,
    effects: Sequence[Effect] | None = None,
) -> Array:
    """What finer segments and steps move predictions (samples,) by, of a hand with a calibration
    and effects, or of the hand as it is stated; kept for sets that are driven alike.
    """
    calibration = calibration or {}
    acting = [effect_classes()["gravity"](mass_scale=1.0)] if effects is None else effects
    driven = sha256(b"".join(_driven(data, run) for run in data.runs)).digest()
    about = repr([(name, np.ravel(value).tolist()) for name, value in calibration.items()])
    about += repr([(effect.name, effect.values) for effect in acting])
    plate = replace(_plate_of(data), tared=False)
    key = id(data.hand), segments, plate, driven, about  # the hand stays while it is kept
    if key not in _KEPT:
        if len(_KEPT) >= MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        untared = replace(data, plate=plate)
        coarse = HandPress(untared, segments, PRESS_STEP)
        fine = HandPress(untared, data.hand_segments or FINE_PRESS_SEGMENTS, FINE_PRESS_STEP)
        moved = fine.predict(calibration, acting)[0] - coarse.predict(calibration, acting)[0]
        _KEPT[key] = (data.hand, moved)
    moved = _KEPT[key][1]
    return moved - moved[_begins(data)] if _plate_of(data).tared else moved


def closer_press(
    data: MeasurementSet,
    calibration: Mapping[str, Array],
    effects: Sequence[Effect],
    predicted: Array,
) -> tuple[Array, OwnErrors]:
    """Predictions (samples,) of a fitted model, corrected for the error of few segments and long
    steps, and the errors that remain. `predicted` (samples,) has the correction for the hand as
    stated; effects of the fitted model may change it.
    """
    segments = data.hand_segments or PRESS_SEGMENTS
    moved = _taken_off(data, segments, calibration, effects) - _taken_off(data, segments)
    return predicted + moved, press_errors(data, Model(effects=tuple(effects)), calibration)


def press_errors(
    data: MeasurementSet, model: Model, calibration: Mapping[str, Array] | None = None
) -> OwnErrors:
    """Errors of the wrenches that a model predicts for presses of a hand on a plate. The scatter
    between repeats does not show these errors, as they are the same in each repeat.

    Their causes: wrong inputs of the model (the zero of each channel's pressure sensor, the height
    of the plate), too few segments, and whatever makes two engines differ.
    """
    calibration = calibration or {}
    acting = [effect for effect in model.effects if data.experiment in effect.experiments]
    segments = data.hand_segments or PRESS_SEGMENTS
    plate = _plate_of(data)

    def predicted(data: MeasurementSet) -> Array:
        return np.asarray(HandPress(data, segments, PRESS_STEP).predict(calibration, acting)[0])

    stated = predicted(data)
    zeros = [predicted(shifted(data, channel)) - stated for channel in data.pressures]
    higher = replace(plate, height=plate.height + RULES.plate_height)
    lifted = predicted(replace(data, plate=higher)) - stated
    finer = 0.0 if data.hand_segments else 1.0 / ((FINE_PRESS_SEGMENTS / segments) ** 2 - 1.0)
    coarse = finer * _taken_off(data, segments, calibration, acting)
    whole = np.stack([*zeros, lifted, coarse])
    return OwnErrors(whole, _engine_errors(data, stated))


def _engine_errors(data: MeasurementSet, stated: Array) -> Array:
    """Errors (k, samples) whose squares add up to those of another engine: a share of the size of
    force and torque at each sample, correlated in time; and in the last row, all a little later.
    """
    table = data.table
    found = np.zeros((max(run.samples for run in data.runs) + 1, table.samples))
    number = np.arange(table.samples, dtype=float)
    for index, run in enumerate(data.runs):
        wrench = np.array(table.of_run(stated, index))
        places = np.array(table.of_run(number, index), int)
        time = run.columns["time"]
        apart = np.abs(time[:, None] - time) / RULES.press_engine_time
        root = RULES.press_engine * np.linalg.cholesky(np.exp(-apart))
        found[-1, places] = RULES.press_engine_lead * np.gradient(wrench, time, axis=1)
        for part in (slice(0, 3), slice(3, 6)):
            size = np.linalg.norm(wrench[part], axis=0)
            for output in places[part]:
                found[: run.samples, output] = (size[:, None] * root).T
    return found
