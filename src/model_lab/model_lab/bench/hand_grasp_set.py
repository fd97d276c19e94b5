"""A planned set of grasps: the wrist moves down to an object, air closes the hand, and the wrist
moves up and holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from model_lab.aliases import Array
from model_lab.experiments.grasp_rollouts import Engine
from model_lab.experiments.hand_grasp import simulated
from model_lab.measurements.hands import (
    GRASP,
    OBJECT_POSE,
    WRENCH_COLUMNS,
    WRIST_POSE,
    Grasped,
    HandSpecimen,
    mass_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import Effect, effect_classes
from softhand_model.hand.hand import load_hand

GRASP_RATE, GRASP_DURATION = 10.0, 3.4  # [Hz], [s] of a run
BESIDE_OBJECT, THUMB_OPPOSED, HAND_CLOSED = 0.5, 0.9, 1.9  # [s] at which a phase ends
WRIST_LIFTS, WRIST_LIFTED = 2.0, 2.7  # [s] from, until
GRASP_START, GRASP_LIFT = 0.06, 0.1  # [m] above where it grasps
OPPOSING_AIR = 3e-5  # [kg] of air in thumb and palm before the fingers close
GRASP_AIR = (7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5)  # [kg] in the closed hand
GRASP_PITCH, GRASP_TURN = 2.356194490192345, 0.6  # [rad] of the wrist: palm down
GRASP_BESIDE = (-0.026, -0.049, 0.150)  # [m] from the object's place to the wrist that grasps it
START_SCATTER = 0.004  # [m] by which an object starts elsewhere, one sigma along x and y
MADE_WITH = Engine(segments=7, step=0.001)  # a synthesised hand


@dataclass(frozen=True)
class Grasp:
    """One planned grasp, stated by its differences from the usual one.

    turn [rad]: additional rotation of the wrist about the vertical. beside (3,) [m]: displacement
    of the wrist. air [-]: factor on the usual air masses. slide [m]: distance along the table
    before the hand closes. shake [m]: how far the wrist moves to and fro while the hand holds.
    """

    turn: float = 0.0
    beside: tuple[float, float, float] = (0.0, 0.0, 0.0)
    air: float = 1.0
    slide: float = 0.0
    shake: float = 0.0


GRASPS = {
    "usual": Grasp(),
    "little_air": Grasp(air=0.75),
    "turned": Grasp(turn=-0.25),
    "near": Grasp(beside=(0.012, 0.0, 0.0)),
    "sliding": Grasp(beside=(-0.01, 0.0, -0.006), slide=0.015),
    "shaken": Grasp(air=0.9, shake=0.03),
}


def hand_grasp_set(
    random: np.random.Generator, thing: str = "cylinder", repeats: str = "ab"
) -> MeasurementSet:
    """A planned set, without measurements: RBO Hand 2 grasps a lying object in six ways.

    random: draws where the object starts in each run. thing: object, by name or file. repeats: a
    letter for each repeat.
    """
    hand = load_hand("rbo_hand_2")
    time = np.arange(round(GRASP_RATE * GRASP_DURATION) + 1) / GRASP_RATE
    measured = (*WRENCH_COLUMNS, *pressure_columns(hand), *OBJECT_POSE)
    lying = Rotation.from_euler("x", 0.5 * np.pi).as_quat()
    runs = []
    for repeat in repeats:
        for order, (key, grasp) in enumerate(GRASPS.items()):
            start = np.array([*(START_SCATTER * random.standard_normal(2)), 0.0, *lying])
            columns = {"time": time}
            columns |= dict(zip(WRIST_POSE, grasp_course(grasp, time).T, strict=True))
            columns |= dict(zip(mass_columns(hand), air_course(grasp, time).T, strict=True))
            columns |= {name: np.zeros(len(time)) for name in measured}
            columns |= {
                name: np.full(len(time), value)
                for name, value in zip(OBJECT_POSE, start, strict=True)
            }
            runs.append(Run(f"r{order + 1}{repeat}", "h1", key, 293.15, columns))
    specimens = {"h1": Specimen("h1", batch="A", hand=HandSpecimen("rbo_hand_2", hand))}
    title = f"synthesised grasps of {hand.name}"
    return MeasurementSet(GRASP, title, specimens, tuple(runs), grasped=Grasped(thing))


def grasp_course(grasp: Grasp, time: Array) -> Array:
    """Poses of the wrist (samples, 7) at times (samples,) [s]."""
    place = np.tile(np.add(GRASP_BESIDE, grasp.beside), (len(time), 1))
    place[:, 2] += GRASP_START * (1.0 - _eased(time / BESIDE_OBJECT))
    place[:, 2] += GRASP_LIFT * _eased((time - WRIST_LIFTS) / (WRIST_LIFTED - WRIST_LIFTS))
    place[:, 0] += grasp.slide * (_eased((time - BESIDE_OBJECT) / (THUMB_OPPOSED - BESIDE_OBJECT)))
    held = np.clip((time - WRIST_LIFTED) / (time[-1] - WRIST_LIFTED), 0.0, 1.0)
    place[:, 1] += grasp.shake * np.sin(2.0 * np.pi * held) * np.sin(np.pi * held)
    turn = Rotation.from_euler("xyz", (0.0, GRASP_PITCH, GRASP_TURN + grasp.turn)).as_quat()
    return np.hstack([place, np.tile(turn, (len(time), 1))])


def air_course(grasp: Grasp, time: Array) -> Array:
    """Air above the fill at rest (samples, 4) [kg] at times (samples,) [s]."""
    opposing = np.clip((time - BESIDE_OBJECT) / (THUMB_OPPOSED - BESIDE_OBJECT), 0.0, 1.0)[:, None]
    closing = np.clip((time - THUMB_OPPOSED) / (HAND_CLOSED - THUMB_OPPOSED), 0.0, 1.0)[:, None]
    first = np.array([0.0, 0.0, OPPOSING_AIR, OPPOSING_AIR])
    return np.asarray(grasp.air * (opposing * first + closing * (np.array(GRASP_AIR) - first)))


def _eased(share: Array) -> Array:
    """A way from 0 to 1 that begins and ends slowly."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def grasped(
    empty: MeasurementSet,
    scale: float,
    effects: tuple[Effect, ...],
    engine: Engine = MADE_WITH,
) -> Array:
    """Simulated outputs (samples,) [N] of a planned set, used as its measurements.

    The hand has `scale` [-] times the stated modulus, its weight, and these effects. It is cut into
    other segments than in the lab, and simulated in shorter steps or by another `engine`.
    """
    weight = effect_classes()["gravity"](mass_scale=1.0)
    return simulated(empty, [*effects, weight], scale, engine)
