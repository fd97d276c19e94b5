"""Solids of uniform density: volume, centre and inertia; and convex pieces of a mesh: its hull, or
a decomposition by CoACD that is cached for the user.

CoACD (MIT, `pip install coacd`) is used instead of PyBullet's own V-HACD: on a torus of 104 mm it
took 3.5 s against 12.5 s, and its ten pieces have 5 % more volume than the torus, V-HACD's nine 12
%. Both give the same pieces every time.
"""

from __future__ import annotations

import hashlib
import os
import threading
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module, metadata
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from pneuflex_sim.scene.bodies import bodies_of
from pneuflex_sim.scene.mesh import Mesh, hull_mesh
from softhand_common.documents.output_file import UnwritableFile, written_whole
from softhand_common.numerics.arrays import Array
from softhand_common.progress import Progress

NEAR_DIAGONAL = 1e-9  # products of inertia below this share of the trace count as none
CONVEX_VOLUME_SHARE = 0.99  # share of the hull's volume from which a mesh counts as convex
COACD_SETTINGS = {"threshold": 0.05, "max_ch_vertex": 64, "decimate": True, "seed": 0}  # of CoACD
TELL_PERIOD = 1.0  # [s]
CACHE_HINT = "kept for the next time; `pieces: hull` in the object's file is cheaper"
MAX_CORNER_SHIFT = 10.0  # erosions by which a corner moves at most
MAX_EROSION_SHARE = 0.45  # share of a piece's thickness that erosion takes from each side at most


@dataclass(frozen=True)
class Solid:
    """Volume [m3], centre of mass (3,) [m] and inertia (3, 3) per mass [m2] about the centre of
    mass.
    """

    volume: float
    center: Array
    inertia: Array

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) per mass [m2], and the quaternion (4,) of their axes.

        Axes of the solid that are principal already are kept.
        """
        off_diagonal = self.inertia - np.diag(np.diag(self.inertia))
        if np.abs(off_diagonal).max() <= NEAR_DIAGONAL * np.trace(self.inertia):
            return np.diag(self.inertia).copy(), np.array([0.0, 0.0, 0.0, 1.0])
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        return moments, Rotation.from_matrix(axes).as_quat()


def ellipsoid_solid(size: ArrayLike) -> Solid:
    """An ellipsoid of axes (3,) [m] around the origin."""
    squares = (0.5 * np.asarray(size, float)) ** 2
    volume = 4.0 / 3.0 * np.pi * float(np.sqrt(squares.prod()))
    return Solid(volume, np.zeros(3), np.diag(squares.sum() - squares) / 5.0)


def box_solid(size: ArrayLike) -> Solid:
    """A box of a size (3,) [m] around the origin."""
    squares = np.asarray(size, float) ** 2
    volume = float(np.prod(np.asarray(size)))
    return Solid(volume, np.zeros(3), np.diag(squares.sum() - squares) / 12.0)


def cylinder_solid(diameter: float, length: float) -> Solid:
    """A cylinder of a diameter and a length [m] along z around the origin."""
    square = (0.5 * diameter) ** 2
    across = square / 4.0 + length**2 / 12.0
    return Solid(np.pi * square * length, np.zeros(3), np.diag([across, across, square / 2.0]))


def mesh_solid(mesh: Mesh) -> Solid:
    """The solid within a closed surface; raises ValueError for a surface that encloses no volume,
    or whose faces look inwards.
    """
    found = mesh.trimesh
    with np.errstate(invalid="ignore", divide="ignore"):  # the centre of what encloses nothing
        volume = float(found.volume)
    if not volume > 0:
        raise ValueError(f"surface: expected one that encloses a volume, got {volume:g} m3")
    return Solid(volume, np.array(found.center_mass), found.moment_inertia / volume)


def hull_solid(points: Array) -> Solid:
    """The convex hull of points (k, 3) [m]."""
    return mesh_solid(hull_mesh(points))


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


def convex_pieces(mesh: Mesh) -> tuple[Array, ...]:
    """Vertices (k, 3) [m] of convex pieces that fill a closed mesh: one for a convex mesh, else by
    CoACD.

    Separate bodies in the mesh are decomposed one by one; they may overlap, which CoACD itself
    takes minutes to resolve. Progress is shown on standard error.

    Raises ValueError for a mesh without thickness, and when CoACD is needed and not installed.
    """
    bodies = bodies_of(mesh)
    found: list[Array] = []
    with _shown(len(bodies)) as begin:
        for number, body in enumerate(bodies, start=1):
            begin(number)
            found += _pieces_of_body(body)
    return tuple(found)


def _pieces_of_body(mesh: Mesh) -> tuple[Array, ...]:
    try:
        hull = ConvexHull(mesh.vertices)
    except QhullError as reason:
        raise ValueError(
            "surface: expected one that encloses a volume, got corners in one plane"
        ) from reason
    if mesh.volume >= CONVEX_VOLUME_SHARE * hull.volume:
        return (mesh.vertices[hull.vertices],)
    cache = cache_file(mesh)
    found = _kept(cache)
    if found is None:
        found = _decomposed(mesh)
        _keep(cache, found)
    return found


def cache_file(mesh: Mesh) -> Path:
    """The file in which the convex pieces of a mesh are cached. Its name is a digest of the mesh,
    and of CoACD's settings and version, as it cuts the mesh.

    Raises ValueError when CoACD is not installed.
    """
    try:
        version = metadata.version("coacd")
    except metadata.PackageNotFoundError as reason:
        raise ValueError(
            "mesh: it is not convex, and CoACD, which would cut it into convex pieces, is not "
            "installed: `pip install coacd`, or give `pieces: hull`, which fills its hollows"
        ) from reason
    key = hashlib.sha256(repr((version, sorted(COACD_SETTINGS.items()))).encode())
    key.update(mesh.vertices.tobytes() + mesh.indices.tobytes())
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "softhand" / "pieces" / f"{key.hexdigest()[:32]}.npz"


@contextmanager
def _shown(count: int) -> Iterator[Callable[[int], None]]:
    """Show progress from a thread while the block runs, since CoACD reports none; yields a function
    to call with the number of the body (of `count`) that begins.
    """
    ended, begun = threading.Event(), 1

    def begin(number: int) -> None:
        nonlocal begun
        begun = number

    def show() -> None:
        with Progress("cutting a mesh into convex pieces") as progress:
            while not ended.wait(TELL_PERIOD):
                progress(f"body {begun} of {count}; {CACHE_HINT}", 0, 0)

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield begin
    finally:
        ended.set()
        thread.join()


def _kept(cache: Path) -> tuple[Array, ...] | None:
    """Cached pieces; None when there are none that can be read."""
    if not cache.is_file():
        return None
    try:
        with np.load(cache) as kept:
            return tuple(kept[name] for name in kept.files)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


def _decomposed(mesh: Mesh) -> tuple[Array, ...]:
    coacd = import_module("coacd")
    coacd.set_log_level("error")
    found = coacd.run_coacd(
        coacd.Mesh(mesh.vertices, mesh.indices.reshape(-1, 3)), **COACD_SETTINGS
    )
    return tuple(vertices for vertices, _ in found if _is_thick(vertices))


def _is_thick(vertices: Array) -> bool:
    """Whether points (k, 3) do not lie in one plane."""
    try:
        ConvexHull(vertices)
    except QhullError:
        return False
    return True


def _keep(cache: Path, pieces: tuple[Array, ...]) -> None:
    """Write the cache; if that fails, the pieces are computed again the next time."""
    try:
        with written_whole(cache) as file:
            np.savez_compressed(file, *pieces)
    except UnwritableFile as reason:
        warnings.warn(f"{reason}; the convex pieces are not kept", stacklevel=2)


def eroded(vertices: Array, margin: float) -> Array:
    """Vertices (k, 3) [m] of the hull of points with its faces moved inwards by a margin [m], or by
    less for pieces thinner than two margins, so that a tenth of their thickness remains.

    Exact at vertices where three faces meet, least squares where more do.

    >>> cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    >>> float(eroded(cube, 0.1).min().round(9)), float(eroded(cube, 0.1).max().round(9))
    (0.1, 0.9)
    """
    hull = ConvexHull(vertices)
    depth = -(hull.equations[:, :3] @ vertices.T + hull.equations[:, 3:])
    margin = min(margin, MAX_EROSION_SHARE * float(depth.max(axis=1).min()))
    moved = []
    for index in hull.vertices:
        normals = hull.equations[(hull.simplices == index).any(axis=1), :3]
        move = np.linalg.lstsq(normals, np.full(len(normals), -margin), rcond=1e-6)[0]
        move *= min(1.0, MAX_CORNER_SHIFT * margin / float(np.linalg.norm(move)))
        moved.append(vertices[index] + move)
    return np.array(moved)
