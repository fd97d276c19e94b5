"""A PneuFlex actuator: its profiles along x and derived quantities (chapter 3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.quoted import shortened
from softhand_common.documents.yaml_document import Bounds, Node, read_document
from softhand_common.numerics.arrays import Array
from softhand_model.data_files import data_file
from softhand_model.hand import plausible, section
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile, TaperedProfile

FORMAT = "softhand-actuators/1"
PANEL_GAUSS_POINTS = 8  # on each of PANELS pieces: the tip angle of a P10 finger is exact to 1e-9
PANEL_GAUSS = np.polynomial.legendre.leggauss(PANEL_GAUSS_POINTS)  # points and weights
PANELS = 8
PANELS_PER_SEGMENT = 2
STATION_TOLERANCE = 0.01  # of the length, for the last x of a profile: arcs have no round length
REQUIRED_KEYS = ("height", "width", "wall", "side_wall", "max_pressure")
OPTIONAL_KEYS = (
    "length",
    "circumference",
    "arc_radius",
    "arc_angle",
    "supply_volume",
    "mass",
    "shear_modulus",
    "density",
)

TAPER_ROOT_BOUNDS = Bounds(0.1, 100.0, "")
PROFILES = {
    "height": plausible.SECTION_SIZE,
    "width": plausible.SECTION_SIZE,
    "wall": plausible.WALL_THICKNESS,
    "side_wall": plausible.SIDE_WALL_THICKNESS,
}
ACTUATOR_BOUNDS = {
    "max_pressure": plausible.LIMIT_PRESSURE,
    "supply_volume": plausible.SUPPLY_VOLUME,
    "shear_modulus": plausible.SHEAR_MODULUS,
    "density": plausible.DENSITY,
}


@dataclass(frozen=True)
class Actuator:
    """One actuator. The coordinate x [m] runs from its base along the passive layer, also if that
    is curved to an arc.

    length [m]; height, width, circumference, wall and side_wall [m] as profiles; shear_modulus
    [Pa]; mass [kg] of the rubber; max_pressure [Pa]; supply_volume [m3] of what is connected to the
    chamber, such as the tube; arc_radius [m] and arc_angle [rad] if the passive layer is curved
    within its plane (as in the palm), else None.
    """

    name: str
    length: float
    height: Profile
    width: Profile
    circumference: Profile
    wall: Profile
    side_wall: Profile
    shear_modulus: float
    mass: float
    max_pressure: float
    supply_volume: float = 0.0
    arc_radius: float | None = None
    arc_angle: float | None = None

    def side_wall_ratio(self, x: ArrayLike) -> Array:
        """Side wall factor `ratio` [-] at x (eq. 3.35)."""
        return section.side_wall_ratio(*self.sides(x))

    def sides(self, x: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Height, width, wall and side wall [m] at x."""
        return self.height(x), self.width(x), self.wall(x), self.side_wall(x)

    def actuation_ratio(self, x: ArrayLike) -> Array:
        """Actuation ratio dkappa/dp = ratio/(8*G*d) [1/(m Pa)] at x (eq. 3.32 with 3.37).

        It is the exact kappa/p where lambda + lambda**-3 = 2, that is where the top is stretched to
        1.839; below that pressure the actuator bends less, above it more.

        >>> round(1e3 * float(load_actuator("P10.finger").actuation_ratio(0.0)), 3)
        1.031
        """
        rule = section.rule_actuation_ratio(self.wall(x), self.shear_modulus)
        return self.side_wall_ratio(x) * rule

    def free_curvature(self, pressure: ArrayLike, x: ArrayLike) -> Array:
        """Exact curvature [1/m] without load at a gauge pressure [Pa]; 0 for negative pressures.

        >>> finger = load_actuator("P10.finger")
        >>> round(float(finger.free_curvature(30e3, 0.0)), 2)
        26.05
        """
        return section.free_curvature(np.maximum(pressure, 0.0), *self.sides(x), self.shear_modulus)

    def stiffness(self, x: ArrayLike) -> Array:
        """Bending stiffness [N m2] of the simulation's linear springs at x (eq. 3.26 with 3.35).

        B = (2/ratio)*2*G*d*(c/4)**3, 1.81 times 3.26 at the base of a P10. This is the one place
        where the linear stiffness is fixed: the circumference form of the rule (its curvature
        factor (1 + 3*lambda**-4)/2, 2 when straight and 1/2 when far bent, set to 1), times the
        share 2/ratio of the side walls that also divides the load. Rest angles and springs then
        agree on the moment of a blocked section: G, d and ratio cancel, as they must, up to the
        secant nonlinearity of kappa(p). The text adds the smaller share of eq. 3.29 instead and
        thereby loses a quarter of that moment (ERRATUM, see `section.bending_stiffness`).

        >>> round(float(load_actuator("P10.finger").stiffness(0.0)) * 1e3, 3)
        3.881
        """
        edge = self.circumference(x) / 4.0
        return (
            2.0
            / self.side_wall_ratio(x)
            * section.rule_stiffness(edge, self.wall(x), self.shear_modulus)
        )

    def chamber_volume_per_length(self, x: ArrayLike, curvature: ArrayLike = 0.0) -> Array:
        """Air volume per length [m2] at x and a curvature [1/m], without the volume of the walls
        (eq. 3.15).
        """
        return section.chamber_area(curvature, *self.sides(x))

    def chamber_volume_gain(self, x: ArrayLike) -> Array:
        """Change of the chamber volume with the bending angle [m3/rad] at x: z*h**2/2."""
        return self.width(x) * self.height(x) ** 2 / 2.0

    def chamber_volume(self, curvature: ArrayLike = 0.0) -> float:
        """Air volume [m3] of the chamber, without supply volume, at a uniform curvature [1/m].

        >>> round(load_actuator("P5").chamber_volume() * 1e6, 2)
        2.16
        """
        x, weight = self.quadrature()
        return float(np.sum(weight * self.chamber_volume_per_length(x, curvature)))

    def tip_angle(self, pressure: ArrayLike) -> Array:
        """Angle [rad] between tip and base without load, at pressures [Pa] of any shape.

        >>> round(float(np.degrees(load_actuator("P10.finger").tip_angle(31e3))), 1)
        143.5
        """
        x, weight = self.quadrature()
        pressure = np.asarray(pressure, float)
        return np.sum(weight * self.free_curvature(pressure[..., None], x), axis=-1)

    def rubber_volume(self) -> float:
        """Volume [m3] of top and side walls; passive layer, thread and plugs are left out."""
        x, weight = self.quadrature()
        return float(np.sum(weight * self._rubber_area(x)))

    def _rubber_area(self, x: Array) -> Array:
        height, width, wall, side_wall = self.sides(x)
        return width * wall + np.maximum(height - wall, 0.0) * 2.0 * side_wall

    def quadrature(
        self, start: float = 0.0, stop: float | None = None, panels: int = PANELS
    ) -> tuple[Array, Array]:
        """Gauss points x [m] and weights [m] between two positions [m] of the actuator; stop None:
        up to its tip.
        """
        points, weights = PANEL_GAUSS
        edges = np.linspace(start, self.length if stop is None else stop, panels + 1)
        half = np.diff(edges)[:, None] / 2.0
        x = edges[:-1, None] + half * (points + 1.0)
        return x.ravel(), (half * weights).ravel()

    def segment_quadrature(self, segments: int) -> tuple[Array, Array]:
        """Gauss points x and weights [m], (segments, points), on equal segments of the length."""
        x, weight = self.quadrature(panels=segments * PANELS_PER_SEGMENT)
        return x.reshape(segments, -1), weight.reshape(segments, -1)

    def mass_between(self, start: float, stop: float) -> float:
        """Mass [kg] of the rubber between two positions [m]."""
        x, weight = self.quadrature(start, stop)
        return self.mass * float(np.sum(weight * self._rubber_area(x))) / self.rubber_volume()

    def with_modulus(self, scale: float) -> Actuator:
        """The actuator made of a rubber with `scale` [-] times the shear modulus."""
        return replace(self, shear_modulus=scale * self.shear_modulus)


def load_actuator(name: str, path: Path | None = None) -> Actuator:
    """The actuator of that name in data/actuators.yaml or another file of its format.

    path: the file; None: data/actuators.yaml. Raises ValueError for a name that is not in the file
    (the message lists the names) or a file that is not valid.
    """
    actuators = _load_all(path or data_file("actuators.yaml"))[2]
    if name not in actuators:
        raise ValueError(f"actuator: expected one of {', '.join(actuators)}, got {shortened(name)}")
    return actuators[name]


def actuator_names() -> list[str]:
    """Names of the shipped actuators."""
    return list(_shipped()[2])


def own_actuators(node: Node) -> dict[str, Actuator]:
    """Actuators, by name, in the document of a user, with the keys of data/actuators.yaml. An
    actuator of another rubber than the shipped ones states `shear_modulus` and `density`.

    Raises DocumentError for an entry that is not valid, and for the name of a shipped actuator.
    """
    modulus, density, shipped = _shipped()
    found = {}
    for name, entry in node.mapping().items():
        if name in shipped:
            raise entry.error(
                f"a name other than those of shipped actuators ({', '.join(shipped)})", name
            )
        found[name] = _actuator(name, entry, modulus, density)
    return found


def nominal_rubber() -> tuple[float, float]:
    """Shear modulus [Pa] and density [kg/m3] of the rubber of the shipped actuators.

    >>> nominal_rubber()
    (67000.0, 1070.0)
    """
    return _shipped()[:2]


def _shipped() -> tuple[float, float, dict[str, Actuator]]:
    return _load_all(data_file("actuators.yaml"))


@lru_cache(maxsize=8)
def _load_all(path: Path) -> tuple[float, float, dict[str, Actuator]]:
    """Shear modulus [Pa] and density [kg/m3] of a file's rubber, and its actuators by name."""
    document = read_document(path, FORMAT).fields(
        ["format", "shear_modulus", "density", "actuators"]
    )
    modulus = document["shear_modulus"].within(plausible.SHEAR_MODULUS)
    density = document["density"].within(plausible.DENSITY)
    actuators = document["actuators"].mapping().items()
    return (
        modulus,
        density,
        {key: _actuator(key, node, modulus, density) for key, node in actuators},
    )


def _actuator(name: str, node: Node, modulus: float, density: float) -> Actuator:
    fields = node.fields(REQUIRED_KEYS, OPTIONAL_KEYS)
    length, radius, angle = _length(node, fields)
    sizes = {key: read_profile(fields[key], length, bounds) for key, bounds in PROFILES.items()}
    around = fields.get("circumference")
    given = {
        key: fields[key].within(bounds) for key, bounds in ACTUATOR_BOUNDS.items() if key in fields
    }
    actuator = Actuator(
        name,
        length,
        sizes["height"],
        sizes["width"],
        read_profile(around, length, plausible.CIRCUMFERENCE)
        if around
        else _rectangle_around(sizes["height"], sizes["width"], length),
        sizes["wall"],
        sizes["side_wall"],
        given.get("shear_modulus", modulus),
        0.0,
        given["max_pressure"],
        given.get("supply_volume", 0.0),
        radius,
        angle,
    )
    _refuse_full(actuator, fields)
    usual = given.get("density", density)
    return replace(actuator, mass=_mass(node, fields, usual, actuator.rubber_volume()))


def _refuse_full(actuator: Actuator, fields: dict[str, Node]) -> None:
    """Refuse walls that leave no chamber somewhere along the actuator."""
    x = np.append(actuator.quadrature()[0], [0.0, actuator.length])
    height, width, wall, side_wall = actuator.sides(x)
    for key, size, room, name in (
        ("wall", wall, height, "the height"),
        ("side_wall", side_wall, width / 2.0, "half the width"),
    ):
        least = int(np.argmin(room - size))
        if size[least] >= room[least]:
            place = f"{room[least]:.4g} at x = {x[least]:.4g} m"
            raise fields[key].error(f"a number below {name}, {place}")


def _mass(node: Node, fields: dict[str, Node], density: float, volume: float) -> float:
    """Mass [kg] as it is given, or by the density [kg/m3] of a volume [m3] of rubber."""
    if "mass" not in fields:
        return density * volume
    if "density" in fields:
        raise node.error("either mass or density", "both of them")
    low, high = plausible.DENSITY.low * volume, plausible.DENSITY.high * volume
    return fields["mass"].within(Bounds(low, high, "kg for this volume of rubber"))


def _length(node: Node, fields: dict[str, Node]) -> tuple[float, float | None, float | None]:
    """Length [m], and radius [m] and angle [rad] of an arc; one of both is given."""
    arc = [key for key in ("arc_radius", "arc_angle") if key in fields]
    if ("length" in fields) == bool(arc) or len(arc) == 1:
        got = ", ".join(key for key in ["length", *arc] if key in fields)
        raise node.error("length, or arc_radius and arc_angle", got or "none of them")
    if not arc:
        return fields["length"].within(plausible.LENGTH), None, None
    radius, angle = (
        fields["arc_radius"].within(plausible.LENGTH),
        fields["arc_angle"].number(above=0.0, high=2.0 * np.pi),
    )
    return radius * angle, radius, angle


def read_profile(
    node: Node, length: float, bounds: Bounds = plausible.SECTION_SIZE, unit: str = "m"
) -> Profile:
    """A profile over a length [m], or in another unit, from YAML: a number, a list of [x, value],
    or {maximum, taper, root}; values and maximum within bounds.
    """
    if isinstance(node.value, dict):
        taper = node.fields(["maximum", "taper", "root"])
        return TaperedProfile(
            taper["maximum"].within(bounds),
            length,
            taper["taper"].number(0.0, 1.0),
            taper["root"].within(TAPER_ROOT_BOUNDS),
        )
    if isinstance(node.value, list):
        return _table(node, length, bounds, unit)
    return ConstantProfile(node.within(bounds))


def _table(node: Node, length: float, bounds: Bounds, unit: str) -> TableProfile:
    """Straight lines between stations from the base to the tip."""
    x = [row.vector(2)[0] for row in node.items()]
    if len(x) < 2 or not all(before < after for before, after in pairwise(x)):
        raise node.error("at least two [x, value] with growing x")
    if x[0] != 0.0 or abs(x[-1] - length) > STATION_TOLERANCE * length:
        raise node.error(f"[x, value] from x = 0 to the length, {length:.4g} {unit}")
    return TableProfile(tuple(x), tuple(row.items()[1].within(bounds) for row in node.items()))


def _rectangle_around(height: Profile, width: Profile, length: float) -> Profile:
    """Circumference of the rectangle, where none is given."""
    x = np.linspace(0.0, length, 33)
    return TableProfile(tuple(x), tuple(2.0 * (height(x) + width(x))))
