"""All between two steps of PyBullet in one compiled call: air, springs, wrist and bases."""

from __future__ import annotations

from typing import NamedTuple

from pneuflex_sim.dynamics.chain import Links
from pneuflex_sim.dynamics.joint_springs import (
    Actuation,
    Before,
    Joints,
    Springs,
    spring_torques,
)
from pneuflex_sim.hand.air import Chambers, RestTables, act_on_joints
from pneuflex_sim.hand.driven_bases import BASE_MASS, carry_bases
from pneuflex_sim.hand.palm_pad import sink_pad
from softhand_model.numerics.compiled import compiled


class HandArrays(NamedTuple):
    """A hand for `joint_torques`: all of its joints, with what acts on them."""

    links: Links
    springs: Springs
    joints: Joints
    chambers: Chambers
    tables: RestTables
    actuation: Actuation
    before: Before


@compiled
def joint_torques(step, first_step, by_tables, ambient, pressures_abs, volumes, hand):
    """Joint torques of a step [s], into `hand.before`, at the absolute pressures [Pa] and volumes
    [m3] of the channels.

    `by_tables`: the rest shape follows from the tables; else `hand.actuation` holds it already.
    """
    drop = pressures_abs / volumes * hand.chambers.total
    act_on_joints(
        pressures_abs - ambient,
        drop,
        by_tables,
        hand.tables,
        hand.springs.stiffness,
        hand.actuation,
    )
    spring_torques(
        step, first_step, hand.links, hand.springs, hand.joints, hand.actuation, hand.before
    )


@compiled
def drive_hand(
    step,
    first_step,
    by_tables,
    ambient,
    pressures_abs,
    volumes,
    hand,
    bases,
    weight,
    pad,
    arm,
    wrist,
):
    """`joint_torques`, and the push on the bases of a hand that rides on the wrist; its palm sheet
    yields to what its base gained on the last push.
    """
    joint_torques(step, first_step, by_tables, ambient, pressures_abs, volumes, hand)
    sink_pad(step, BASE_MASS, pad, bases, wrist.orientation)
    carry_bases(step, bases, weight, arm, wrist)
