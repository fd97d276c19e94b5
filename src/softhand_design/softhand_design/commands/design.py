"""`softhand hand design`: an actuator from its requirements.

Options, table, warnings and errors are in mm, kPa and mN m2; files and JSON in SI units.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from softhand_common.documents.output_file import PICTURES, check_new, save_figure, write_new
from softhand_common.documents.yaml_document import NAME_RULE, Bounds, DocumentError, Node, is_name
from softhand_common.documents.yaml_reading import read_yaml
from softhand_design.commands import design_output as output
from softhand_design.commands.design_output import KILO, MILLI
from softhand_design.commands.materials import within
from softhand_design.hand_file import finger_text
from softhand_design.requirements import RequirementError, Requirements, of_numbers
from softhand_design.sizing import Design, Ranking, design_actuator, rank_rubbers
from softhand_model.hand.actuator import actuator_names, nominal_rubber, read_profile
from softhand_model.hand.plausible import (
    DENSITY,
    LENGTH,
    LIMIT_PRESSURE,
    SECTION_SIZE,
    SHEAR_MODULUS,
    WALL_THICKNESS,
)
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile, TaperedProfile
from softhand_model.hand.rubber import Rubber, load_rubbers

USUAL_RUBBER, AUTO, TAPERS = "Dragon Skin 10", "auto", "P10"
RUBBER_HELP = "one of Table 3.2, or beside profiles auto: the one of the highest index that does"
REQUIRED_MODULUS = Bounds(SHEAR_MODULUS.low / KILO, SHEAR_MODULUS.high / KILO, "kPa")
LARGEST_PRESSURE = Bounds(LIMIT_PRESSURE.low / KILO, LIMIT_PRESSURE.high / KILO, "kPa")
REQUIRED_STRETCH = Bounds(1.01, 100.0, "")
REQUIRED_RATIO = Bounds(1e-4, 1e3, "1/(m kPa)")
REQUIRED_STIFFNESS = Bounds(0.0, 1e6, "mN m2")
ASPECT = Bounds(0.1, 10.0, "")
SIDE_SHARE = Bounds(0.01, 3.0, "")
REQUIRED_CURVATURE = Bounds(0.1, 1e4, "1/m")
REQUIRED_ANGLE = Bounds(1.0, 360.0, "deg")
FIXED = {"wall": WALL_THICKNESS, "height": SECTION_SIZE, "width": SECTION_SIZE}
NUMBERS = ("ratio", "stiffness", "length")  # that one wall needs
FOR_PROFILES = (  # options for a varying wall alone
    "aspect",
    "side_share",
    "max_curvature",
    "pressure",
    "arc_radius",
    "arc_angle",
    "figure",
)
EXCLUDED = {  # by an option, others that it replaces
    "ratio_profile": ("ratio",),
    "stiffness_profile": ("stiffness", "tip_stiffness"),
    "length": ("arc_radius", "arc_angle"),
}
FORMS = "a number, [[x, value], ...] with x [mm] from base to tip, or {maximum, taper, root}"


def add_to(commands: Any) -> None:
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
    add("--length", **number, help="length of the actuator [mm]")
    add("--tip-stiffness", **number, help="bending stiffness at the tip [mN m2] (0)")
    add("--rubber", default=USUAL_RUBBER, help=f"{RUBBER_HELP} (%(default)s)")
    add("--modulus", **number, help="shear modulus of a rubber of your own [kPa]")
    add("--max-stretch", **number, help="largest stretch of that rubber [-]")
    add("--density", **number, help="of the rubber [kg/m3] (that of --rubber)")
    add("--wall", **number, help="thickness [mm], where it is fixed")
    add("--height", **number, help="height at the base [mm], where it is fixed")
    add("--width", **number, help="width at the base [mm], where it is fixed")
    add("--name", default="finger", help="of the actuator (%(default)s)")
    add("-o", "--out", type=Path, help="YAML file to write")
    add("--force", action="store_true", help="overwrite that file")
    add("--json", action="store_true", help="print JSON in SI units instead of the table")
    group = found.add_argument_group("profiles", f"Along the actuator, as text in YAML: {FORMS}.")
    add = group.add_argument
    add("--ratio-profile", metavar="P", help="curvature over pressure [1/(m kPa)]")
    add("--stiffness-profile", metavar="P", help="bending stiffness [mN m2]")
    add("--aspect", metavar="P", help=f"width over height [-] (1), or {TAPERS}: its tapers")
    add("--side-share", **number, help="side wall over wall [-] (1)")
    largest = "the largest in use [1/m], which sets the pressure limit"
    add("--max-curvature", **number, help=largest)
    add("--pressure", **number, help="largest pressure in use [kPa]")
    arc = "radius of a curved actuator [mm], instead of --length"
    add("--arc-radius", **number, help=arc)
    add("--arc-angle", **number, help="angle of a curved actuator [deg]")
    add("--figure", type=Path, help="picture of profiles, section and bend to write")
    found.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Design, print and write; raises ValueError for requirements that cannot be met."""
    _check_options(options)
    try:
        design, ranking = _designed(options)
    except RequirementError as error:
        raise ValueError(output.in_options(error)) from error
    if options.figure is not None:
        from softhand_design.drawings.design_picture import draw_design  # late: needs matplotlib

        save_figure(draw_design(design), options.figure)
    if options.out is not None:
        warned = [f"Warning: {rule}" for rule in design.broken]
        comment = "\n".join([output.comment(design), *warned])
        write_new(options.out, finger_text(design.actuator, comment), force=True)
    shown = json.dumps(output.record(design, ranking), indent=2) if options.json else None
    print(shown or output.table(design, ranking))
    for rule in design.broken:
        print(f"warning: {output.in_option_units(rule)}", file=sys.stderr)


def _check_options(options: argparse.Namespace) -> None:
    """Raise ValueError for options that do not fit together, and files that cannot be written."""
    if _one_wall(options):
        _refuse_given(options, FOR_PROFILES, "a profile beside it")
    else:
        _refuse_given(options, FIXED, "nothing beside profiles")
        for name, others in EXCLUDED.items():
            if getattr(options, name) is not None:
                _refuse_given(options, others, f"none beside {name.replace('_', '-')}")
        if options.rubber == AUTO:
            _refuse_given(options, ("modulus", "max_stretch", "density"), "none beside rubber auto")
    if options.name in actuator_names():
        raise ValueError(
            f"name: expected another name than those of shipped actuators, got {options.name}"
        )
    if not is_name(options.name):
        raise ValueError(f"name: expected {NAME_RULE}, got {options.name!r}")
    if options.out is not None:
        check_new(options.out, options.force, (".yaml", ".yml"))
    if options.figure is not None:
        check_new(options.figure, options.force, PICTURES)


def _one_wall(options: argparse.Namespace) -> bool:
    return options.ratio_profile is None and options.stiffness_profile is None


def _refuse_given(options: argparse.Namespace, names: Iterable[str], expected: str) -> None:
    for name in names:
        if getattr(options, name) is not None:
            option = name.replace("_", "-")
            raise ValueError(f"{option}: expected {expected}, got {getattr(options, name)}")


def _designed(options: argparse.Namespace) -> tuple[Design, Ranking]:
    """The design, and how the rubbers rank where one is chosen."""
    if _one_wall(options) or options.rubber != AUTO:
        return design_actuator(requirements_of(options, _rubber(options)), options.name), []
    rubbers = [chosen_rubber(name, None, None, None) for name in load_rubbers()]
    ranking = rank_rubbers(requirements_of(options, rubbers[0]), rubbers)
    best = ranking[0][1]
    if isinstance(best, RequirementError):
        raise best
    return design_actuator(best.requirements, options.name), ranking


def _rubber(options: argparse.Namespace) -> Rubber:
    return chosen_rubber(options.rubber, options.modulus, options.max_stretch, options.density)


def requirements_of(options: argparse.Namespace, rubber: Rubber) -> Requirements:
    """The requirements in SI units."""
    if _one_wall(options):
        ratio, stiffness, length = (_needed(options, name) for name in NUMBERS)
        length = _size("length", length, LENGTH)
        given = {name: getattr(options, name) for name in FIXED}
        sizes = {n: _size(n, size, FIXED[n]) for n, size in given.items() if size is not None}
        tip = (options.tip_stiffness or 0.0) * MILLI
        return of_numbers(ratio / KILO, stiffness * MILLI, length, rubber, tip, **sizes)
    length, radius = _line(options)
    given_ratio = options.ratio_profile or _needed(options, "ratio")
    aspect = "1" if options.aspect is None else options.aspect
    return Requirements(
        _profile("ratio-profile", given_ratio, length, REQUIRED_RATIO, 1.0 / KILO),
        _stiffness(options, length),
        length,
        rubber,
        None if aspect == TAPERS else _profile("aspect", aspect, length, ASPECT, 1.0),
        1.0 if options.side_share is None else within("side-share", options.side_share, SIDE_SHARE),
        _optional("max-curvature", options.max_curvature, REQUIRED_CURVATURE),
        _optional("pressure", options.pressure, LARGEST_PRESSURE, KILO),
        radius,
    )


def _line(options: argparse.Namespace) -> tuple[float, float | None]:
    """Length [m], and radius [m] of an arc."""
    if options.arc_radius is None:
        return _size("length", _needed(options, "length"), LENGTH), None
    radius = _size("arc-radius", options.arc_radius, LENGTH)
    angle = np.radians(within("arc-angle", _needed(options, "arc_angle"), REQUIRED_ANGLE))
    return float(radius * angle), radius


def _needed(options: argparse.Namespace, name: str) -> float:
    value = getattr(options, name)
    if value is None:
        raise ValueError(f"{name.replace('_', '-')}: expected a number, got none")
    return float(value)


def _optional(option: str, value: float | None, bounds: Bounds, unit: float = 1.0) -> float | None:
    return None if value is None else unit * within(option, value, bounds)


def _size(option: str, value: float, bounds: Bounds) -> float:
    """A size [m] from an option [mm], within bounds [m]."""
    return MILLI * within(option, value, Bounds(bounds.low / MILLI, bounds.high / MILLI, "mm"))


def _stiffness(options: argparse.Namespace, length: float) -> Profile:
    """The profile, or the straight line from --stiffness to --tip-stiffness."""
    if options.stiffness_profile:
        return _profile(
            "stiffness-profile", options.stiffness_profile, length, REQUIRED_STIFFNESS, MILLI
        )
    ends = {"stiffness": _needed(options, "stiffness"), "tip-stiffness": options.tip_stiffness or 0}
    values = [MILLI * within(name, end, REQUIRED_STIFFNESS) for name, end in ends.items()]
    return TableProfile((0.0, length), tuple(values))


def _profile(option: str, text: str | float, length: float, bounds: Bounds, unit: float) -> Profile:
    """A profile of an option, in SI units; raises ValueError naming the option."""
    try:
        value, _ = read_yaml(str(text))
    except yaml.YAMLError as reason:
        raise ValueError(f"{option}: expected {FORMS}, got {text}") from reason
    try:
        found = read_profile(Node("", option, value), length / MILLI, bounds, "mm")
    except DocumentError as reason:
        raise ValueError(str(reason).removeprefix(": ")) from reason
    if isinstance(found, TaperedProfile):
        return replace(found, maximum=found.maximum * unit, length=length)
    if isinstance(found, TableProfile):
        x = (*found.x[:-1], length / MILLI)
        return TableProfile(tuple(MILLI * at for at in x), tuple(unit * v for v in found.value))
    return ConstantProfile(unit * float(found(0.0)))


def chosen_rubber(
    name: str, modulus: float | None, max_stretch: float | None, density: float | None
) -> Rubber:
    """A rubber of Table 3.2, or `custom` with a modulus [kPa] and a largest stretch [-]; a density
    [kg/m3] that is given replaces the rubber's own. Raises ValueError with the known names.

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
            f"{missing}: expected a number, as {given} is given and a rubber needs both, got none"
        )
    modulus = within("modulus", modulus, REQUIRED_MODULUS)
    max_stretch = within("max-stretch", max_stretch, REQUIRED_STRETCH)
    return Rubber("custom", "", "", max_stretch, modulus * KILO, found.density)
