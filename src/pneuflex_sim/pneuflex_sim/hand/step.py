"""All computations between two steps of PyBullet in one compiled call: air, springs, wrist and
bases.

The call takes its groups of arrays as plain tuples (see `plain`) and names them inside, because
each named tuple costs the caller of a kernel half a microsecond, ten in all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pneuflex_sim.hand.air import RestTables, act_on_joints
from pneuflex_sim.hand.driven_bases import Bases, HandWeight, carry_bases
from pneuflex_sim.hand.palm_pad import PadSpring, sink_pad
from pneuflex_sim.hand.wrist import Arm, Drive, WristState
from softhand_common.numerics.compiled import compiled
from softhand_model.dynamics.chain import Links, Placed, give_back
from softhand_model.dynamics.joint_springs import Actuation, Before, Joints, Springs, spring_torques
from softhand_model.dynamics.spatial import Array, conjugate, minus, rotate, write


class HandArrays(NamedTuple):
    """A hand for the kernels: its joints and what acts on them. `total_gain` (channels,) [m3/rad]
    of the chambers with an equal bend of all joints.
    """

    links: Links
    springs: Springs
    joints: Joints
    total_gain: Array
    tables: RestTables
    actuation: Actuation
    before: Before


class Carrier(NamedTuple):
    """The parts that carry a hand that is not fixed: its bases on the wrist."""

    bases: Bases
    weight: HandWeight
    pad: PadSpring
    arm: Arm


def plain(group: Any) -> Any:
    """A named tuple, with the named tuples in it, as plain tuples."""
    return tuple(plain(part) for part in group) if isinstance(group, tuple) else group


@compiled
def named(before: tuple[Any, ...]) -> Before:
    """A `Before` from its plain tuple."""
    v, torque, placed, carried, base_rate, reaction = before
    return Before(v, torque, Placed(*placed), carried, base_rate, reaction)


@compiled
def joint_torques(
    step: float,
    first_step: bool,
    by_tables: bool,
    ambient: float,
    pressures_abs: Array,
    volumes: Array,
    hand: tuple[Any, ...],
) -> None:
    """Joint torques of a step [s], stored in the hand's `before`, at the absolute pressures [Pa]
    and volumes [m3] of the channels; `hand` is a plain `HandArrays`.

    With `by_tables` the rest shape follows from the tables; else it is already in the hand's
    actuation.
    """
    links, springs, joints, total_gain, tables, actuation, before = hand
    springs, actuation = Springs(*springs), Actuation(*actuation)
    drop = pressures_abs / volumes * total_gain
    pressures = pressures_abs - ambient
    act_on_joints(pressures, drop, by_tables, RestTables(*tables), springs.stiffness, actuation)
    spring_torques(
        step, first_step, Links(*links), springs, Joints(*joints), actuation, named(before)
    )


@compiled
def drive_hand(
    step: float,
    first_step: bool,
    by_tables: bool,
    ambient: float,
    pressures_abs: Array,
    volumes: Array,
    hand: tuple[Any, ...],
    carrier: tuple[Any, ...],
    wrist: tuple[Any, ...],
) -> None:
    """`joint_torques`, and before them, as links turn with the bases, the push on the bases of a
    hand that the wrist carries; the palm sheet yields to its load.

    `pressures_abs` are absolute [Pa], `carrier` is a plain `Carrier`, `wrist` a plain `WristState`.
    """
    bases, weight, pad, (translation, rotation) = carrier
    bases, wrist = Bases(*bases), WristState(*wrist)
    sink_pad(step, PadSpring(*pad), bases, wrist.orientation)
    arm = Arm(Drive(*translation), Drive(*rotation))
    before = named(hand[6])
    if first_step:
        before.reaction[:] = 0.0
    else:
        _react(step, Links(*hand[0]), hand[2][1], before, bases)
    carry_bases(step, bases, HandWeight(*weight), before.reaction, arm, wrist)
    for b in range(len(before.base_rate)):
        gain = minus(bases.pushed[b, 1], bases.velocity[b, 1])
        own = rotate(conjugate(bases.orientations[b]), gain)
        write((own[0] / step, own[1] / step, own[2] / step), before.base_rate[b])
    joint_torques(step, first_step, by_tables, ambient, pressures_abs, volumes, hand)


@compiled
def _react(step: float, links: Links, v: Array, before: Before, bases: Bases) -> None:
    """Fill the reaction of the given inertia in the step before, in world axes, from the joint
    velocities v (n, 3) [rad/s] at its end.
    """
    rate, unused = (v - before.v) / step, np.zeros(v.shape)
    give_back(rate, before.base_rate, links, before.placed, unused, before.reaction)
    for b in range(len(before.reaction)):
        taken = before.reaction[b]
        write(rotate(bases.orientations[b], (taken[0], taken[1], taken[2])), before.reaction[b])
