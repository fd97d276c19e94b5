"""A planned set of a hand in motion: pressures step, the wrist is held, turned or shaken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from model_lab.aliases import Array
from model_lab.bench.layouts import HAND_PEAK
from model_lab.experiments.hand_motion import HandMotion
from model_lab.measurements.hands import (
    HAND_MOTION,
    WRIST_POSE,
    HandSpecimen,
    default_markers,
    marker_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import Effect, effect_classes
from softhand_model.hand.hand import load_hand

MOTION_RATE, MOTION_DURATION = 100.0, 1.2  # [Hz], [s] of a run
MOTION_RISE = 0.04  # [s] of a step of the pressure
MADE_SEGMENTS, MADE_STEP = 15, 5e-4  # with which a synthesised hand moves; [s]
ALL_STEP = ((0.0, 0.0), (0.15, 1.0), (0.7, 0.35))  # from [s] on, this share of the peak
UP_AND_DOWN = ((0.0, 0.5), (0.25, 1.0), (0.5, 0.2), (0.8, 0.8))


@dataclass(frozen=True)
class Protocol:
    """Motion of the wrist, and course of the pressures.

    rpy [rad]: orientation of the wrist at the start. turn [rad]: angles by which it turns. way [m]:
    by which it moves to and fro, at `rate` [Hz]. course: corners of the pressure over time. apart
    [s]: delay of each channel after the one before it; if negative, after the next one.
    """

    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    way: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rate: float = 2.0
    course: tuple[tuple[float, float], ...] = ALL_STEP
    apart: float = 0.0


QUARTER = float(0.5 * np.pi)
HAND_MOTIONS = {
    "step_fingers_up": Protocol(),
    "step_palm_down": Protocol(rpy=(0.0, QUARTER, 0.0), course=UP_AND_DOWN),
    "in_turn_fingers_up": Protocol(apart=0.12),
    "backwards_thumb_up": Protocol(rpy=(-QUARTER, 0.0, 0.0), course=UP_AND_DOWN, apart=-0.08),
    "turned_palm_up": Protocol(rpy=(0.0, -QUARTER, 0.0), turn=(0.3, 0.5, 0.2), apart=0.1),
    "shaken_fingers_up": Protocol(way=(0.03, 0.02, 0.01), rate=3.0, course=UP_AND_DOWN),
}


def hand_motion_set(
    name: str = "rbo_hand_2", motions: Mapping[str, Protocol] = HAND_MOTIONS
) -> MeasurementSet:
    """A planned set of a hand in motion, without measurements: two repeats of some protocols."""
    hand = load_hand(name)
    markers, limits = default_markers(hand), HAND_PEAK * hand.max_pressures()
    time = np.arange(round(MOTION_RATE * MOTION_DURATION) + 1) / MOTION_RATE
    zeros = {column: np.zeros(len(time)) for column in marker_columns(markers)}
    runs = []
    for repeat in "ab":
        for order, (key, protocol) in enumerate(motions.items()):
            shares = pressure_course(protocol, time, len(hand.channels))
            driven = dict(zip(pressure_columns(hand), (shares * limits).T, strict=True))
            wrist = dict(zip(WRIST_POSE, wrist_course(protocol, time).T, strict=True))
            columns = {"time": time, **driven, **wrist, **zeros}
            runs.append(Run(f"r{order + 1}{repeat}", "h1", key, 293.15, columns))
    specimens = {"h1": Specimen("h1", batch="A", hand=HandSpecimen(name, hand))}
    title = f"synthesised motion of {name}"
    return MeasurementSet(HAND_MOTION, title, specimens, tuple(runs), markers=markers)


def pressure_course(protocol: Protocol, time: Array, channels: int) -> Array:
    """Pressures (samples, channels) over their peaks at times (samples,) [s]."""
    order = np.arange(channels)
    begun = abs(protocol.apart) * (order if protocol.apart >= 0.0 else order[::-1])
    at, share = np.array(protocol.course).T
    corners = np.stack([at[1:], at[1:] + MOTION_RISE], axis=1).ravel()
    held = np.repeat(share, 2)[:-1]
    knots, values = np.append(0.0, corners), held
    return np.stack([np.interp(time - later, knots, values) for later in begun], axis=1)


def wrist_course(protocol: Protocol, time: Array) -> Array:
    """Positions [m] and orientations (quaternions) of the wrist, (samples, 7), at times (samples,)
    [s]. The wrist starts and ends at rest.
    """
    since = np.clip(np.minimum(time, time[-1] - time) / 0.2, 0.0, 1.0)
    swing = since**3 * (10.0 - 15.0 * since + 6.0 * since**2)
    swing = swing * np.sin(2.0 * np.pi * protocol.rate * time)
    start = Rotation.from_euler("xyz", protocol.rpy)
    turned = Rotation.from_rotvec(np.outer(swing, protocol.turn)) * start
    return np.hstack([np.outer(swing, protocol.way), turned.as_quat()])


def moved_hand(empty: MeasurementSet, scale: float, effects: tuple[Effect, ...]) -> Array:
    """True positions (samples,) [m] of the markers of a hand with `scale` [-] times the stated
    modulus, with weight and effects. The chains are cut into other segments than in the lab, and
    time steps are ten times shorter.
    """
    data = replace(empty, runs=empty.runs[: len(HAND_MOTIONS)])
    model = HandMotion(data, MADE_SEGMENTS, MADE_STEP)
    batch = np.array([scale])
    weight = effect_classes()["gravity"](mass_scale=1.0)
    calibration = {f"modulus_scale[{empty.specimens['h1'].batch}]": batch}
    found = model.predict(calibration, [*effects, weight])[0]
    return np.tile(found, len(empty.runs) // len(data.runs))
