"""All between two steps of PyBullet in one compiled call: air, springs, wrist and bases.

The call takes its groups of arrays as plain tuples (see `plain`) and names them inside: to look at
a named tuple costs the caller of a kernel half a microsecond, ten in all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from pneuflex_sim.dynamics.chain import Links, Placed
from pneuflex_sim.dynamics.joint_springs import Actuation, Before, Joints, Springs, spring_torques
from pneuflex_sim.dynamics.spatial import Array
from pneuflex_sim.hand.air import RestTables, act_on_joints
from pneuflex_sim.hand.driven_bases import Bases, HandWeight, carry_bases
from pneuflex_sim.hand.palm_pad import PadSpring, sink_pad
from pneuflex_sim.hand.wrist import Arm, Drive, WristState
from softhand_model.numerics.compiled import compiled


class HandArrays(NamedTuple):
    """A hand for the kernels: all of its joints, with what acts on them. total_gain (channels,)
    [m3/rad] of the chambers with a bend of all joints alike.
    """

    links: Links
    springs: Springs
    joints: Joints
    total_gain: Array
    tables: RestTables
    actuation: Actuation
    before: Before


class Carrier(NamedTuple):
    """What carries a hand that rides on the wrist."""

    bases: Bases
    weight: HandWeight
    pad: PadSpring
    arm: Arm


def plain(group: Any) -> Any:
    """A group of arguments, and the groups in it, as plain tuples."""
    return tuple(plain(part) for part in group) if isinstance(group, tuple) else group


@compiled
def joint_torques(step, first_step, by_tables, ambient, pressures_abs, volumes, hand):
    """Joint torques of a step [s], into what the hand has `before` the next one, at the absolute
    pressures [Pa] and volumes [m3] of the channels; `hand` is a plain `HandArrays`.

    `by_tables`: the rest shape follows from the tables; else the hand's actuation holds it already.
    """
    links, springs, joints, total_gain, tables, actuation, (v, torque, placed) = hand
    springs, actuation = Springs(*springs), Actuation(*actuation)
    drop = pressures_abs / volumes * total_gain
    pressures = pressures_abs - ambient
    act_on_joints(pressures, drop, by_tables, RestTables(*tables), springs.stiffness, actuation)
    before = Before(v, torque, Placed(*placed))
    spring_torques(step, first_step, Links(*links), springs, Joints(*joints), actuation, before)


@compiled
def drive_hand(step, first_step, by_tables, ambient, pressures_abs, volumes, hand, carrier, wrist):
    """`joint_torques`, and the push on the bases of a hand that rides on the wrist; its palm sheet
    yields to what its base gained on the last push. `pressures_abs` are absolute [Pa], `carrier` is
    a plain `Carrier`, `wrist` a plain `WristState`.
    """
    joint_torques(step, first_step, by_tables, ambient, pressures_abs, volumes, hand)
    bases, weight, pad, (translation, rotation) = carrier
    bases, wrist = Bases(*bases), WristState(*wrist)
    sink_pad(step, PadSpring(*pad), bases, wrist.orientation)
    arm = Arm(Drive(*translation), Drive(*rotation))
    carry_bases(step, bases, HandWeight(*weight), arm, wrist)
