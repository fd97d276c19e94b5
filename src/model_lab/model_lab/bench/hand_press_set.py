"""A planned set of a hand that is pressed on a plate: down, and sideways while it touches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from model_lab.aliases import Array
from model_lab.experiments.hand_press import HandPress
from model_lab.measurements.hands import (
    PRESS,
    WRENCH_COLUMNS,
    WRIST_POSE,
    HandSpecimen,
    Plate,
    pressure_columns,
)
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import Effect, effect_classes
from softhand_model.hand.hand import load_hand

PRESS_RATE, PRESS_DURATION = 20.0, 3.0  # [Hz], [s] of a run
IS_DOWN, SLIDES, IS_ASIDE = 1.2, 1.6, 2.6  # [s] at which the wrist is there, or begins to
MADE_SEGMENTS, PRESSED_STEP = 15, 0.005  # with which a synthesised hand is pressed; [s]
PRESS_FRICTION = 0.3  # of rubber on a smooth plate: on a rough one fingertips catch, and fold


@dataclass(frozen=True)
class Press:
    """One planned press: the wrist goes from height `start` to height `end` [m], then slides.

    pressures: gauge pressures [Pa] of the channels, constant in the run. slide: distances along x
    and y [m]. tilt [rad]: rotation of the wrist about its own z.
    """

    pressures: tuple[float, ...]
    start: float = 0.085
    end: float = 0.048
    slide: tuple[float, float] = (0.03, 0.0)
    tilt: float = 0.0


PRESSES = {
    "all_forward": Press((21e3, 21e3, 21e3, 21e3)),
    "all_back": Press((21e3, 21e3, 21e3, 21e3), slide=(-0.03, 0.0)),
    "fingers_aside": Press((22.5e3, 22.5e3, 4e3, 4e3), slide=(0.0, 0.03)),
    "index_side_forward": Press((19e3, 23e3, 20e3, 10e3), tilt=0.2, slide=(0.02, 0.02)),
    "little_side_back": Press((22.5e3, 19e3, 10e3, 20e3), tilt=-0.2, slide=(-0.02, 0.02)),
    "thumb_aside": Press((8e3, 8e3, 26e3, 30e3), start=0.080, end=0.050, slide=(0.0, -0.03)),
}


def hand_press_set(
    name: str = "rbo_hand_2", presses: Mapping[str, Press] = PRESSES
) -> MeasurementSet:
    """A planned set of presses, without measurements: two repeats of some protocols."""
    hand = load_hand(name)
    time = np.arange(round(PRESS_RATE * PRESS_DURATION) + 1) / PRESS_RATE
    zeros = {column: np.zeros(len(time)) for column in WRENCH_COLUMNS}
    runs = []
    for repeat in "ab":
        for order, (key, press) in enumerate(presses.items()):
            held = dict(zip(pressure_columns(hand), press.pressures, strict=False))
            driven = {column: np.full(len(time), value) for column, value in held.items()}
            wrist = dict(zip(WRIST_POSE, press_course(press, time).T, strict=True))
            columns = {"time": time, **driven, **wrist, **zeros}
            runs.append(Run(f"r{order + 1}{repeat}", "h1", key, 293.15, columns))
    specimens = {"h1": Specimen("h1", batch="A", hand=HandSpecimen(name, hand))}
    title = f"synthesised presses of {name}"
    return MeasurementSet(PRESS, title, specimens, tuple(runs), plate=Plate(PRESS_FRICTION))


def press_course(press: Press, time: Array) -> Array:
    """Places [m] and orientations of the wrist (samples, 7) at times (samples,) [s], palm down."""
    height = press.start + (press.end - press.start) * _eased(time / IS_DOWN)
    aside = _eased((time - SLIDES) / (IS_ASIDE - SLIDES))
    turn = Rotation.from_euler("xyz", (0.0, 0.5 * np.pi, 0.0)) * Rotation.from_euler(
        "z", press.tilt
    )
    place = np.stack([press.slide[0] * aside, press.slide[1] * aside, height], axis=1)
    return np.hstack([place, np.tile(turn.as_quat(), (len(time), 1))])


def _eased(share: Array) -> Array:
    """A way from 0 to 1 that begins and ends slowly."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def pressed_hand(empty: MeasurementSet, scale: float, effects: tuple[Effect, ...]) -> Array:
    """Simulated outputs (samples,) [N] of a planned set, used as its measurements.

    The hand has `scale` [-] times the stated modulus, its weight, and these effects. It is cut into
    other segments than in the lab, and simulated in shorter steps.
    """
    weight = effect_classes()["gravity"](mass_scale=1.0)
    calibration = {f"modulus_scale[{empty.specimens['h1'].batch}]": np.array([scale])}
    model = HandPress(empty, MADE_SEGMENTS, PRESSED_STEP)
    return np.asarray(model.predict(calibration, [*effects, weight])[0])
