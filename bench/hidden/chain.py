"""A chain of rigid segments with springs, marched from its base under a known load.

All that lies beyond a joint is carried by it: with the force and torque that the chain exerts on
its base given, the moment at each joint follows from its place, and so the joint's rotation, one
joint after the other. No equilibrium has to be searched for. Frames: z along the chain, y the
bending axis, x towards the bending side. Arrays have their samples first: vectors (n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

Array = np.ndarray
SEGMENTS = 10


@dataclass(frozen=True)
class Springs:
    """Joint springs of n samples: stiffness (n,) [N m/rad] about all axes, rest angle (n,) about y.

    coupling: of lateral bending and twist over the stiffness. slack: factor on the stiffness about
    y where the joint is straighter than at rest.
    """

    stiffness: Array
    rest: Array
    edge: float
    coupling: float = 0.0
    slack: float = 1.0


def march(springs: Springs, force: Array, torque: Array) -> tuple[Array, Rotation]:
    """Tip place (n, 3) [m] and orientation under force and torque (n, 3) on the base."""
    place = np.zeros_like(force)
    turn = Rotation.identity(len(force))
    bend = Rotation.from_rotvec(springs.rest[:, None] * np.array([0.0, 1.0, 0.0]))
    place = place + springs.edge / 2 * turn.apply([0.0, 0.0, 1.0])
    for joint in range(SEGMENTS):
        moment = torque - np.cross(place, force)
        rest = _product(turn, bend)
        turn = Rotation.from_rotvec(_rotated(springs, rest.inv().apply(moment)))
        turn = _product(rest, turn)
        length = springs.edge / 2 if joint == SEGMENTS - 1 else springs.edge
        place = place + length * turn.apply([0.0, 0.0, 1.0])
    return place, turn


def _product(one: Rotation, other: Rotation) -> Rotation:
    """one * other; a loop over samples in scipy, which is most of the time of a set."""
    p, q = one.as_quat(), other.as_quat()
    vector = p[:, 3:] * q[:, :3] + q[:, 3:] * p[:, :3] + np.cross(p[:, :3], q[:, :3])
    scalar = p[:, 3:] * q[:, 3:] - (p[:, :3] * q[:, :3]).sum(axis=1, keepdims=True)
    return Rotation.from_quat(np.hstack([vector, scalar]))


def _rotated(springs: Springs, moment: Array) -> Array:
    """Rotation vectors (n, 3) of one joint under moments (n, 3), in the frame at rest.

    The work of the moment on a small further turn is that on the energy e*K*e/2: K*e = J(e)^T m.
    """
    k = springs.stiffness
    rotation = moment / k[:, None]
    if springs.coupling == 0.0 and springs.slack == 1.0:
        return rotation
    for _ in range(60):
        pulled = _left_jacobian_transposed(rotation, moment)
        fresh = _softened(springs, pulled)
        change = np.max(np.abs(fresh - rotation))
        rotation = 0.5 * rotation + 0.5 * fresh
        if change < 1e-12:
            break
    return rotation


def _softened(springs: Springs, moment: Array) -> Array:
    """Solution e of K*e = moment."""
    k, c = springs.stiffness, springs.coupling
    about_x = (moment[:, 0] - c * moment[:, 2]) / (1 - c**2) / k
    about_z = (moment[:, 2] - c * moment[:, 0]) / (1 - c**2) / k
    about_y = moment[:, 1] / k / np.where(moment[:, 1] < 0, springs.slack, 1.0)
    return np.stack([about_x, about_y, about_z], axis=1)


def _left_jacobian_transposed(e: Array, m: Array) -> Array:
    """J(e)^T m = sin(a)/a m + (1 - sin(a)/a) (u.m) u - (1 - cos(a))/a u x m, e = a*u."""
    angle = np.linalg.norm(e, axis=1, keepdims=True)
    safe = np.maximum(angle, 1e-9)
    u = e / safe
    sine = np.sinc(angle / np.pi)
    along = (u * m).sum(axis=1, keepdims=True)
    return sine * m + (1 - sine) * along * u - (1 - np.cos(angle)) / safe * np.cross(u, m)


def held(springs: Springs, place: Array, turn: Rotation, start: Array) -> Array:
    """Force and torque (n, 6) on the base of a chain whose tip is held, from a first guess.

    Newton with numerical slopes. What has not converged is returned as far as it came.
    """
    wrench = start.copy()
    length = springs.edge * SEGMENTS
    unit = np.repeat([springs.stiffness.mean() / length / SEGMENTS, springs.stiffness.mean()], 3)
    unit = unit / np.repeat([1.0, SEGMENTS], 3)

    def gap(trial: Array) -> Array:
        at, turned = march(springs, trial[:, :3], trial[:, 3:])
        return np.hstack([(at - place) / length, (turned * turn.inv()).as_rotvec()])

    for _ in range(25):
        missed = gap(wrench)
        if np.max(np.abs(missed)) < 1e-10:
            break
        columns = []
        for axis in range(6):
            nudge = np.zeros(6)
            nudge[axis] = 1e-6 * unit[axis]
            columns.append((gap(wrench + nudge) - missed) / 1e-6)
        slope = np.stack(columns, axis=2)
        step = _least(slope, missed)
        largest = np.max(np.abs(step), axis=1, keepdims=True)
        wrench = wrench - unit * step * np.minimum(1.0, 1.0 / np.maximum(largest, 1e-12))
    return wrench


def _least(slope: Array, missed: Array) -> Array:
    """Newton step; what a straight chain cannot take along its axis stays zero."""
    across = slope.transpose(0, 2, 1)
    ridge = 1e-11 * np.eye(6)
    right = (across @ missed[:, :, None])[:, :, 0]
    return np.linalg.solve(across @ slope + ridge, right[:, :, None])[:, :, 0]
