"""Motion of a whole hand without contact: pressures that step, and a wrist that moves."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.experiments.hand_pose import HandPose, shifted
from model_lab.experiments.own_errors import OwnErrors
from model_lab.experiments.samples import SampleRows
from model_lab.measurements.hands import WRIST_POSE
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.specimens import DOCUMENT
from model_lab.rules import RULES
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import from_rpy
from softhand_model.chain.free_response import HIGHEST_OVER_LIMIT
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.hand import channel_lags
from softhand_model.effects.whole_runs import lagged_in_runs
from softhand_model.equilibrium.hand_statics import Shape
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from softhand_model.motion.moving_body import MovingBody
from softhand_model.motion.wrist_path import WristPath, held_wrist, moved_wrist

MOTION_SEGMENTS, LONGEST_STEP = 8, 0.005  # of an actuator; [s] at the most, in between samples
SMALLER = (0.4, 0.1)  # steps over LONGEST_STEP: tried where a longer one diverges, as of a whip
FINE_SEGMENTS, FINE_STEP = 16, 0.002  # with which the error of these is taken off
KEPT_MOTIONS = 128  # of bodies in all runs, some 100 kB each
MOST_KEPT = 16  # sets of which that error is kept
_KEPT: dict[Hashable, tuple[HandDescription, Array]] = {}


class HandMotion(HandPose):
    """Positions (lanes, samples) [m] of the markers of a moving hand, in the order of `HandPose`.

    Chains are cut into a few segments and integrated in time (`softhand_model.motion`), under the
    measured pressures, linear between samples, along the path of the wrist. The hand rests at the
    first sample of a run. The error of few segments and long steps is computed once, for the hand
    as stated, and subtracted from all predictions. Pressures that no hand can bear give NaN.

    Args:
        data: the measurement set.
        segments: number of segments of an actuator; None: that of the simulated hand if the set
            states it, else MOTION_SEGMENTS.
        step: time step [s], with which no error is subtracted; None: LONGEST_STEP, with the
            subtraction.

    Raises DocumentError for a missing column, too few samples in time, or a wrist whose pose is
    only partly stated.
    """

    most_kept = KEPT_MOTIONS

    def __init__(
        self, data: MeasurementSet, segments: int | None = None, step: float | None = None
    ) -> None:
        self._step, self._corrected = step or LONGEST_STEP, step is None
        super().__init__(data, segments or data.hand_segments or MOTION_SEGMENTS)

    def _take_rows(self) -> None:
        """All samples of all runs, and the paths of their wrists."""
        data, self._seen = self._data, None
        if data.free_frame:
            raise DocumentError(
                f"{data.folder / DOCUMENT}: specimens: frame: expected wrist for a motion, got free"
            )
        for run in data.runs:
            _check(data, run)
        samples = SampleRows(data)
        self._run, self._runs = (
            samples.run,
            replace(samples.runs, steady=np.ones(len(data.runs), bool)),
        )
        self._pose = np.arange(len(samples.run))
        self._pressures = np.array([_all(data, name) for name in data.pressures])
        self._batch = np.array([data.specimens[run.specimen].batch for run in data.runs])[self._run]
        largest = HIGHEST_OVER_LIMIT * self._hand.max_pressures()
        self._possible = bool((np.abs(self._pressures).max(axis=1) < largest).all())

    def _driven(self) -> Hashable:
        return _driven(self._data), repr([*self._data.markers.items()]), self._step

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Positions (lanes, samples) [m]: calibration (lanes,) by name, effects in lanes."""
        if not self._possible:
            lanes = max((np.size(number) for number in calibration.values()), default=1)
            return np.full((lanes, self._data.table.samples), np.nan)
        found = super().predict(calibration, effects)
        return found + self._taken_off if self._corrected else found

    @property
    def _taken_off(self) -> Array:
        """What finer segments and steps move the predictions (samples,) [m] by."""
        return _taken_off(self._data, self._segments)

    def _felt(self, effects: Sequence[Effect]) -> Array:
        lags = channel_lags(self._hand, effects)
        if not lags.any():
            return self._pressures
        return np.stack(
            [
                lagged_in_runs(course[None, :, None], self._runs, lag)[0, :, 0] if lag else course
                for course, lag in zip(self._pressures, lags, strict=True)
            ]
        )

    def _moved(
        self, body: MovingBody, pressures: Array, gravity: float, scale: float, rows: Indices
    ) -> Shape:
        runs = np.unique(self._run[rows]).tolist()
        parts = self._rolled(body, pressures, gravity, scale, rows, runs, self._step)
        for smaller in SMALLER:
            wild = [run for run in runs if not np.isfinite(parts[run].places).all()]
            if wild:
                step = smaller * self._step
                parts |= self._rolled(body, pressures, gravity, scale, rows, wild, step)
        marked = [self._marked(body, part) for part in parts.values()]
        return Shape(
            np.concatenate([part.places for part in marked]),
            np.concatenate([part.frames for part in marked]),
        )

    def _rolled(
        self,
        body: MovingBody,
        pressures: Array,
        gravity: float,
        scale: float,
        rows: Indices,
        runs: Sequence[int],
        step: float,
    ) -> dict[int, Shape]:
        """The body in each of some runs, in steps [s]."""
        known = [self._data.runs[index] for index in runs]
        shapes = body.roll_runs(
            [self._path(index, step) for index in runs],
            [run.columns["time"] for run in known],
            [pressures[:, self._run[rows] == index] for index in runs],
            scale,
            [run.temperature for run in known],
            gravity,
        )
        return dict(zip(runs, shapes, strict=True))

    def _path(self, index: int, step: float) -> WristPath:
        """The path of the wrist of a run in steps [s]."""
        paths = self._kept.parts
        if (index, step) not in paths:
            paths[index, step] = _path(self._data.runs[index], step)
        found: WristPath = paths[index, step]
        return found


def _all(data: MeasurementSet, name: str) -> Array:
    """A column (rows,) of all runs."""
    return np.concatenate([run.columns[name] for run in data.runs])


def _check(data: MeasurementSet, run: Run) -> None:
    """Raise DocumentError for a run that cannot be followed in time."""
    place = f"{data.folder / DOCUMENT}: runs.{run.name}"
    time = run.columns["time"]
    gaps = np.diff(time)
    if len(time) < RULES.motion_samples or gaps.max() > RULES.motion_gap:
        got = f"{len(time)} samples" + (f" up to {gaps.max():.3g} s apart" if len(gaps) else "")
        raise DocumentError(
            f"{place}: expected at least {RULES.motion_samples} samples at 100 Hz or "
            f"more, got {got}; for a hand that rests or moves slowly use hand_pose"
        )
    known = [name for name in WRIST_POSE if name in run.columns]
    if known and len(known) < len(WRIST_POSE):
        missing = ", ".join(name for name in WRIST_POSE if name not in known)
        raise DocumentError(
            f"{place}: expected all columns {', '.join(WRIST_POSE)} if the wrist moves, or none of "
            f"them if it rests, got some, without {missing}"
        )
    if known and any(run.wrist_rpy):
        raise DocumentError(
            f"{place}: wrist_rpy: expected either this key or the columns wrist.*, got both"
        )


def _path(run: Run, step: float) -> WristPath:
    """The path of a run's wrist, in steps [s]."""
    time = run.columns["time"]
    if WRIST_POSE[0] not in run.columns:
        return held_wrist(time, from_rpy(run.wrist_rpy), step)
    pose = np.stack([run.columns[name] for name in WRIST_POSE], axis=1)
    if not np.ptp(pose, axis=0).any():
        return held_wrist(time, pose[0, 3:], step)
    return moved_wrist(time, pose[:, :3], pose[:, 3:], step)


def _driven(data: MeasurementSet) -> bytes:
    """What drives the runs of a set."""
    names = ("time", *data.pressures, *WRIST_POSE)
    digest = sha256()
    for run in data.runs:
        batch = data.specimens[run.specimen].batch
        digest.update(repr((run.wrist_rpy, run.temperature, batch)).encode())
        for name in names:
            digest.update(run.columns.get(name, np.zeros(0)).tobytes())
    return digest.digest()


def _taken_off(data: MeasurementSet, segments: int) -> Array:
    """What finer segments and steps move predictions (samples,) [m] by, of the hand as it is
    stated; kept for sets that are driven alike.
    """
    markers = repr([*data.markers.items()])
    key = id(data.hand), segments, markers, _driven(data)  # the hand stays while a result is kept
    if key not in _KEPT:
        if len(_KEPT) >= MOST_KEPT:
            del _KEPT[next(iter(_KEPT))]
        weight = [effect_classes()["gravity"](mass_scale=1.0)]
        coarse = HandMotion(data, segments, LONGEST_STEP)
        fine = HandMotion(data, data.hand_segments or FINE_SEGMENTS, FINE_STEP)
        moved = fine.predict({}, weight)[0] - coarse.predict({}, weight)[0]
        _KEPT[key] = (data.hand, moved)
    return _KEPT[key][1]


def own_errors(data: MeasurementSet, model: Model) -> OwnErrors:
    """Errors [m] of the predictions themselves, which repeats do not show, one for each source: the
    zero of the pressure sensor of each channel, different clocks of pressures and markers, and the
    remaining error of few segments, which falls with the square of their number.
    """
    acting = [effect for effect in model.effects if data.experiment in effect.experiments]
    segments = data.hand_segments or MOTION_SEGMENTS

    def predicted(data: MeasurementSet) -> Array:
        return np.asarray(HandMotion(data, segments, LONGEST_STEP).predict({}, acting)[0])

    stated = predicted(data)
    zeros = [predicted(shifted(data, channel)) - stated for channel in data.pressures]
    clocks = RULES.motion_clock * _rates(data, stated)
    finer = 0.0 if data.hand_segments else 1.0 / ((FINE_SEGMENTS / segments) ** 2 - 1.0)
    return OwnErrors(np.stack([*zeros, clocks, finer * _taken_off(data, segments)]))


def _rates(data: MeasurementSet, places: Array) -> Array:
    """Speeds (samples,) [m/s] of the markers."""
    rates = np.empty_like(places)
    for part in data.table.series:
        time = data.runs[part.run].columns["time"]
        row = data.table.row[part.samples]
        first = int(np.sum([run.samples for run in data.runs[: part.run]]))
        rates[part.samples] = np.gradient(places[part.samples], time[row - first])
    return rates
