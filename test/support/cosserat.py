"""Static Cosserat rods by collocation: what a chain of ever more segments should come to.

A rod that neither stretches nor shears, with a bending stiffness B(x) and a free curvature that
vary along it. It is solved as a boundary-value problem by `scipy.integrate.solve_bvp` and shares no
code with the chain, its static solvers or the simulator; only B and the free curvature are those of
the actuator. Frames are as there: z along the finger, bending about y towards +x.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

from softhand_model.hand.actuator import Actuator

STUB = 1e-5  # share of the length at the tip that is taken as rigid: B falls to 0 there
NODES = 41  # at the start; the solver adds what it needs
TOLERANCE = 1e-8
MOST_NODES = 20000
LOAD_STEPS = 8
Along = Callable[[np.ndarray], np.ndarray]
"""A quantity at positions x [m] from the base."""


@dataclass(frozen=True)
class Rod:
    """length [m], stiffness B [N m2] about all axes, free curvature [1/m] about y, mass per length
    [kg/m], and the centre of mass [m] of a section across the rod, towards +x.
    """

    length: float
    stiffness: Along
    free_curvature: Along
    mass: Along = np.zeros_like
    center: Along = np.zeros_like


@dataclass(frozen=True)
class Bent:
    """A planar solution: angle of the tip [rad], its place (x, z) [m], force of the stop on it [N],
    and the places (2, k) [m] of positions x (k,) [m].
    """

    tip_angle: float
    tip: np.ndarray
    tip_force: float
    x: np.ndarray
    places: np.ndarray


def rod_of(actuator: Actuator, pressure: float) -> Rod:
    """The rod with the linear stiffness, free curvature and rubber of an actuator at a pressure."""
    per_area = actuator.mass / actuator.rubber_volume()

    def mass(x):
        height, width, wall, side_wall = actuator.sides(x)
        return per_area * (width * wall + 2.0 * np.maximum(height - wall, 0.0) * side_wall)

    return Rod(
        actuator.length,
        actuator.stiffness,
        lambda x: actuator.free_curvature(pressure, x),
        mass,
        lambda x: -actuator.height(x) / 2.0,
    )


def free(rod: Rod, gravity=(0.0, 0.0)) -> Bent:
    """The rod with nothing at its tip, under gravity (x, z) [m/s2]."""
    return _grown(rod, gravity, None)


def blocked(rod: Rod, level: float, gravity=(0.0, 0.0)) -> Bent:
    """The rod whose tip rests on a frictionless plane x = level [m], which pushes it to -x."""
    return _grown(rod, gravity, level)


def _grown(rod: Rod, gravity, level: float | None) -> Bent:
    """The solution at full load, followed from a straight rod without any."""
    end = rod.length * (1.0 - STUB)
    x = np.linspace(0.0, end, NODES)
    values = np.zeros((6, NODES))
    values[1] = x
    for share in np.linspace(0.0, 1.0, LOAD_STEPS + 1)[1:]:
        pull = share * np.asarray(gravity, float)
        # the plane comes along: the straight rod would not touch it
        stop = None if level is None else share * level
        found = solve_bvp(
            _planar(rod, share, pull),
            _planar_ends(rod, stop),
            x,
            values,
            tol=TOLERANCE,
            max_nodes=MOST_NODES,
        )
        if not found.success:
            raise RuntimeError(f"no solution at {share:.2f} of the load: {found.message}")
        x, values = found.x, found.y
    return _bent(rod, x, values)


def _planar(rod: Rod, share: float, gravity: np.ndarray):
    """Slopes of x, z, angle, moment and force of what lies beyond each section."""

    def slopes(s, y):
        _, _, angle, moment, force_x, force_z = y
        sine, cosine = np.sin(angle), np.cos(angle)
        weight = rod.mass(s)
        curvature = share * rod.free_curvature(s) + moment / rod.stiffness(s)
        shear = cosine * force_x - sine * force_z
        off_axis = rod.center(s) * weight * (-sine * gravity[0] - cosine * gravity[1])
        zero = np.zeros_like(s)
        return np.stack(
            [
                sine,
                cosine,
                curvature,
                -shear - off_axis,
                zero - weight * gravity[0],
                zero - weight * gravity[1],
            ]
        )

    return slopes


def _planar_ends(rod: Rod, level: float | None):
    stub = STUB * rod.length

    def ends(base, tip):
        sine, cosine = np.sin(tip[2]), np.cos(tip[2])
        stop = tip[4] if level is None else tip[0] + stub * sine - level
        lever = stub * (cosine * tip[4] - sine * tip[5])
        return np.array([base[0], base[1], base[2], tip[3] - lever, tip[5], stop])

    return ends


def _bent(rod: Rod, x: np.ndarray, values: np.ndarray) -> Bent:
    angle = float(values[2, -1])
    tip = values[:2, -1] + STUB * rod.length * np.array([np.sin(angle), np.cos(angle)])
    return Bent(angle, tip, -float(values[4, -1]), x, values[:2])


@dataclass(frozen=True)
class Held:
    """A rod held at both ends: force [N] and torque [N m] (3,) on its base, places (3, k) [m] of
    positions x (k,) [m].
    """

    force: np.ndarray
    torque: np.ndarray
    x: np.ndarray
    places: np.ndarray


def held(rod: Rod, reach: float, poses: list[tuple[np.ndarray, Rotation]]) -> Held:
    """The part of a rod from its base to x = reach [m], held there in the last of some poses
    (place (3,) [m], orientation), which lead from the free one to it in small steps.
    """
    part = replace(rod, length=reach)
    x, values = _free_in_space(part)
    for place, turn in poses:
        found = solve_bvp(
            _spatial(part),
            _spatial_ends(place, turn),
            x,
            values,
            tol=TOLERANCE,
            max_nodes=MOST_NODES,
        )
        if not found.success:
            raise RuntimeError(f"no solution at {place}: {found.message}")
        x, values = found.x, found.y
    return Held(values[7:10, 0], values[10:13, 0], x, values[:3])


def _free_in_space(rod: Rod) -> tuple[np.ndarray, np.ndarray]:
    """Positions and state (13, k): place, quaternion x y z w, force and moment of what is beyond,
    of the rod without load.
    """
    plane = free(replace(rod, mass=np.zeros_like, center=np.zeros_like))
    x = np.linspace(0.0, rod.length, NODES)
    angle = np.array([_integral(rod.free_curvature, stop) for stop in x])
    values = np.zeros((13, NODES))
    values[0], values[2] = (np.interp(x, plane.x, row) for row in plane.places)
    values[4], values[6] = np.sin(angle / 2.0), np.cos(angle / 2.0)
    return x, values


def _integral(function: Along, stop: float) -> float:
    points, weights = np.polynomial.legendre.leggauss(24)
    return float(stop / 2.0 * weights @ function(stop / 2.0 * (points + 1.0)))


def _spatial(rod: Rod):
    def slopes(s, y):
        x, y_, z, w = y[3:7]
        force, moment = y[7:10], y[10:13]
        first = np.array([1 - 2 * (y_**2 + z**2), 2 * (x * y_ + w * z), 2 * (x * z - w * y_)])
        second = np.array([2 * (x * y_ - w * z), 1 - 2 * (x**2 + z**2), 2 * (y_ * z + w * x)])
        along = np.array([2 * (x * z + w * y_), 2 * (y_ * z - w * x), 1 - 2 * (x**2 + y_**2)])
        stiffness = rod.stiffness(s)
        a, b, c = (np.sum(axis * moment, axis=0) / stiffness for axis in (first, second, along))
        b = b + rod.free_curvature(s)
        turned = 0.5 * np.array(
            [
                w * a + y_ * c - z * b,
                w * b + z * a - x * c,
                w * c + x * b - y_ * a,
                -x * a - y_ * b - z * c,
            ]
        )
        shear = -np.cross(along, force, axis=0)
        return np.concatenate([along, turned, np.zeros_like(force), shear])

    return slopes


def _spatial_ends(place: np.ndarray, turn: Rotation):
    def ends(base, tip):
        against = (turn.inv() * Rotation.from_quat(tip[3:7])).as_quat()
        return np.concatenate(
            [base[:3], base[3:7] - [0.0, 0.0, 0.0, 1.0], tip[:3] - place, against[:3]]
        )

    return ends


def free_end(rod: Rod, reach: float) -> tuple[np.ndarray, Rotation]:
    """Place (3,) [m] and orientation of an unloaded rod at x = reach [m]."""
    _, values = _free_in_space(replace(rod, length=reach))
    return values[:3, -1], Rotation.from_quat(values[3:7, -1])
