"""Equilibrium of a finger in its bending plane, without time steps.

It shares no code with the simulator, so that the simulator can be tested against it: n joints about
y with linear or exact springs, weight, and a frictionless stop at the tip. Points and forces are
(x, z) in the frame of the finger's base.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_model.chain.segments import SegmentChain
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator

LOAD_STEPS = 20
PLANAR_NEWTON_STEPS = 100
LARGEST_PLANAR_STEP = 0.5  # [rad or N]
PLANAR_DIFFERENCE = 1e-6
MOMENT_TOLERANCE = 1e-13  # largest moment out of balance [N m]
STOP_SCALE = 100.0  # weight of a gap [m] against angles [rad] in the solver

Springs = Callable[[Array, float], Array]
"""Bending moment (n,) [N m] of the joints at angles (n,) [rad] and a share of the load [-]."""


@dataclass(frozen=True)
class PlanarFinger:
    """Rigid links in a plane: n joints about y, z along the links.

    offset (n,) [m] from the joint before (or the base) to each joint, tip [m] from the last joint
    to the tip, mass (n,) [kg] and center (n, 2) [m] of the links in their frames.
    """

    offset: Array
    tip: float
    mass: Array
    center: Array


@dataclass(frozen=True)
class Stop:
    """A frictionless plane for the tip: normal @ tip >= level [m], the normal to the free side."""

    normal: tuple[float, float]
    level: float


@dataclass(frozen=True)
class Equilibrium:
    """Joint angles (n,) [rad], position of the tip (2,) [m], force of the stop on the tip [N]."""

    angles: Array
    tip: Array
    tip_force: float


def planar_finger(chain: SegmentChain) -> PlanarFinger:
    """The planar finger of a straight chain, as the simulator has it.

    Raises ValueError for a chain that leaves the plane.
    """
    chain.require_straight()
    center = chain.body_center[:, [0, 2]]
    return PlanarFinger(chain.offset[:, 2], float(chain.tip_offset[2]), chain.mass, center)


def linear_springs(stiffness: ArrayLike, rest: ArrayLike) -> Springs:
    """Springs of stiffness (n,) [N m/rad] whose rest angles (n,) [rad] grow with the load."""
    stiffness, rest = np.asarray(stiffness, float), np.asarray(rest, float)
    return lambda angles, share: stiffness * (share * rest - angles)


def exact_springs(actuator: Actuator, segments: int, pressure: float) -> Springs:
    """Springs with the exact moment of section 3.4.3 in the middle of each segment, at a pressure
    [Pa] that grows with the load.
    """
    edge = actuator.length / segments
    x = (np.arange(segments) + 0.5) * edge
    size, modulus = actuator.sides(x), actuator.shear_modulus

    def moment(angles: Array, share: float) -> Array:
        return section.bending_moment(share * pressure, angles / edge, *size, modulus)

    return moment


def equilibrium(
    finger: PlanarFinger,
    springs: Springs,
    gravity: ArrayLike = (0.0, 0.0),
    stop: Stop | None = None,
) -> Equilibrium:
    """Equilibrium of the finger, followed while load and gravity (2,) [m/s2] grow from zero.

    Raises RuntimeError when no equilibrium is found on the way.

    >>> bar = PlanarFinger(np.array([0.05]), 0.05, np.array([0.0]), np.zeros((1, 2)))
    >>> wall = Stop((-1.0, 0.0), 0.0)
    >>> round(equilibrium(bar, linear_springs([0.02], [1.0]), stop=wall).tip_force, 6)
    0.4
    """
    gravity = np.asarray(gravity, float)
    angles, force = np.zeros(len(finger.mass)), 0.0
    for share in np.linspace(0.0, 1.0, LOAD_STEPS + 1)[1:]:
        angles, force = _balance(finger, springs, gravity, stop, share, angles, force)
    return Equilibrium(angles, _frames(finger, angles)[2], force)


def _balance(
    finger: PlanarFinger,
    springs: Springs,
    gravity: Array,
    stop: Stop | None,
    share: float,
    angles: Array,
    force: float,
) -> tuple[Array, float]:
    """Angles [rad] and stop force [N] at a share of the load, from those at a smaller one.

    A finger that leans on the stop stays there as long as it presses: a free one may curl up so far
    that its tip clears the stop again, which is another equilibrium.
    """
    if stop is not None and force > 0.0:
        pressed, force = _against_stop(finger, springs, share * gravity, stop, share, angles, force)
        if force >= 0.0:
            return pressed, force

    def out_of_balance(unknown: Array) -> Array:
        return springs(unknown, share) + _moments(finger, unknown, share * gravity, np.zeros(2))

    free = _solve(out_of_balance, angles)
    if stop is None or _gap(finger, free, stop) >= 0.0:
        return free, 0.0
    return _against_stop(finger, springs, share * gravity, stop, share, angles, 0.0)


def _against_stop(
    finger: PlanarFinger,
    springs: Springs,
    gravity: Array,
    stop: Stop,
    share: float,
    angles: Array,
    force: float,
) -> tuple[Array, float]:
    """Angles [rad] and force [N], of either sign, that keep the tip on the stop."""
    normal, count = np.array(stop.normal), len(angles)

    def out_of_balance(unknown: Array) -> Array:
        moment = _moments(finger, unknown[:count], gravity, unknown[count] * normal)
        gap = STOP_SCALE * _gap(finger, unknown[:count], stop)
        return np.append(springs(unknown[:count], share) + moment, gap)

    found = _solve(out_of_balance, np.append(angles, force))
    return found[:count], float(found[count])


def _solve(function: Callable[[Array], Array], start: Array) -> Array:
    """Root by Newton with central differences, with steps limited to LARGEST_PLANAR_STEP.

    (MINPACK's hybrid method stalls where the last solution is zero but for rounding.)
    """
    unknown = np.array(start, float)
    for _ in range(PLANAR_NEWTON_STEPS):
        residual = function(unknown)
        if np.abs(residual).max() <= MOMENT_TOLERANCE:
            return unknown
        step = np.linalg.solve(_jacobian(function, unknown), residual)
        unknown -= step * min(1.0, LARGEST_PLANAR_STEP / np.abs(step).max())
    worst = float(np.abs(function(unknown)).max())
    raise RuntimeError(f"no static equilibrium: {worst:.2g} N m out of balance")


def _jacobian(function: Callable[[Array], Array], unknown: Array) -> Array:
    shifts = PLANAR_DIFFERENCE * np.eye(len(unknown))
    return np.stack(
        [
            (function(unknown + s) - function(unknown - s)) / (2.0 * PLANAR_DIFFERENCE)
            for s in shifts
        ],
        axis=1,
    )


def _frames(finger: PlanarFinger, angles: Array) -> tuple[Array, Array, Array]:
    """Joints (n, 2), centres of mass (n, 2) and tip (2,) [m]."""
    turned = np.cumsum(angles)
    along = np.stack([np.sin(turned), np.cos(turned)], axis=1)
    across = np.stack([np.cos(turned), -np.sin(turned)], axis=1)
    before = np.vstack([[0.0, 1.0], along[:-1]])
    joints = np.cumsum(finger.offset[:, None] * before, axis=0)
    centers = joints + finger.center[:, :1] * across + finger.center[:, 1:] * along
    return joints, centers, joints[-1] + finger.tip * along[-1]


def _moments(finger: PlanarFinger, angles: Array, gravity: Array, push: Array) -> Array:
    """Moment (n,) [N m] about y of weight and of the push (2,) [N] at the tip on every joint."""
    joints, centers, tip = _frames(finger, angles)
    lever = centers[None] - joints[:, None]
    weight = finger.mass * (lever[..., 1] * gravity[0] - lever[..., 0] * gravity[1])
    reach = tip - joints
    return np.triu(weight).sum(axis=1) + reach[:, 1] * push[0] - reach[:, 0] * push[1]


def _gap(finger: PlanarFinger, angles: Array, stop: Stop) -> float:
    return float(np.dot(stop.normal, _frames(finger, angles)[2])) - stop.level
