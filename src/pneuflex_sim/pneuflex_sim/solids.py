"""Mass, centre and inertia of solids of even density: closed forms and integrals over meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

NEAR_DIAGONAL = 1e-9  # products of inertia below this share of the trace count as none


@dataclass(frozen=True)
class Solid:
    """Volume [m3], centre of mass (3,) [m] and inertia (3, 3) about it per mass [m2]."""

    volume: float
    center: Array
    inertia: Array

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) per mass [m2], and the quaternion (4,) of their axes.

        Axes that are principal as they are stay so.
        """
        off_diagonal = self.inertia - np.diag(np.diag(self.inertia))
        if np.abs(off_diagonal).max() <= NEAR_DIAGONAL * np.trace(self.inertia):
            return np.diag(self.inertia).copy(), np.array([0.0, 0.0, 0.0, 1.0])
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        return moments, Rotation.from_matrix(axes).as_quat()


def ellipsoid_solid(size: Sequence[float]) -> Solid:
    """An ellipsoid of axes (3,) [m] around the origin."""
    squares = (0.5 * np.asarray(size, float)) ** 2
    volume = 4.0 / 3.0 * np.pi * float(np.sqrt(squares.prod()))
    return Solid(volume, np.zeros(3), np.diag(squares.sum() - squares) / 5.0)


def box_solid(size: Sequence[float]) -> Solid:
    """A box of a size (3,) [m] around the origin."""
    squares = np.asarray(size, float) ** 2
    volume = float(np.prod(np.asarray(size)))
    return Solid(volume, np.zeros(3), np.diag(squares.sum() - squares) / 12.0)


def cylinder_solid(diameter: float, length: float) -> Solid:
    """A cylinder of a diameter and a length [m] along z around the origin."""
    square = (0.5 * diameter) ** 2
    across = square / 4.0 + length**2 / 12.0
    return Solid(np.pi * square * length, np.zeros(3), np.diag([across, across, square / 2.0]))


def polyhedron_solid(corners: Array) -> Solid:
    """The solid within a closed surface of triangles (t, 3, 3) [m], counterclockwise from outside:
    sum over the tetrahedra that they span with the origin.

    Raises ValueError for a surface that encloses nothing, or looks inwards.
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    six_fold = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = float(six_fold.sum()) / 6.0
    if not volume > 0:
        raise ValueError(f"surface: expected one that encloses a volume, got {volume:g} m3")
    center = six_fold @ (a + b + c) / (24.0 * volume)
    sums = [a + b + c, a, b, c]
    second = sum(np.einsum("i,ij,ik->jk", six_fold, x, x) for x in sums) / (120.0 * volume)
    second = second - np.outer(center, center)
    return Solid(volume, center, np.trace(second) * np.eye(3) - second)


def hull_solid(vertices: Array) -> Solid:
    """The convex hull of points (k, 3) [m]."""
    hull = ConvexHull(vertices)
    corners = vertices[hull.simplices]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0
    corners[inwards] = corners[inwards, ::-1]
    return polyhedron_solid(corners)


def joined(solids: Sequence[Solid]) -> Solid:
    """Several solids of one density that do not overlap, as one."""
    volumes = np.array([solid.volume for solid in solids])
    shares = volumes / volumes.sum()
    center = shares @ np.array([solid.center for solid in solids])
    inertia = np.zeros((3, 3))
    for share, solid in zip(shares, solids, strict=True):
        away = solid.center - center
        inertia += share * (solid.inertia + away @ away * np.eye(3) - np.outer(away, away))
    return Solid(float(volumes.sum()), center, inertia)
