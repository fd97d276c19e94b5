"""Poses of a whole hand at rest: positions of its markers under pressures and weight, without
contact.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from hashlib import sha256
from typing import Any

import numpy as np

from model_lab.aliases import Array, Indices
from model_lab.experiments.kept_bodies import KeptBodies, ShapesOverScales, kept_bodies
from model_lab.experiments.samples import modulus_scales
from model_lab.measurements.free_frame import FreeFrame
from model_lab.measurements.hand_frame import WristFrame, frame_against_wrist
from model_lab.measurements.hands import MARKER_AXES, Marker
from model_lab.measurements.measurement_set import MeasurementSet, Run, down_of
from model_lab.measurements.specimens import require_columns
from model_lab.rules import RULES
from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.chain.free_response import NoEquilibriumError
from softhand_model.chain.serial import serial_chains
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.hand import (
    altered,
    channel_lags,
    check_places,
    damping_time,
    effects_of_hand,
    modulus_factor,
    palm_factor,
    pressure_offsets,
    pressure_shares,
    rest_bend,
    tip_mass,
)
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.effects.stages import SectionShape
from softhand_model.equilibrium.hand_statics import Shape
from softhand_model.hand.hand import ChainDescription, HandDescription
from softhand_model.model_file import Model
from softhand_model.motion.moving_body import MovingBody

HAND_SEGMENTS = 20  # an actuator: tips of RBO Hand 2 within 0.06 mm rms of the limit up to 35 kPa
KEPT_POSES = 256  # of bodies that are kept, each under other parameters
HAND_WEIGHT = "gravity"  # the effect that every model of a hand has
BESIDE_RUBBER = ("hand", "output", "flow")  # stages that do not act on the rubber


class HandPose:
    """Positions (lanes, samples) [m] of the markers of hands in the frame of the wrist: run after
    run, marker after marker, x, y and z.

    The chains are those of the simulator, cut into more segments, in equilibrium under pressures
    and weight (`equilibrium.hand_statics`). The base model includes the weight; `gravity` only
    scales it. Parameters without an equilibrium give NaN. If the frame of the positions is unknown,
    predictions are moved rigidly to where all markers were seen, also in runs that are held out,
    and the weight turns with them.

    segments: number of segments of an actuator; None: that of the simulated hand if the set states
    it, else HAND_SEGMENTS. strained: sections (1, 1, n) of all actuators, and how they are
    strained.

    Raises DocumentError for a missing column, ValueError for a marker on an arc.
    """

    most_kept = KEPT_POSES

    def __init__(self, data: MeasurementSet, segments: int | None = None) -> None:
        require_columns(data, data.inputs, f"the model of {data.experiment}")
        self._data, self._hand = data, data.hand
        self._segments = segments or data.hand_segments or HAND_SEGMENTS
        self.strained = _sections(self._hand), "pure_shear"
        self._chains = serial_chains(self._hand)
        self._take_rows()
        about = type(self), self._segments, self._driven()
        self._kept: KeptBodies = kept_bodies(self._hand, about, self.most_kept)

    def _take_rows(self) -> None:
        """The poses, each once."""
        data = self._data
        batches = list(dict.fromkeys(data.specimens[run.specimen].batch for run in data.runs))
        poses = np.concatenate([self._poses_of(run, batches) for run in data.runs])
        alike, self._pose = np.unique(poses, axis=0, return_inverse=True)  # as repeats are
        channels = len(data.pressures)
        self._pressures = np.ascontiguousarray(alike[:, :channels].T)
        self._down = np.ascontiguousarray(alike[:, channels:-2])
        self._temperature = np.ascontiguousarray(alike[:, -2])
        self._seen = FreeFrame(data.table) if data.free_frame else None
        turned = turned_frame(data) if data.free_frame else None
        if turned is not None and turned.of_weight:
            self._down = np.ascontiguousarray(self._down @ turned.turn)
        self._batch = np.array(batches)[alike[:, -1].astype(int)]

    def _driven(self) -> Hashable:
        """What drives the hand in the runs: sets in which it is alike share their bodies."""
        rows = (self._pressures, self._down, self._temperature)
        return sha256(b"".join(one.tobytes() for one in rows)).digest(), tuple(self._batch)

    def _poses_of(self, run: Run, batches: list[str]) -> Array:
        """Pressures [Pa], direction down in the frame of the wrist, temperature [K], and batch of
        each sample of a run (samples, channels + 5).
        """
        batch = batches.index(self._data.specimens[run.specimen].batch)
        pressures = np.array([run.columns[name] for name in self._data.pressures]).T
        return np.hstack(
            [pressures, np.tile([*down_of(run), run.temperature, batch], (run.samples, 1))]
        )

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Positions (lanes, samples) [m]: calibration (lanes,) by name, effects in lanes."""
        numbers = [*calibration.values(), *(v for e in effects for v in e.values.values())]
        lanes = max((np.size(number) for number in numbers), default=1)
        return np.stack([self._lane(calibration, effects, lane) for lane in range(lanes)])

    def _lane(
        self, calibration: Mapping[str, Array], effects: Sequence[Effect], lane: int
    ) -> Array:
        acting = [in_lane(effect, lane) for effect in effects]
        places: dict[str, Array] = {}
        for batch in dict.fromkeys(self._batch.tolist()):
            scale = at_lane(calibration.get(f"modulus_scale[{batch}]", 1.0), lane)
            rows = np.flatnonzero(self._batch == batch)
            for name, found in self._places(scale, acting, rows).items():
                places.setdefault(name, np.empty((len(self._batch), 3)))[rows] = found
        frame = _frame_of(acting)
        table = self._data.table
        columns = np.concatenate([(places[name] @ frame).T for name in self._data.markers])
        predicted = np.asarray(columns[table.output, self._pose.ravel()[table.row]])
        return predicted if self._seen is None else self._seen(predicted)

    def _places(self, scale: float, effects: Sequence[Effect], rows: Indices) -> dict[str, Array]:
        """Places (rows, 3) [m] of the markers by name, in the frame of the wrist."""
        hand = altered(self._hand, effects)
        shares = dict(
            zip(hand.actuator_names, pressure_shares(hand, effects).tolist(), strict=True)
        )
        weights = [e.values["mass_scale"] for e in effects if e.name == HAND_WEIGHT]
        weight = float(weights[0]) if weights else 1.0
        damping, channels = damping_time(effects), self._felt(effects)[:, rows]
        lags, offsets = channel_lags(hand, effects), pressure_offsets(hand, effects)
        of_rubber = tuple(
            (type(e), *e.values.values()) for e in effects if e.stage not in BESIDE_RUBBER
        )
        found: dict[str, Array] = {}
        for chains in self._chains:
            parts = [hand.chain(name) for name in chains]
            names = [name for part in parts for name in part.actuators]
            around = self._around(effects)
            body = (*(self._key_of(part, effects) for part in parts), of_rubber, damping, around)
            mounts = tuple(part.mount for part in parts)
            fed = np.array([shares[name] for name in names])
            without = fed @ offsets  # [Pa] that act less
            felt = np.hstack([fed, lags * np.sign(fed), without[:, None]])
            whole = (body, mounts, weight, felt.tobytes(), rows[0])
            one = self._kept.bodies.once(
                (body, mounts),
                partial(self._body_of, hand, parts, effects, of_rubber, damping, around),
            )
            acting = fed @ channels - without[:, None]
            gravity = weight * STANDARD_GRAVITY
            at_scale = partial(self._shaped, one, acting, gravity, rows=rows)
            shape = self._kept.shapes.once(
                (whole, scale), partial(self._scaled, whole, at_scale, scale)
            )
            found.update(self._markers_of(one, shape, effects, len(rows)))
        return found

    def _around(self, effects: Sequence[Effect]) -> Hashable:
        """What else a body's prediction depends on."""
        return ()

    def _body_of(
        self,
        hand: HandDescription,
        parts: Sequence[ChainDescription],
        effects: Sequence[Effect],
        of_rubber: Hashable,
        damping: float,
        around: Hashable,
    ) -> MovingBody:
        models = {part.name: self._model_of(part, effects, of_rubber) for part in parts}
        return self._body(hand, models, damping, around)

    def _body(
        self, hand: HandDescription, models: Mapping[str, ChainModel], damping: float, around: Any
    ) -> MovingBody:
        """A body of chains."""
        return MovingBody(hand, models, damping)

    def _felt(self, effects: Sequence[Effect]) -> Array:
        """Pressures (channels, samples) [Pa] of the channels as their actuators feel them."""
        return self._pressures

    def _scaled(self, whole: Hashable, at_scale: Callable[[float], Any], scale: float) -> Any:
        """The shape of a body at a scale of the modulus, of which `at_scale` gives that at any;
        whole: all else that it depends on.
        """
        return self._kept.over_scales.once(whole, ShapesOverScales).at(at_scale, scale)

    def _shaped(
        self, body: MovingBody, pressures: Array, gravity: float, scale: float, rows: Indices
    ) -> Shape | None:
        """The markers of the body in its poses; None without an equilibrium."""
        try:
            return self._moved(body, pressures, gravity, scale, rows)
        except NoEquilibriumError:
            return None

    def _moved(
        self, body: MovingBody, pressures: Array, gravity: float, scale: float, rows: Indices
    ) -> Shape:
        """The markers of the body at rest."""
        pull = gravity * self._down[rows]
        return self._marked(body, body.settle(pressures, pull, scale, self._temperature[rows]))

    def _key_of(self, chain: ChainDescription, effects: Sequence[Effect]) -> Hashable:
        """What distinguishes the model of a chain under effects of a hand; not its mount."""
        moduli = (modulus_factor(name, effects) for name in chain.actuators)
        bends = (rest_bend(name, effects) for name in chain.actuators)
        palm = palm_factor(effects) if chain.turn else 1.0
        return (chain.name, chain.strut, palm, tip_mass(chain.name, effects), *moduli, *bends)

    def _model_of(
        self, chain: ChainDescription, effects: Sequence[Effect], of_rubber: Hashable
    ) -> ChainModel:
        """The model of a chain, which does not depend on its mount."""

        key = self._key_of(chain, effects)

        def plain() -> ChainModel:
            beside = (e for e in effects if e.stage in BESIDE_RUBBER and e.name != HAND_WEIGHT)
            return discretise(chain, self._segments, Model(effects=tuple(beside)))

        def make() -> ChainModel:
            acting = [effect for effect in effects if effect.stage not in BESIDE_RUBBER]
            cut = self._kept.models.once((key, ()), plain)
            return cut.of_rubber([effect for effect in acting if effect.name != HAND_WEIGHT])

        return self._kept.models.once((key, of_rubber), make if of_rubber else plain)

    def _markers_on(self, body: MovingBody) -> list[tuple[str, Marker]]:
        """Names and markers of a body, in the order of the set."""
        markers = self._data.markers.items()
        return [(name, marker) for name, marker in markers if marker.actuator in body.actuators]

    def _marked(self, body: MovingBody, shape: Shape) -> Shape:
        """The centre line (rows, markers) at the markers of a body."""
        chain_of = {name: chain.name for chain in self._hand.chains for name in chain.actuators}
        placed = [
            body.placed(shape, chain_of[marker.actuator], marker.at)
            for _, marker in self._markers_on(body)
        ]
        rows = len(shape.places)
        places = np.empty((rows, len(placed), 3))
        frames = np.empty((rows, len(placed), 3, 3))
        for index, (place, frame) in enumerate(placed):
            places[:, index], frames[:, index] = place, frame
        return Shape(places, frames)

    def _markers_of(
        self, body: MovingBody, marked: Shape | None, effects: Sequence[Effect], rows: int
    ) -> dict[str, Array]:
        """Places (rows, 3) [m] of the markers on a body; NaN without an equilibrium."""
        moved = effects_of_hand(effects)
        found = {}
        for index, (name, marker) in enumerate(self._markers_on(body)):
            offset = np.array(marker.offset) + sum(e.marker_offset_of(name) for e in moved)
            found[name] = (
                np.full((rows, 3), np.nan)
                if marked is None
                else marked.places[:, index] + marked.frames[:, index] @ offset
            )
        return found


def turned_frame(data: MeasurementSet) -> WristFrame | None:
    """The frame in which the positions of a set were measured; None if it is about that of the
    wrist, or if the shape of the hand does not tell.
    """
    pressures = [[run.columns[name] for name in data.pressures] for run in data.runs]
    places = {
        name: np.concatenate(
            [
                np.stack([run.columns[f"{name}.{axis}"] for axis in MARKER_AXES], 1)
                for run in data.runs
            ]
        )
        for name in data.markers
    }
    known = np.isfinite(np.stack([*places.values()], axis=1)).all(axis=(1, 2))
    down = np.concatenate([np.tile(down_of(run), (run.samples, 1)) for run in data.runs])
    blown = np.concatenate(pressures, axis=1)
    seen = {name: place[known] for name, place in places.items()}
    return frame_against_wrist(data.hand, data.markers, blown[:, known], down[known], seen)


def own_error(data: MeasurementSet, model: Model) -> float:
    """Root mean square error [m] of the predictions of a hand; 0 for other sets. Repeats do not
    show this error.

    It has two sources: the zeros of the pressure sensors, and the finite number of segments. The
    error of the segments falls with the square of their number, so it is 4/3 of the change with
    twice as many segments. It is 0 for a simulated hand with the same number of segments.
    """
    if not data.of_hand:
        return 0.0
    acting = [effect for effect in model.effects if data.experiment in effect.experiments]

    def predicted(data: MeasurementSet, segments: int | None = None) -> Array:
        return np.asarray(HandPose(data, segments).predict({}, acting)[0])

    stated = predicted(data)
    shifts = [predicted(shifted(data, channel)) - stated for channel in data.pressures]
    if not data.hand_segments:
        shifts.append(4.0 / 3.0 * (predicted(data, 2 * HAND_SEGMENTS) - stated))
    return float(np.sqrt(sum(np.nanmean(shift**2) for shift in shifts)))


def shifted(data: MeasurementSet, channel: str) -> MeasurementSet:
    """The set in which the pressures of a channel have the error of a sensor's zero,
    `Rules.pressure_zero`.
    """
    runs = tuple(
        replace(run, columns={**run.columns, channel: run.columns[channel] + RULES.pressure_zero})
        for run in data.runs
    )
    return replace(data, runs=runs)


def with_weight(data: MeasurementSet, model: Model) -> Model:
    """The model for a set. For a hand, the effect `gravity` is added if the model does not have it.

    Raises ValueError for a hand if the model has another base than `pneuflex`, or effects that the
    statics of hands do not have.
    """
    if not data.of_hand:
        return model
    if model.base != "pneuflex":
        raise ValueError(f"model: base: expected pneuflex for a hand, got {model.base}")
    check_places(data.hand, model.effects, data.markers)
    for effect in model.effects:
        if data.experiment not in effect.experiments and effect.stage not in BESIDE_RUBBER:
            raise ValueError(
                f"model: effects: expected effects that act in {data.experiment}, got {effect.name}"
            )
    if any(effect.name == HAND_WEIGHT for effect in model.effects):
        return model
    weight = effect_classes()[HAND_WEIGHT](mass_scale=1.0)
    return replace(model, effects=(*model.effects, weight))


def _sections(hand: HandDescription) -> SectionShape:
    """Sections (1, 1, n) of all actuators of a hand."""
    columns = []
    for chain in hand.chains:
        for part in chain.actuators.values():
            x = part.segment_quadrature(1)[0].ravel()
            shape = (*part.sides(x), part.side_wall_ratio(x), part.shear_modulus)
            columns.append([np.broadcast_to(size, x.shape) for size in shape])
    return SectionShape(
        *(np.concatenate(sizes)[None, None] for sizes in zip(*columns, strict=True))
    )


def _frame_of(effects: Sequence[Effect]) -> Array:
    """The frame (3, 3) in which markers are measured, its axes as columns in that of the wrist."""
    frame = np.eye(3)
    for effect in effects_of_hand(effects):
        frame = frame @ rotate(from_rpy(effect.frame_turn()), np.eye(3)).T
    return frame


def at_lane(number: float | Array, lane: int) -> float:
    """The value of a number in one lane; a number without lanes is the same in all."""
    values = np.ravel(number)
    return float(values[lane if values.size > 1 else 0])


def in_lane(effect: Effect, lane: int) -> Effect:
    """The effect with its values in one lane, as plain numbers."""
    one = type(effect).__new__(type(effect))
    one.values = {name: at_lane(value, lane) for name, value in effect.values.items()}
    return one
