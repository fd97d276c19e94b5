"""A designed finger in the simulator, held against the requirements alone, and measured.

The actuator is read from the file that `hand design` writes. A segment's curvature over pressure is
measured at the pressure at which the top has to be stretched to 1.839, where the actuation ratio
is the exact secant; the force of the tip, blocked by a block some way off, is that of a chain whose
free curvatures and springs are those required.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_design.hand_file import finger_text
from softhand_design.sizing import Design
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import load_hand
from thesis.chapter_3_and_5.planar import Stop, equilibrium, linear_springs, planar_finger
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import chain_of

SEGMENTS = 20
PLACES = (0, 9, 19)  # segments whose curvature is measured
RULE_STRETCH = 1.839286755  # lambda + lambda**-3 = 2: the secant is that of the rule
GAP, BOTTOM = 1.0 / 6.0, 0.78  # of the length: the block's distance, and where it begins
BLOCKED = 0.6  # of the pressure at which the base is measured


@dataclass(frozen=True)
class Held:
    """How far off the requirements [-] the simulated finger is: its curvatures and its force."""

    bend: float
    force: float


def from_file(design: Design) -> Actuator:
    """The actuator as a simulation reads it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "finger.yaml"
        path.write_text(finger_text(design.actuator), encoding="utf-8")
        return load_hand(path).chain("finger").actuators["finger"]


def rule_pressures(design: Design, x: Array) -> Array:
    """Pressures [Pa] at which the top at x [m] has to be stretched to `RULE_STRETCH`."""
    return (RULE_STRETCH - 1.0) / design.actuator.height(x) / design.requirements.ratio(x)


def middles(length: float) -> Array:
    """Middles [m] of the segments."""
    return np.asarray((np.arange(SEGMENTS) + 0.5) * length / SEGMENTS)


def held_against(design: Design, actuator: Actuator) -> Held:
    """A simulated actuator against the requirements of a design."""
    return Held(_bend_off(design, actuator), _force_off(design, actuator))


def _bend_off(design: Design, actuator: Actuator) -> float:
    length = design.requirements.length
    x = middles(length)[list(PLACES)]
    off = []
    with FingerStand(actuator, SEGMENTS) as stand:
        for pressure, place, at in sorted(zip(rule_pressures(design, x), PLACES, x, strict=True)):
            stand.settle(pressure)
            ratio = stand.bends()[place] * SEGMENTS / length / pressure
            off.append(abs(ratio / float(design.requirements.ratio(at)) - 1.0))
    return float(max(off))


def _force_off(design: Design, actuator: Actuator) -> float:
    wanted, edge = design.requirements, design.requirements.length / SEGMENTS
    x = middles(wanted.length)
    pressure = BLOCKED * float(rule_pressures(design, x[:1])[0])
    with FingerStand(actuator, SEGMENTS) as stand:
        block = stand.block(GAP * wanted.length, BOTTOM * wanted.length)
        stand.settle(pressure)
        touch = stand.touch(block)
    height = design.actuator.height(x)
    rest = edge * (section.free_stretch(2.0 * pressure * height * wanted.ratio(x)) - 1.0) / height
    springs = linear_springs(wanted.stiffness(x) / edge, rest)
    finger = planar_finger(chain_of(actuator, SEGMENTS).segments)
    wanted = equilibrium(finger, springs, stop=Stop((-1.0, 0.0), -float(touch.place[0])))
    return abs(touch.force / wanted.tip_force - 1.0)
