"""`softhand hand design`: wall and profile of an actuator from what it should do.

Options, table, warnings and errors are in mm, kPa and mN m2; files and JSON in SI units.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from softhand_model.documents.output_file import check_new, write_new
from softhand_model.documents.yaml_document import NAME_RULE, Bounds, is_name
from softhand_model.hand.actuator import Actuator, actuator_names, nominal_rubber
from softhand_model.hand.design_rules import BrokenRule
from softhand_model.hand.plausible import DENSITY, LENGTH, SECTION, SHEAR_MODULUS, WALL
from softhand_model.hand.profile import Profile
from softhand_model.hand.rubber import Rubber, load_rubbers
from softhand_model.hand.sizing import (
    Design,
    Wish,
    WishError,
    actuator_entry,
    design_actuator,
    finger_text,
)

MILLI, KILO = 1e-3, 1e3
USUAL_RUBBER = "Dragon Skin 10"
RUBBER_HELP = "one of Table 3.2, or beside profiles auto: the one of the highest index that does"
SHOWN = {  # SI unit: how large the unit of options and messages is in it, and its name
    "1/(m Pa)": (1.0 / KILO, "1/(m kPa)"),
    "N m2": (MILLI, "mN m2"),
    "m": (MILLI, "mm"),
    "Pa": (KILO, "kPa"),
}
OPTIONS = {"actuation_ratio": "ratio", "curvature": "max-curvature"}  # of keys with other names
SIZES = {"length": LENGTH, "wall": WALL, "height": SECTION, "width": SECTION}
MODULUS = Bounds(SHEAR_MODULUS.low / KILO, SHEAR_MODULUS.high / KILO, "kPa")
WALLS = ("wall", "side_wall")
STRETCH = Bounds(1.01, 100.0, "")
SHARES = (0.25, 0.5, 0.75, 1.0)  # of the pressure limit, at which the bend is shown


def add_to(commands: Any) -> argparse.ArgumentParser:
    """Add the command to the subparsers of `hand`."""
    found = commands.add_parser(
        "design",
        help="wall and profile of an actuator from its actuation ratio and stiffness",
        description="Find wall and profile of an actuator from a wanted actuation ratio and "
        "stiffness by the rules of thumb of section 3.6.1, side walls included. Warns where a rule "
        "is broken. The file it writes is a hand of that one finger. With profiles of the ratio or "
        "the stiffness the wall is a profile too.",
    )
    add, number = found.add_argument, {"type": float}
    add("--ratio", **number, help="curvature over pressure [1/(m kPa)]")
    add("--stiffness", **number, help="bending stiffness at the base [mN m2]")
    add("--length", **number, help="[mm]")
    add("--tip-stiffness", **number, help="that at the tip [mN m2] (0)")
    add("--rubber", default=USUAL_RUBBER, help=f"{RUBBER_HELP} (%(default)s)")
    add("--modulus", **number, help="shear modulus of a rubber of your own [kPa]")
    add("--max-stretch", **number, help="its largest stretch [-], given together with --modulus")
    add("--density", **number, help="of the rubber [kg/m3] (that of --rubber)")
    add("--wall", **number, help="thickness [mm], where it is fixed")
    add("--height", **number, help="height at the base [mm], where it is fixed")
    add("--width", **number, help="width at the base [mm], where it is fixed")
    add("--name", default="finger", help="of the actuator (%(default)s)")
    add("-o", "--out", type=Path, help="YAML file to write")
    add("--force", action="store_true", help="overwrite that file")
    add("--json", action="store_true", help="print JSON in SI units instead of the table")
    found.set_defaults(run=run)
    return found


def run(options: argparse.Namespace) -> None:
    """Design, print and write; raises ValueError for wishes that cannot be fulfilled."""
    check_names(options)
    for name in ("ratio", "stiffness", "length"):
        if getattr(options, name) is None:
            raise ValueError(f"{name}: expected a number, got none")
    try:
        design = design_actuator(wish_of(options), options.name)
    except WishError as error:
        raise ValueError(in_options(error)) from error
    tell(options, design.actuator, _comment(design), record(design), table(design), design.broken)


def check_names(options: argparse.Namespace) -> None:
    """Raise ValueError for a name or a file that cannot be written."""
    if options.name in actuator_names():
        raise ValueError(f"name: expected none of a shipped actuator, got {options.name}")
    if not is_name(options.name):
        raise ValueError(f"name: expected {NAME_RULE}, got {options.name!r}")
    if options.out is not None:
        check_new(options.out, options.force, (".yaml", ".yml"))


def tell(
    options: argparse.Namespace,
    actuator: Actuator,
    comment: str,
    recorded: dict[str, Any],
    shown: str,
    broken: Iterable[BrokenRule],
) -> None:
    """Write the actuator's file if there is one, print its record or table, and warnings."""
    if options.out is not None:
        warned = [f"Warning: {rule}" for rule in broken]
        write_new(options.out, finger_text(actuator, "\n".join([comment, *warned])), force=True)
    print(json.dumps(recorded, indent=2) if options.json else shown)
    for rule in broken:
        print(f"warning: {_shown(rule)}", file=sys.stderr)


def in_options(error: WishError) -> str:
    """The error with name and unit of the option."""
    name = OPTIONS.get(error.key, error.key.replace("_", "-"))
    return error.told(name, *SHOWN.get(error.unit, (1.0, error.unit)))


def _shown(broken: BrokenRule) -> BrokenRule:
    """The broken rule in the unit of the options."""
    scale, unit = SHOWN.get(broken.unit, (1.0, broken.unit))
    numbers = {key: getattr(broken, key) for key in ("value", "low", "high")}
    scaled = {key: None if number is None else number / scale for key, number in numbers.items()}
    return replace(broken, **scaled, unit=unit)


def wish_of(options: argparse.Namespace) -> Wish:
    """The wish in SI units."""
    given = {key: getattr(options, key) for key in SIZES}
    sizes = {
        key: None if size is None else MILLI * within(key, size, in_mm(SIZES[key]))
        for key, size in given.items()
    }
    return Wish(
        options.ratio / KILO,
        options.stiffness * MILLI,
        sizes.pop("length"),
        chosen_rubber(options.rubber, options.modulus, options.max_stretch, options.density),
        (options.tip_stiffness or 0.0) * MILLI,
        **sizes,
    )


def chosen_rubber(
    name: str, modulus: float | None, max_stretch: float | None, density: float | None
) -> Rubber:
    """A rubber of Table 3.2, or `custom` of a modulus [kPa] and largest stretch [-]; with another
    density [kg/m3] where given. Raises ValueError with the names there are.

    Dragon Skin 10 has the nominal modulus of the shipped actuators, not that of the table.

    >>> chosen_rubber("Dragon Skin 10", None, None, None).shear_modulus
    67000.0
    """
    rubbers = load_rubbers()
    if name not in rubbers:
        raise ValueError(f"rubber: expected one of {', '.join(rubbers)}, got {name}")
    found = rubbers[name]
    if name == USUAL_RUBBER:
        found = replace(found, shear_modulus=nominal_rubber()[0])
    if density is not None:
        found = replace(found, density=within("density", density, DENSITY))
    if modulus is None and max_stretch is None:
        return found
    if modulus is None or max_stretch is None:
        missing, given = ("modulus", "max-stretch")[:: 1 if modulus is None else -1]
        raise ValueError(
            f"{missing}: expected a number beside {given}, since rule 5 and the pressure limit "
            "take both of one rubber, got none"
        )
    modulus = within("modulus", modulus, MODULUS)
    max_stretch = within("max-stretch", max_stretch, STRETCH)
    return Rubber("custom", "", "", max_stretch, modulus * KILO, found.density)


def in_mm(bounds: Bounds) -> Bounds:
    """Bounds [m] in mm."""
    return Bounds(bounds.low / MILLI, bounds.high / MILLI, "mm")


def within(option: str, value: float, bounds: Bounds) -> float:
    """A value of an option within bounds; raises ValueError naming both."""
    if not bounds.low <= value <= bounds.high:
        limits = f"{bounds.low:g} to {bounds.high:g} {bounds.unit}".rstrip()
        raise ValueError(f"{option}: expected {limits}, got {value:g}")
    return value


def table(design: Design) -> str:
    """What was wanted and what came, the sizes, and how far it bends, with units."""
    wish, actuator = design.wish, design.actuator
    ends = np.array([0.0, actuator.length])
    rows = [
        ("", "wanted", "reached", ""),
        (
            "actuation ratio",
            f"{wish.actuation_ratio * KILO:.4g}",
            f"{float(actuator.actuation_ratio(0.0)) * KILO:.4g}",
            "1/(m kPa)",
        ),
        (
            "stiffness at the base",
            f"{wish.stiffness / MILLI:.4g}",
            f"{float(actuator.stiffness(0.0)) / MILLI:.4g}",
            "mN m2",
        ),
        ("", "base", "tip", ""),
        *(_size(key, getattr(actuator, key)(ends)) for key in ("height", "width", "circumference")),
        ("", "", "", ""),
        *(
            _size(key.replace("_", " "), _ends(getattr(actuator, key), actuator.length))
            for key in WALLS
        ),
        _size("length", [actuator.length]),
        ("rubber", wish.rubber.name, "", ""),
        ("shear modulus", f"{actuator.shear_modulus / KILO:.4g}", "", "kPa"),
        ("largest stretch", f"{wish.rubber.max_stretch:.4g}", "", ""),
        ("density", f"{wish.rubber.density:.4g}", "", "kg/m3"),
        ("mass", f"{actuator.mass / MILLI:.4g}", "", "g"),
        ("largest pressure", f"{actuator.max_pressure / KILO:.4g}", "", "kPa"),
        *bends(actuator),
    ]
    return "\n".join(f"{a:<24}{b:>16}{c:>12}  {d}".rstrip() for a, b, c, d in rows)


def _size(name: str, values: Any) -> tuple[str, str, str, str]:
    first, last = ([f"{value / MILLI:.4g}" for value in values] + [""])[:2]
    return name, first, last, "mm"


def _ends(profile: Profile, length: float) -> list[float]:
    """Value [m] at the base, and at the tip where that is another."""
    return list(dict.fromkeys(profile(np.array([0.0, length])).tolist()))


def bends(actuator: Actuator) -> list[tuple[str, str, str, str]]:
    """Rows of a table: how far it bends up to its largest pressure."""
    pressures = actuator.max_pressure * np.array(SHARES)
    angles = np.degrees(actuator.tip_angle(pressures))
    return [
        (f"bend at {pressure / KILO:.4g} kPa", f"{angle:.0f}", "", "deg")
        for pressure, angle in zip(pressures, angles, strict=True)
    ]


def record(design: Design) -> dict[str, Any]:
    """The design as plain data, SI units."""
    actuator = design.actuator
    pressures = actuator.max_pressure * np.array(SHARES)
    return {
        "wish": asdict(design.wish),
        "reached": {
            "actuation_ratio": float(actuator.actuation_ratio(0.0)),
            "stiffness": float(actuator.stiffness(0.0)),
        },
        "actuator": {"name": actuator.name, **actuator_entry(actuator)},
        "bend": {
            "pressure": pressures.tolist(),
            "tip_angle": actuator.tip_angle(pressures).tolist(),
        },
        "broken_rules": [asdict(broken) | {"text": str(broken)} for broken in design.broken],
    }


def _comment(design: Design) -> str:
    wish = design.wish
    lines = [
        "A designed actuator, as a finger on a stand; take what stands under `types` into a hand.",
        f"Wanted: actuation ratio {wish.actuation_ratio:.4g} 1/(m Pa), stiffness "
        f"{wish.stiffness:.4g} N m2 at the base and {wish.tip_stiffness:.4g} at the tip; "
        f"rubber: {wish.rubber.name}, {wish.rubber.density:.4g} kg/m3.",
    ]
    return "\n".join(lines)
