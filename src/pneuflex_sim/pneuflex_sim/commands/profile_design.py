"""`softhand hand design` with profiles: actuation ratio and stiffness along the actuator.

Options, table, warnings and errors are in mm, kPa and mN m2; files and JSON in SI units.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pneuflex_sim.commands import design as plain
from pneuflex_sim.commands.design import (
    KILO,
    MILLI,
    bends,
    check_names,
    chosen_rubber,
    in_mm,
    in_options,
    tell,
    within,
)
from pneuflex_sim.commands.materials import markdown
from softhand_model.documents.output_file import PICTURES, check_new
from softhand_model.documents.yaml_document import Bounds, DocumentError, Node
from softhand_model.documents.yaml_reading import read_yaml
from softhand_model.hand.actuator import read_profile
from softhand_model.hand.plausible import LENGTH, PRESSURE
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile, TaperedProfile
from softhand_model.hand.profile_sizing import ProfileDesign, design_by_profiles, rank_rubbers
from softhand_model.hand.profile_wish import ProfileWish, cast_stiffness
from softhand_model.hand.rubber import Rubber, load_rubbers
from softhand_model.hand.sizing import WishError, actuator_entry, profile_entry
from softhand_model.numerics.arrays import Array

AUTO, TAPERS = "auto", "P10"
RATIO = Bounds(1e-4, 1e3, "1/(m kPa)")
STIFFNESS = Bounds(0.0, 1e6, "mN m2")
ASPECT = Bounds(0.1, 10.0, "")
SHARE = Bounds(0.01, 3.0, "")
CURVATURE = Bounds(0.1, 1e4, "1/m")
ANGLE = Bounds(1.0, 360.0, "deg")
ENDS = ("stiffness", "tip-stiffness")
ALONG = (  # options that mean nothing without a profile
    "aspect",
    "side_share",
    "max_curvature",
    "pressure",
    "arc_radius",
    "arc_angle",
    "figure",
)
INSTEAD = {  # options in whose place others would stand
    "ratio_profile": ("ratio",),
    "stiffness_profile": ("stiffness", "tip_stiffness"),
    "length": ("arc_radius", "arc_angle"),
}
SHOWN = 7  # places in the table
FORMS = "a number, [[x, value], ...] with x [mm] from base to tip, or {maximum, taper, root}"
Ranking = list[tuple[Rubber, ProfileDesign | WishError]]


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options of profiles to those of `hand design`."""
    found = parser.add_argument_group("profiles", f"Along the actuator, as text in YAML: {FORMS}.")
    add, number = found.add_argument, {"type": float}
    add("--ratio-profile", metavar="P", help="curvature over pressure [1/(m kPa)]")
    add("--stiffness-profile", metavar="P", help="bending stiffness [mN m2]")
    add("--aspect", metavar="P", help=f"width over height [-] (1), or {TAPERS}: its tapers")
    add("--side-share", **number, help="side wall over wall [-] (1)")
    add("--max-curvature", **number, help="the largest in use [1/m], which sets the pressure limit")
    add("--pressure", **number, help="the largest there is [kPa]")
    add("--arc-radius", **number, help="[mm] in place of --length, of an arc; with --arc-angle")
    add("--arc-angle", **number, help="[deg]")
    add("--figure", type=Path, help="picture of profiles, section and bend to write")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Design, print and write; raises ValueError for wishes that cannot be fulfilled."""
    if options.ratio_profile is None and options.stiffness_profile is None:
        _refuse_given(options, ALONG, "a profile beside it")
        plain.run(options)
        return
    _refuse_given(options, ("wall", "height", "width"), "nothing beside profiles")
    for name, others in INSTEAD.items():
        if getattr(options, name) is not None:
            _refuse_given(options, others, f"none beside {name.replace('_', '-')}")
    if options.rubber == AUTO:
        _refuse_given(options, ("modulus", "max_stretch", "density"), "none beside rubber auto")
    check_names(options)
    if options.figure is not None:
        check_new(options.figure, options.force, PICTURES)
    design, ranking = _designed(options)
    if options.figure is not None:
        from pneuflex_sim.pictures.design_picture import draw_design  # late: matplotlib, an extra

        draw_design(design).savefig(options.figure)
    shown = "\n\n".join([table(design), *([ranking_table(ranking)] if ranking else [])])
    told = record(design) | ({"ranking": _ranked(ranking)} if ranking else {})
    tell(options, design.actuator, _comment(design), told, shown, design.broken)


def _refuse_given(options: argparse.Namespace, names: tuple[str, ...], expected: str) -> None:
    for name in names:
        if getattr(options, name) is not None:
            option = name.replace("_", "-")
            raise ValueError(f"{option}: expected {expected}, got {getattr(options, name)}")


def _designed(options: argparse.Namespace) -> tuple[ProfileDesign, Ranking]:
    """The design, and how the rubbers rank where one is chosen."""
    try:
        if options.rubber != AUTO:
            return design_by_profiles(wish_of(options, _rubber(options)), options.name), []
        rubbers = [chosen_rubber(name, None, None, None) for name in load_rubbers()]
        ranking = rank_rubbers(wish_of(options, rubbers[0]), rubbers)
        best = ranking[0][1]
        if isinstance(best, WishError):
            raise best
        return design_by_profiles(best.wish, options.name), ranking
    except WishError as error:
        raise ValueError(in_options(error)) from error


def _rubber(options: argparse.Namespace) -> Rubber:
    return chosen_rubber(options.rubber, options.modulus, options.max_stretch, options.density)


def wish_of(options: argparse.Namespace, rubber: Rubber) -> ProfileWish:
    """The wish in SI units."""
    length, radius = _line(options)
    ratio = options.ratio_profile or _needed(options, "ratio")
    aspect = "1" if options.aspect is None else options.aspect
    return ProfileWish(
        _profile("ratio-profile", ratio, length, RATIO, 1.0 / KILO),
        _profile("stiffness-profile", options.stiffness_profile, length, STIFFNESS, MILLI)
        if options.stiffness_profile
        else _straight(options, length),
        length,
        rubber,
        None if aspect == TAPERS else _profile("aspect", aspect, length, ASPECT, 1.0),
        1.0 if options.side_share is None else within("side-share", options.side_share, SHARE),
        _optional("max-curvature", options.max_curvature, CURVATURE),
        _optional("pressure", options.pressure, _in_kpa(PRESSURE), KILO),
        radius,
    )


def _line(options: argparse.Namespace) -> tuple[float, float | None]:
    """Length [m], and radius [m] of an arc."""
    if options.arc_radius is None:
        return MILLI * within("length", _needed(options, "length"), in_mm(LENGTH)), None
    radius = MILLI * within("arc-radius", options.arc_radius, in_mm(LENGTH))
    angle = np.radians(within("arc-angle", _needed(options, "arc_angle"), ANGLE))
    return float(radius * angle), radius


def _needed(options: argparse.Namespace, name: str) -> float:
    value = getattr(options, name)
    if value is None:
        raise ValueError(f"{name.replace('_', '-')}: expected a number, got none")
    return float(value)


def _optional(option: str, value: float | None, bounds: Bounds, unit: float = 1.0) -> float | None:
    return None if value is None else unit * within(option, value, bounds)


def _in_kpa(bounds: Bounds) -> Bounds:
    return Bounds(bounds.low / KILO, bounds.high / KILO, "kPa")


def _straight(options: argparse.Namespace, length: float) -> Profile:
    """The straight line from --stiffness to --tip-stiffness."""
    ends = (_needed(options, "stiffness"), options.tip_stiffness or 0.0)
    values = [MILLI * within(name, end, STIFFNESS) for name, end in zip(ENDS, ends, strict=True)]
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


# ---------------------------------------------------------------------- what is told
def table(design: ProfileDesign) -> str:
    """Wanted, reached and sizes at places along the actuator, and the rest of it, with units."""
    wish, actuator = design.wish, design.actuator
    head = ["x [mm]", "ratio [1/(m kPa)]", "reached", "stiffness [mN m2]", "reached", "as cast"]
    head += ["height [mm]", "width", "circumference", "wall", "side wall"]
    head += ["wall as printed", "circumference as printed"]
    rows = [[f"{number:.4g}" for number in row] for row in columns(design, SHOWN).T]
    rest = [
        ("length", f"{actuator.length / MILLI:.4g}", "mm"),
        ("rubber", wish.rubber.name, ""),
        ("shear modulus", f"{actuator.shear_modulus / KILO:.4g}", "kPa"),
        ("mass", f"{actuator.mass / MILLI:.4g}", "g"),
        ("largest pressure", f"{actuator.max_pressure / KILO:.4g}", "kPa"),
        *((name, angle, unit) for name, angle, _, unit in bends(actuator)),
    ]
    lines = [f"{name:<24}{value:>16}  {unit}".rstrip() for name, value, unit in rest]
    return "\n".join([markdown(head, rows), "", *lines])


def columns(design: ProfileDesign, count: int) -> Array:
    """Columns of the table (13, count), in the units of the options."""
    wish, actuator = design.wish, design.actuator
    x = np.linspace(0.0, actuator.length, count)
    printed = [np.interp(x, design.x, size) for size in design.printed]
    ratios = [KILO * profile(x) for profile in (wish.ratio, actuator.actuation_ratio)]
    cast = cast_stiffness(actuator, x)
    stiffness = [b / MILLI for b in (wish.stiffness(x), actuator.stiffness(x), cast)]
    height, width, wall, side_wall = actuator.sides(x)
    sizes = [x, height, width, actuator.circumference(x), wall, side_wall, *printed]
    at, *others = (size / MILLI for size in sizes)
    return np.array([at, *ratios, *stiffness, *others])


def ranking_table(ranking: Ranking) -> str:
    """How the rubbers rank (rule 5): wall at base and tip and mass, or what refuses them."""
    rows = []
    for rubber, found in ranking:
        cells = [rubber.name, f"{rubber.suitability:.1f}"]
        if isinstance(found, WishError):
            rows.append([*cells, "-", "-", in_options(found)])
            continue
        walls = found.actuator.wall(np.array([0.0, found.actuator.length])) / MILLI
        told = "; ".join(f"breaks {broken.rule}" for broken in found.broken)
        shown = " to ".join(f"{wall:.3g}" for wall in walls)
        rows.append([*cells, shown, f"{found.actuator.mass / MILLI:.3g}", told])
    return markdown(["rubber", "index [kPa^0.25]", "wall [mm]", "mass [g]", ""], rows)


def _ranked(ranking: Ranking) -> list[dict[str, Any]]:
    """The same as plain data, SI units."""
    return [
        {"rubber": rubber.name, "index": rubber.suitability}
        | (
            {"refused": str(found)}
            if isinstance(found, WishError)
            else {"mass": found.actuator.mass, "breaks": [b.rule for b in found.broken]}
        )
        for rubber, found in ranking
    ]


def record(design: ProfileDesign) -> dict[str, Any]:
    """The design as plain data, SI units."""
    wish, actuator, x = design.wish, design.actuator, design.x
    pressures = actuator.max_pressure * np.array(plain.SHARES)
    profiles = {"ratio": wish.ratio, "stiffness": wish.stiffness, "aspect": wish.aspect}
    numbers = ("length", "side_share", "curvature", "pressure", "arc_radius")
    return {
        "wish": {
            **{key: None if p is None else profile_entry(p) for key, p in profiles.items()},
            **{key: getattr(wish, key) for key in numbers},
            "rubber": asdict(wish.rubber),
        },
        "stations": {
            "x": x.tolist(),
            "ratio": actuator.actuation_ratio(x).tolist(),
            "stiffness": actuator.stiffness(x).tolist(),
            "printed_wall": design.printed[0].tolist(),
            "printed_circumference": design.printed[1].tolist(),
        },
        "actuator": {"name": actuator.name, **actuator_entry(actuator)},
        "bend": {
            "pressure": pressures.tolist(),
            "tip_angle": actuator.tip_angle(pressures).tolist(),
        },
        "broken_rules": [asdict(broken) | {"text": str(broken)} for broken in design.broken],
    }


def _comment(design: ProfileDesign) -> str:
    wish = design.wish
    return "\n".join(
        [
            "A designed actuator, as a finger on a stand; what stands under `types` is its entry.",
            f"Wanted: actuation ratio [1/(m Pa)] {profile_entry(wish.ratio)}",
            f"and stiffness [N m2] {profile_entry(wish.stiffness)};",
            f"rubber: {wish.rubber.name}, {wish.rubber.density:.4g} kg/m3.",
        ]
    )
