"""What `softhand hand design` prints: tables in mm, kPa and mN m2, JSON in SI units."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_design.commands.materials import markdown
from softhand_design.design_rules import BrokenRule
from softhand_design.hand_file import actuator_entry, profile_entry
from softhand_design.limits import cast_stiffness
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_design.sizing import Design, Ranking
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.profile import Profile

MILLI, KILO = 1e-3, 1e3
OPTION_UNITS = {  # SI unit: how large the unit of options and messages is in it, and its name
    "1/(m Pa)": (1.0 / KILO, "1/(m kPa)"),
    "N m2": (MILLI, "mN m2"),
    "m": (MILLI, "mm"),
    "Pa": (KILO, "kPa"),
}
OPTIONS = {"actuation_ratio": "ratio", "curvature": "max-curvature"}  # of keys with other names
SHOWN_PRESSURES = (0.25, 0.5, 0.75, 1.0)  # shares of the pressure limit, at which the bend is shown
PLACES = 7  # in the table of a varying wall
Row = tuple[str, str, str, str]


def in_options(error: RequirementError) -> str:
    """Text of the error, with the option's name for the key and in the option's unit."""
    name = OPTIONS.get(error.key, error.key.replace("_", "-"))
    return error.message(name, *OPTION_UNITS.get(error.unit, (1.0, error.unit)))


def in_option_units(broken: BrokenRule) -> BrokenRule:
    """The broken rule in the units of the options."""
    scale, unit = OPTION_UNITS.get(broken.unit, (1.0, broken.unit))
    low, high = (None if end is None else end / scale for end in (broken.low, broken.high))
    return replace(broken, value=broken.value / scale, low=low, high=high, unit=unit)


# ---------------------------------------------------------------------- tables
def table(design: Design, ranking: Ranking) -> str:
    """Text with required and reached values, sizes, and bending of the actuator, with units; then
    the ranking of the rubbers, if there is one.
    """
    if design.requirements.base is not None:
        return _table_of_one_wall(design)
    return "\n\n".join([_table_along(design), *([_ranking_table(ranking)] if ranking else [])])


def _table_of_one_wall(design: Design) -> str:
    wanted, actuator = design.requirements, design.actuator
    ends = np.array([0.0, actuator.length])
    ratio, stiffness = float(actuator.actuation_ratio(0.0)), float(actuator.stiffness(0.0))
    ratios = f"{float(wanted.ratio(0.0)) * KILO:.4g}", f"{ratio * KILO:.4g}"
    stiffnesses = f"{float(wanted.stiffness(0.0)) / MILLI:.4g}", f"{stiffness / MILLI:.4g}"
    walls = (("wall", actuator.wall), ("side wall", actuator.side_wall))
    rows: list[Row] = [
        ("", "wanted", "reached", ""),
        ("actuation ratio", *ratios, "1/(m kPa)"),
        ("stiffness at the base", *stiffnesses, "mN m2"),
        ("", "base", "tip", ""),
        *(_size(key, getattr(actuator, key)(ends)) for key in ("height", "width", "circumference")),
        ("", "", "", ""),
        *(_size(name, [float(wall(0.0))]) for name, wall in walls),
        _size("length", [actuator.length]),
        ("rubber", wanted.rubber.name, "", ""),
        ("shear modulus", f"{actuator.shear_modulus / KILO:.4g}", "", "kPa"),
        ("largest stretch", f"{wanted.rubber.max_stretch:.4g}", "", ""),
        ("density", f"{wanted.rubber.density:.4g}", "", "kg/m3"),
        *_use(actuator),
    ]
    return "\n".join(f"{a:<24}{b:>16}{c:>12}  {d}".rstrip() for a, b, c, d in rows)


def _size(name: str, values: Any) -> Row:
    first, last = ([f"{value / MILLI:.4g}" for value in values] + [""])[:2]
    return name, first, last, "mm"


def _use(actuator: Actuator) -> list[Row]:
    """Mass, largest pressure, and how far it bends up to that."""
    pressures = actuator.max_pressure * np.array(SHOWN_PRESSURES)
    angles = np.degrees(actuator.tip_angle(pressures))
    return [
        ("mass", f"{actuator.mass / MILLI:.4g}", "", "g"),
        ("largest pressure", f"{actuator.max_pressure / KILO:.4g}", "", "kPa"),
        *(
            (f"bend at {pressure / KILO:.4g} kPa", f"{angle:.0f}", "", "deg")
            for pressure, angle in zip(pressures, angles, strict=True)
        ),
    ]


def _table_along(design: Design) -> str:
    """Wanted, reached and sizes at places along the actuator, and the rest of it."""
    actuator = design.actuator
    head = ["x [mm]", "ratio [1/(m kPa)]", "reached", "stiffness [mN m2]", "reached", "as cast"]
    head += ["height [mm]", "width", "circumference", "wall", "side wall"]
    head += ["wall as printed", "circumference as printed"]
    rows = [[f"{number:.4g}" for number in row] for row in _columns(design).T]
    rest: list[Row] = [
        ("length", f"{actuator.length / MILLI:.4g}", "", "mm"),
        ("rubber", design.requirements.rubber.name, "", ""),
        ("shear modulus", f"{actuator.shear_modulus / KILO:.4g}", "", "kPa"),
        *_use(actuator),
    ]
    lines = [f"{name:<24}{value:>16}  {unit}".rstrip() for name, value, _, unit in rest]
    return "\n".join([markdown(head, rows), "", *lines])


def _columns(design: Design) -> Array:
    """Columns of the table (13, places), in the units of the options."""
    wanted, actuator = design.requirements, design.actuator
    x, at = np.linspace(0.0, actuator.length, PLACES), stations(actuator.length)
    printed = [np.interp(x, at, size) for size in design.sizes_without_side_walls(at)]
    ratios = [KILO * profile(x) for profile in (wanted.ratio, actuator.actuation_ratio)]
    stiffness = wanted.stiffness(x), actuator.stiffness(x), cast_stiffness(actuator, x)
    height, width, wall, side_wall = actuator.sides(x)
    sizes = [height, width, actuator.circumference(x), wall, side_wall, *printed]
    return np.array([x / MILLI, *ratios, *(each / MILLI for each in (*stiffness, *sizes))])


def _ranking_table(ranking: Ranking) -> str:
    """How the rubbers rank (rule 5): wall at base and tip and mass, or what refuses them."""
    rows = []
    for rubber, found in ranking:
        cells = [rubber.name, f"{rubber.suitability:.1f}"]
        if isinstance(found, RequirementError):
            rows.append([*cells, "-", "-", in_options(found)])
            continue
        walls = found.actuator.wall(np.array([0.0, found.actuator.length])) / MILLI
        broken = "; ".join(f"breaks {broken.rule}" for broken in found.broken)
        shown = " to ".join(f"{wall:.3g}" for wall in walls)
        rows.append([*cells, shown, f"{found.actuator.mass / MILLI:.3g}", broken])
    return markdown(["rubber", "index [kPa^0.25]", "wall [mm]", "mass [g]", ""], rows)


# ---------------------------------------------------------------------- JSON and file
def record(design: Design, ranking: Ranking) -> dict[str, Any]:
    """The design as plain data, SI units: with one wall it has `reached`, the values at the base,
    else `stations` along the actuator.
    """
    wanted, actuator = design.requirements, design.actuator
    pressures = actuator.max_pressure * np.array(SHOWN_PRESSURES)
    return {
        "wish": _wanted(wanted),
        **(_stations(design) if wanted.base is None else _reached(actuator)),
        "actuator": {"name": actuator.name, **actuator_entry(actuator)},
        "bend": {
            "pressure": pressures.tolist(),
            "tip_angle": actuator.tip_angle(pressures).tolist(),
        },
        "broken_rules": [asdict(broken) | {"text": str(broken)} for broken in design.broken],
        **({"ranking": _ranked(ranking)} if ranking else {}),
    }


def _wanted(wanted: Requirements) -> dict[str, Any]:
    rubber = {"length": wanted.length, "rubber": asdict(wanted.rubber)}
    if wanted.base is not None:
        numbers = {
            "actuation_ratio": float(wanted.ratio(0.0)),
            "stiffness": float(wanted.stiffness(0.0)),
            "tip_stiffness": float(wanted.stiffness(wanted.length)),
        }
        return numbers | rubber | asdict(wanted.base)
    profiles = {key: _entry(getattr(wanted, key)) for key in ("ratio", "stiffness", "aspect")}
    keys = ("side_share", "curvature", "pressure", "arc_radius")
    return profiles | {key: getattr(wanted, key) for key in keys} | rubber


def _entry(profile: Profile | None) -> Any:
    return None if profile is None else profile_entry(profile)


def _reached(actuator: Actuator) -> dict[str, Any]:
    ratio, stiffness = actuator.actuation_ratio(0.0), actuator.stiffness(0.0)
    return {"reached": {"actuation_ratio": float(ratio), "stiffness": float(stiffness)}}


def _stations(design: Design) -> dict[str, Any]:
    actuator, x = design.actuator, stations(design.actuator.length)
    wall, circumference = design.sizes_without_side_walls(x)
    columns = {
        "x": x,
        "ratio": actuator.actuation_ratio(x),
        "stiffness": actuator.stiffness(x),
        "printed_wall": wall,
        "printed_circumference": circumference,
    }
    return {"stations": {name: column.tolist() for name, column in columns.items()}}


def _ranked(ranking: Ranking) -> list[dict[str, Any]]:
    """The ranking as plain data, SI units."""
    return [
        {"rubber": rubber.name, "index": rubber.suitability}
        | (
            {"refused": str(found)}
            if isinstance(found, RequirementError)
            else {"mass": found.actuator.mass, "breaks": [b.rule for b in found.broken]}
        )
        for rubber, found in ranking
    ]


def comment(design: Design) -> str:
    """The comment on the design at the head of its file."""
    wanted, rubber = design.requirements, design.requirements.rubber
    if wanted.base is None:
        return (
            "A designed actuator, as a finger on a stand; what stands under `types` is its entry.\n"
            f"Wanted: actuation ratio [1/(m Pa)] {profile_entry(wanted.ratio)}\n"
            f"and stiffness [N m2] {profile_entry(wanted.stiffness)};\n"
            f"rubber: {rubber.name}, {rubber.density:.4g} kg/m3."
        )
    stiffness, tip = (float(wanted.stiffness(x)) for x in (0.0, wanted.length))
    return (
        "A designed actuator, as a finger on a stand; take what stands under `types` into a hand.\n"
        f"Wanted: actuation ratio {float(wanted.ratio(0.0)):.4g} 1/(m Pa), stiffness "
        f"{stiffness:.4g} N m2 at the base and {tip:.4g} at the tip; "
        f"rubber: {rubber.name}, {rubber.density:.4g} kg/m3."
    )
