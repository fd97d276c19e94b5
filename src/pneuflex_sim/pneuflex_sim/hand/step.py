"""Everything between two steps of PyBullet in one compiled call: air, springs, wrist and bases.

Arguments come in tuples of arrays, which the classes that own them put together once:

air      volumes, total_gain, channel, step, cubic, start, width (see `air_coupling`)
actuated bend, gas
joints   start, q, v, rest, stiffness, stretching, damping, offset, com, inertia, mass (see
         `spring_kernel`)
carried  v_before, frame, arm, center, world_inertia, torque
pad      stiffness, axis, place, state (see `palm_pad`); stiffness 0 where there is none
bases    mount_places, mount_turns, places, turns, velocity, pushed, center, push (`base_kernel`)
wrist    target_position, target_orientation, force, torque, position, orientation, velocity, spin
"""

from __future__ import annotations

from pneuflex_sim.dynamics.joint_springs import spring_torques
from pneuflex_sim.hand.air import act_on_joints
from pneuflex_sim.hand.palm_pad import sink_pad
from pneuflex_sim.hand.wrist_drive import carry_bases
from softhand_model.numerics.compiled import compiled


@compiled
def joint_torques(
    dt, first_step, ambient, pressures_abs, by_tables, air, actuated, joints, carried
):
    """Joint torques of a step [s] under the absolute pressures [Pa] of the channels.

    `by_tables`: the rest shape follows from the tables; else `bend` holds it already.
    """
    volumes, total_gain, channel, width_of_step, cubic, start, width = air
    bend, gas = actuated
    q, v, rest, stiffness, stretching, damping, offset, com, inertia, mass = joints[1:]
    gas[:] = 0.0
    pressures, drop = pressures_abs - ambient, pressures_abs / volumes * total_gain
    act_on_joints(
        pressures,
        drop,
        by_tables,
        channel,
        width_of_step,
        cubic,
        start,
        width,
        stiffness,
        bend,
        gas,
    )
    v_before, frame, arm, center, world_inertia, torque = carried
    spring_torques(
        dt,
        first_step,
        joints[0],
        q,
        v,
        rest,
        bend,
        stiffness,
        stretching,
        gas,
        damping,
        offset,
        com,
        inertia,
        mass,
        v_before,
        frame,
        arm,
        center,
        world_inertia,
        torque,
    )


@compiled
def drive_hand(
    dt,
    first_step,
    ambient,
    pressures_abs,
    by_tables,
    air,
    actuated,
    joints,
    carried,
    constants,
    pad,
    bases,
    arm,
    wrist,
):
    """`joint_torques`, and the push on the bases of a hand that rides on the wrist; its palm sheet
    yields to what its base gained on the last push.

    constants: (mass, inertia) of a base, gravity [m/s2], weight of the hand [N]; arm: springs of
    the wrist's translation and rotation.
    """
    joint_torques(dt, first_step, ambient, pressures_abs, by_tables, air, actuated, joints, carried)
    resistance, gravity, weight = constants
    mount_places, mount_turns, places, turns, velocity, pushed, center, push = bases
    target_position, target_orientation, force, torque, position, orientation, speed, spin = wrist
    sink_pad(dt, resistance[0], *pad, velocity, pushed, orientation, mount_places)
    carry_bases(
        dt,
        resistance,
        gravity,
        mount_places,
        mount_turns,
        places,
        turns,
        velocity,
        pushed,
        weight,
        center,
        arm[0],
        arm[1],
        target_position,
        target_orientation,
        force,
        torque,
        position,
        orientation,
        speed,
        spin,
        push,
    )
