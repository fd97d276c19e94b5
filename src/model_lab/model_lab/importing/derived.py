"""Quantities of a set that are functions of the columns of a file.

The tip angle comes from what was tracked: a quaternion, markers, the tip's position, its chord, or
the curvature of the arc. `--map 'tip_angle=tip(x,y)'` names such a function with its columns; a
lone name stands for its parts, so `quaternion(/tip pose.orientation)` has the columns `... .x` to
`... .w`. The angle is 0 at the beginning, which should be at rest (`beginning`), and counts
positive towards where it turns most. A curvature needs the length that bends:
`curvature(kappa, 90mm)`.

Stretch and stress of a strip come from the displacement and the force of a testing machine:
`stretch=elongation(Displacement,50mm)` with the length between the clamps, and
`stress=per_area(Force,30mm2)` with the cross-section at rest.

Any quantity may come from a sensor that is linear: `pressure=linear(Volt,50,-25):kPa` is 50 times
the column less 25, in kPa.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.cell_words import words
from model_lab.measurements.at_rest import beginning
from model_lab.measurements.units import column_unit

DISPLACEMENT_WORDS = (
    *("displacement", "extension", "elongation", "crosshead", "traverse", "stroke", "position"),
    *("weg", "verlangerung", "deplacement", "course", "spostamento", "desplazamiento"),
)  # how testing machines name by how much the clamps have moved
OPEN_LENGTH, OPEN_AREA = "LENGTH", "AREA"  # what a suggestion leaves to the user
UNIT_AT_END = re.compile(r"_(?:mm|cm|m|px)$")  # of a length
PART_SIGNS = (".", "_", " ", "")  # between the name of what was tracked and its parts
CURVATURE_WORDS = ("curvature", "kappa", "krummung", "courbure", "curvatura", "κ")
TIP_WORDS = {"tip", "spitze", "pointe", "punta", "fingertip", "fingerspitze"}
_LENGTH = re.compile(r"(\d+(?:\.\d+)?|\.\d+)\s*(mm|cm|m)$")
_AREA = re.compile(r"(\d+(?:\.\d+)?|\.\d+)\s*(mm|cm|m)(?:2|²|\^2|\*\*2)$")
_CALL = re.compile(r"\s*(\w+)\((.*)\)\s*$")


@dataclass(frozen=True)
class Derivation:
    """A function of the columns of a file that gives the tip angle, the stretch or the stress.

    parts: letters, such as xyz, of the columns for which a single name stands; "" if it stands for
    itself. sizes: numbers of columns that the function takes. values: maps columns (k, samples) to
    values (samples,) in `unit`, or of a chord in the unit of its column. said: what it does, in
    words. sized: if the function needs its one column in SI units, combined with a size of the
    specimen, what that is; else None.
    """

    parts: str
    sizes: tuple[int, ...]
    values: Callable[[Array], Array]
    said: str
    sized: Sized | None = None
    unit: str = "rad"


@dataclass(frozen=True)
class Sized:
    """A size of the specimen that a function of one column needs.

    of: quantity of the column, as `column_unit` names it. size: what the user has to state.
    example: how that is written. times: whether the column is multiplied by the size, not divided.
    """

    of: str
    size: str
    example: str
    times: bool = False

    def combined(self, column: Array, argument: str) -> Array | None:
        """Column (samples,) in SI units, multiplied or divided by the size; None if the argument
        states no positive size.
        """
        size = stated_size(argument, area=self.example.endswith("2"))
        if not size:
            return None
        return column * size if self.times else column / size


def derivation(text: str) -> tuple[Derivation, list[str]] | None:
    """(function, its arguments) of a text such as `tip(x, y)`; None for the name of a column.

    >>> derivation("tip(x, y)")[1], derivation("angle (deg)")
    (['x', 'y'], None)
    """
    found = _CALL.match(text)
    if found is None or found[1] not in DERIVATIONS:
        return None
    return DERIVATIONS[found[1]], [name.strip() for name in found[2].split(",")]


def quaternion_angle(components: Array) -> Array:
    """Angle (samples,) [rad] by which a body has turned since the beginning.

    components (4, samples): x, y, z, w, of any norm and sign. The angle is counted about the axis
    about which the body turns most, and may exceed half a turn.
    """
    x, y, z, w = components / np.linalg.norm(components, axis=0)
    vector, real = np.stack([x, y, z]), w
    start, start_real = -vector[:, :1], real[0]  # the inverse of the first
    turned = start_real * vector + real * start + np.cross(start, vector, axis=0)
    turned_real = start_real * real - np.sum(start * vector, axis=0)
    turned = np.where(turned_real < 0.0, -turned, turned)
    axis = np.linalg.svd(turned, full_matrices=False)[0][:, 0]
    return _from_beginning(2.0 * np.arctan2(axis @ turned, np.abs(turned_real)))


def direction_angle(vectors: Array) -> Array:
    """Angle (samples,) [rad] by which vectors (2 or 3, samples) have turned, in the plane in which
    they turn, since the beginning.
    """
    unit = vectors / np.linalg.norm(vectors, axis=0)
    plane = np.linalg.svd(unit, full_matrices=False)[0][:, :2]
    first, second = plane.T @ unit
    return _from_beginning(np.arctan2(second, first))


def markers_angle(positions: Array) -> Array:
    """Tip angle (samples,) [rad] from coordinates (4, 6 or 9, samples) of markers.

    For two markers, both on the tip, it is the angle by which the line between them has turned. For
    three, at base, in between and at the tip, it is the angle of an arc through them: twice the
    angle between the two chords. Four numbers are two markers in a plane, six two in space.
    """
    size = 2 if len(positions) == 4 else 3
    return _of_points(positions.reshape(len(positions) // size, size, -1))


def plane_markers_angle(positions: Array) -> Array:
    """Tip angle (samples,) [rad] as `markers_angle` gives it, from two or three markers in a plane:
    (4 or 6, samples).
    """
    return _of_points(positions.reshape(len(positions) // 2, 2, -1))


def _of_points(points: Array) -> Array:
    chords = np.diff(points, axis=0)
    if len(chords) == 1:
        return direction_angle(chords[0])
    first, second = chords / np.linalg.norm(chords, axis=1, keepdims=True)
    along = np.sum(first * second, axis=0)
    if len(first) == 2:
        across = first[0] * second[1] - first[1] * second[0]
    else:
        across = np.linalg.norm(np.cross(first, second, axis=0), axis=0)
    return _from_beginning(2.0 * np.arctan2(across, along))


def tip_angle(position: Array) -> Array:
    """Tip angle (samples,) [rad] of an arc from the origin to a tip (2 or 3, samples): twice the
    angle by which its chord has turned.
    """
    return 2.0 * direction_angle(position)


def chord_angle(angle: Array) -> Array:
    """Tip angle (samples,) of an arc whose chord has turned to an angle (1, samples), in the same
    unit.
    """
    return 2.0 * (angle[0] - beginning(angle[0]))


def curvature_angle(bend: Array) -> Array:
    """Tip angle (samples,) [rad] of an arc, from curvature times length (1, samples)."""
    return _from_beginning(bend[0])


def radius_angle(ratio: Array) -> Array:
    """Tip angle (samples,) [rad] of an arc, from radius / length (1, samples); an infinite
    radius is a straight arc.
    """
    return _from_beginning(1.0 / ratio[0])


def elongation_stretch(ratio: Array) -> Array:
    """Stretch (samples,) [-] of a strip, from the displacement of a clamp divided by the length
    between the clamps (1, samples); it is 1 at the first sample.
    """
    return np.asarray(1.0 + ratio[0] - ratio[0, 0])


def area_stress(ratio: Array) -> Array:
    """Nominal stress (samples,) [Pa], from the force divided by the cross-section at rest (1,
    samples).
    """
    return ratio[0]


def stated_size(argument: str, area: bool = False) -> float | None:
    """Length [m] that a text such as `90mm` states, or with `area` the area [m^2] of `30mm2` or
    `10mm x 3mm`; None if it states none.

    >>> stated_size("90mm"), stated_size("0.09 m"), stated_size("LENGTH")
    (0.09, 0.09, None)
    >>> f"{stated_size('30 mm2', area=True):g}", f"{stated_size('10mm x 3mm', area=True):g}"
    ('3e-05', '3e-05')
    """
    if not area:
        found = _LENGTH.match(argument)
        return float(found[1]) * column_unit("tip_x", found[2]).scale if found else None
    found = _AREA.match(argument)
    if found:
        return float(found[1]) * column_unit("tip_x", found[2]).scale ** 2
    width, thickness = (stated_size(side.strip()) for side in (*argument.split("x"), "", "")[:2])
    return width * thickness if width and thickness else None


def _from_beginning(angle: Array) -> Array:
    """A course of angles [rad] without jumps, 0 at the beginning, positive where it goes
    farthest.
    """
    course = np.unwrap(angle)
    course = course - beginning(course)
    farthest = course[np.argmax(np.abs(course))]
    return np.asarray(course if farthest >= 0.0 else -course)


DERIVATIONS = {
    "quaternion": Derivation("xyzw", (4,), quaternion_angle, "the turn since the beginning"),
    "markers": Derivation("", (4, 6, 9), markers_angle, "the turn since the beginning"),
    "plane_markers": Derivation("", (4, 6), plane_markers_angle, "the turn since the beginning"),
    "tip": Derivation("xyz", (2, 3), tip_angle, "twice the turn of the chord from the origin"),
    "chord": Derivation("", (1,), chord_angle, "twice the angle of the chord"),
    "curvature": Derivation(
        "",
        (1,),
        curvature_angle,
        "curvature times length",
        Sized("curvature", "length that bends", "90mm", times=True),
    ),
    "radius": Derivation(
        "",
        (1,),
        radius_angle,
        "length over radius",
        Sized("radius", "length that bends", "90mm"),
    ),
    "elongation": Derivation(
        "",
        (1,),
        elongation_stretch,
        "1 + displacement over length",
        Sized("displacement", "length between the clamps", "50mm"),
        unit="",
    ),
    "per_area": Derivation(
        "",
        (1,),
        area_stress,
        "force over cross-section",
        Sized("force", "cross-section", "30mm2"),
        unit="Pa",
    ),
    "linear": Derivation("", (1,), lambda column: column[0], "slope times the column, plus offset"),
}


def calibrated(values: Array, constants: Sequence[str]) -> Array | None:
    """Values (samples,) times the slope, plus the offset: texts of two numbers; None if they are
    not two finite numbers, or the slope is 0.

    >>> calibrated(np.array([0.5, 1.0]), ["50", "-25"]), calibrated(np.array([0.5]), ["kPa"])
    (array([ 0., 25.]), None)
    """
    try:
        slope, offset = map(float, constants)
    except ValueError:
        return None
    known = np.isfinite([slope, offset]).all() and slope != 0.0
    return np.asarray(slope * values + offset) if known else None


def argument_names(names: Sequence[str], parts: str, known: Sequence[str]) -> list[str]:
    """Columns that the arguments of a function name. A single name that is no column of the file
    stands for the columns with its `parts`, such as `tip.x`, `tip.y`, `tip.z`.
    """
    if len(names) == 1 and names[0] not in known and parts:
        for sign in PART_SIGNS:
            for spelt in (parts, parts.upper()):
                columns = [f"{names[0]}{sign}{part}" for part in spelt]
                if set(columns) <= set(known):
                    return columns
    return list(names)


def suggestion(names: Sequence[str]) -> str | None:
    """Text of the function that gives a tip angle, if the names of columns are those of a
    quaternion, of two or three markers, of a curvature, or of the tip's position; else None.

    >>> suggestion(["Rotation X", "Rotation Y", "Rotation Z", "Rotation W"])
    'quaternion(Rotation)'
    >>> suggestion(["base x", "base y", "tip x", "tip y"])
    'plane_markers(base x,base y,tip x,tip y)'
    >>> suggestion([f"{name} {axis}" for name in ("base", "mid", "tip1", "tip2") for axis in "xy"])
    'plane_markers(tip1 x,tip1 y,tip2 x,tip2 y)'
    >>> suggestion(["pressure", "x", "y"])
    'tip(x,y)'
    """
    for whole in _wholes(names, "xyzw"):
        return f"quaternion({whole})"
    for parts, kind in (("xyz", "markers"), ("xy", "plane_markers")):
        bodies = _markers_for_angle(_wholes(names, parts))
        if bodies:
            return f"{kind}({','.join(column for body in bodies for column in body)})"
    curved = next((name for name in names if _is_curvature(name)), None)
    if curved:
        return f"curvature({curved},{OPEN_LENGTH})"
    for parts in ("xyz", "xy"):
        for columns in (list(parts), list(parts.upper()), *_wholes(names, parts).values()):
            if set(columns) <= set(names):
                return f"tip({','.join(columns)})"
    return None


def _markers_for_angle(wholes: Mapping[str, list[str]]) -> list[list[str]]:
    """Columns of the two or three markers of an angle: all, if there are no more; two on the tip,
    as their names say; else the first, middle and last, which should be base, middle and tip. Empty
    if there is one marker.
    """
    bodies = list(wholes.values())
    if len(bodies) <= 3:
        return bodies if len(bodies) > 1 else []
    tips = [body for name, body in wholes.items() if TIP_WORDS & set(words(name))]
    return tips if len(tips) == 2 else [bodies[0], bodies[len(bodies) // 2], bodies[-1]]


def _is_curvature(name: str) -> bool:
    return any(word in _plain(name) for word in CURVATURE_WORDS)


def displacements(names: Iterable[str]) -> list[str]:
    """Those columns whose names say by how much the clamps of a testing machine have moved.

    >>> displacements(["Zeit", "Traversenweg", "Standardkraft"])
    ['Traversenweg']
    """
    return [name for name in names if any(word in _plain(name) for word in DISPLACEMENT_WORDS)]


def _plain(name: str) -> str:
    """A name in small letters without accents."""
    plain = unicodedata.normalize("NFKD", name.casefold())
    return "".join(letter for letter in plain if not unicodedata.combining(letter))


def _wholes(names: Sequence[str], parts: str) -> dict[str, list[str]]:
    """Columns of all the parts of what has them, by the name of the whole.

    >>> _wholes(["t", "tip_x_mm", "tip_y_mm"], "xy")
    {'tip': ['tip_x_mm', 'tip_y_mm']}
    """
    found = {}
    for name in names:
        unit = "".join(UNIT_AT_END.findall(name))
        part_of = name.removesuffix(unit)
        for spelt in (parts, parts.upper()):
            columns = [part_of[:-1] + part + unit for part in spelt]
            whole = part_of[:-1].rstrip("".join(PART_SIGNS))
            if part_of.endswith(spelt[0]) and set(columns) <= set(names) and whole:
                found[whole] = columns
    return found
