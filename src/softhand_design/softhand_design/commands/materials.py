"""The command `softhand materials`: rubbers and fibres, and which rubber suits an actuator."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from softhand_common.documents.yaml_document import Bounds
from softhand_design.design_rules import useful_stretch
from softhand_design.fibre import griffith_stress, load_fibres, radial_modulus, radial_stretch
from softhand_design.rubber_choice import Build, Choice, choose, demand
from softhand_model.hand.plausible import LENGTH, YOUNGS_MODULUS
from softhand_model.hand.rubber import load_rubbers, suitability_by_tear_strength

ALONE = (
    "Stiffness of the top wall alone, as in eq. 3.8, and heights that are bounds, not builds:\n"
    "side walls make it stiffer, and at the lowest they nearly meet. `softhand hand design` counts "
    "them."
)
SOFT_SILICONE = 0.15  # Young's modulus of Table 3.1 [MPa]
AXIAL_STRETCH = 3.0  # of Table 3.1
MEGA, KILO, MILLI, MICRO = 1e6, 1e3, 1e-3, 1e-6
FINGER_CURVATURE = Bounds(0.1, 1e4, "1/m")
STIFFNESS = Bounds(1e-4, 1e6, "mN m2")
DIAMETER = Bounds(LENGTH.low / MILLI, LENGTH.high / MILLI, "mm")
STRETCH_SHARE = Bounds(0.01, 1.0, "")
STRETCH = Bounds(1.0, 100.0, "")
MODULUS = Bounds(YOUNGS_MODULUS.low / MEGA, YOUNGS_MODULUS.high / MEGA, "MPa")
WIDTH = Bounds(0.1, 1e4, "um")
ENERGY = Bounds(1e-3, 1e6, "J/m2")


def rubber_table(tear_strength: float | None = None) -> str:
    """Table 3.2 with the stretch in use; with a tear strength [Pa] also the index that follows from
    it (eq. 3.11).
    """
    tear = tear_strength is not None
    head = ["rubber", "largest stretch", "in use", "shear modulus [kPa]", "index [kPa^0.25]"]
    rows = []
    for one in load_rubbers().values():
        low, high = useful_stretch(one.max_stretch)
        use = f"to {max(low, 1.0):.2g} or {high:.2g}"
        cells = [one.name, f"{one.max_stretch:g}", use, f"{one.shear_modulus / KILO:g}"]
        cells.append(f"{one.suitability:.1f}")
        if tear_strength is not None:
            cells.append(f"{suitability_by_tear_strength(one.max_stretch, tear_strength):.1f}")
        rows.append(cells)
    return markdown([*head, *(["by tear strength"] if tear else [])], rows)


def fibre_table(rubber: float, share: float, stretch: float) -> str:
    """Table 3.1: stretch across the helix for each fibre, from a rubber's Young's modulus [Pa], the
    share [-] of fibre in the hull, and the axial stretch [-].
    """
    fibres = {"no fibres": 0.0, **load_fibres().moduli}
    rows = []
    for name, modulus in fibres.items():
        radial = radial_modulus(rubber, modulus, share if modulus else 0.0)
        cells = [name, _megapascal(modulus) if modulus else "-", _megapascal(rubber)]
        rows.append([*cells, _megapascal(radial), f"{radial_stretch(stretch, rubber, radial):.3f}"])
    head = ["fibre", "its modulus [MPa]", "E axial [MPa]", "E radial [MPa]", "radial stretch"]
    return markdown(head, rows)


def _megapascal(modulus: float) -> str:
    value = modulus / MEGA
    return f"{value:.0f}" if value >= 10.0 else f"{value:.3g}"


def defect_table(widths: Iterable[float], modulus: float, energy: float | None) -> str:
    """Largest stress of a rubber that contains threads of some widths [m], as a ratio to that with
    the widest thread; in kPa if the surface energy [J/m2] is given (eq. 3.4). `modulus` is Young's
    modulus [Pa].
    """
    found = sorted(widths)
    rows = []
    for width in found:
        ratio = float(np.sqrt(found[-1] / width))
        cells = [f"{width / MICRO:g}", f"{ratio:.3g}"]
        if energy is not None:
            cells.append(f"{griffith_stress(modulus, energy, width) / KILO:.4g}")
        rows.append(cells)
    head = ["width [um]", "stress over that of the widest"]
    return markdown([*head, *(["largest stress [kPa]"] if energy is not None else [])], rows)


def choice_table(choices: Sequence[Choice]) -> str:
    """One row per rubber: its lowest and highest actuator and the one of the wanted height, or why
    the rubber does not suit.
    """
    wanted = choices[0].wanted is not None
    head = ["rubber", "index", "lowest", "highest", *(["of this height"] if wanted else []), ""]
    rows = [
        [
            one.rubber.name,
            f"{one.index:.1f}",
            *([_shown(one.lowest), _shown(one.highest)] if one.suits else ["-", "-"]),
            *([_shown(one.wanted) if one.suits and one.wanted else "-"] if wanted else []),
            one.refused or "suits",
        ]
        for one in choices
    ]
    return markdown(head, rows)


def _shown(build: Build) -> str:
    height, wall = build.height / MILLI, build.wall / MILLI
    share, rubber = build.wall_over_height, build.rubber_per_length / MILLI
    return f"{height:.4g} mm, wall {wall:.3g} mm ({share:.2g}), {rubber:.3g} g/m"


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, its columns as wide as their cells."""
    lines = [list(head), *map(list, rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join(
        "| "
        + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        + " |"
        for line in lines
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="softhand materials", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    number: dict[str, Any] = {"type": float}
    youngs = "Young's modulus of the rubber [MPa] (%(default)s)"
    add = _adder(commands, "table", rubbers, "rubbers and their suitability (Table 3.2)")
    add("--tear-strength", **number, help="of all rubbers [kPa], to add the index by eq. 3.11")
    add = _adder(commands, "fibres", fibres, "how far fibres let the hull grow (Table 3.1)")
    add("--modulus", **number, default=SOFT_SILICONE, help=youngs)
    add("--share", **number, help="share of fibre in the hull's volume [-] (0.02)")
    add("--stretch", **number, default=AXIAL_STRETCH, help="along the actuator [-] (%(default)s)")
    add = _adder(commands, "defect", defects, "stress that a thread in rubber allows (eq. 3.4)")
    add("widths", nargs="*", **number, help="widths of threads [um] (those of the shipped fibres)")
    add("--modulus", **number, default=SOFT_SILICONE, help=youngs)
    add("--surface-energy", **number, help="of the rubber [J/m2], to print the stress in kPa")
    add = _adder(commands, "choose", rubber_for, "which rubber for a curvature and stiffness")
    add("--curvature", **number, required=True, help="largest curvature [1/m]")
    add("--stiffness", **number, required=True, help="bending stiffness [mN m2]")
    add("--diameter", **number, help="height and width of the section [mm] (free)")
    add("--share", **number, default=1.0, help="used share of the largest stretch (%(default)s)")
    add("--json", action="store_true", help="print JSON in SI units in place of the table")
    return parser


def _adder(commands: Any, name: str, run: Any, words: str) -> Any:
    found = commands.add_parser(name, help=words, description=words[0].upper() + words[1:] + ".")
    found.set_defaults(run=run)
    return found.add_argument


def rubbers(options: argparse.Namespace) -> str:
    """Output of the command `table`."""
    strength = options.tear_strength
    if strength is not None:
        strength = KILO * within("tear-strength", strength, Bounds(1.0, 1e6, "kPa"))
    return rubber_table(strength)


def fibres(options: argparse.Namespace) -> str:
    """Output of the command `fibres`."""
    share = load_fibres().share if options.share is None else options.share
    return fibre_table(
        MEGA * within("modulus", options.modulus, MODULUS),
        within("share", share, STRETCH_SHARE),
        within("stretch", options.stretch, STRETCH),
    )


def defects(options: argparse.Namespace) -> str:
    """Output of the command `defect`."""
    used = [thread.width / MICRO for thread in load_fibres().threads.values()]
    widths = [MICRO * within("widths", width, WIDTH) for width in options.widths or used]
    energy = options.surface_energy
    if energy is not None:
        within("surface-energy", energy, ENERGY)
    return defect_table(widths, MEGA * within("modulus", options.modulus, MODULUS), energy)


def rubber_for(options: argparse.Namespace) -> str:
    """Output of the command `choose`; raises ValueError if no rubber suits."""
    curvature = within("curvature", options.curvature, FINGER_CURVATURE)
    stiffness = MILLI * within("stiffness", options.stiffness, STIFFNESS)
    diameter = options.diameter
    if diameter is not None:
        diameter = MILLI * within("diameter", diameter, DIAMETER)
    share = within("share", options.share, STRETCH_SHARE)
    choices = choose(curvature, stiffness, diameter, share)
    needed = demand(curvature, stiffness)
    if options.json:
        found = [asdict(one) | {"suits": one.suits} for one in choices]
        shown = json.dumps({"demand": needed, "choices": found}, indent=2)
    else:
        shown = f"Needed: index above {needed:.3g} kPa^0.25 (eq. 3.9).\n\n{choice_table(choices)}"
        shown += f"\n\n{ALONE}"
    if not any(one.suits for one in choices):
        print(shown)
        best = choices[0]
        raise ValueError(
            f"no rubber suits; {best.rubber.name}, which has the best index: {best.refused}"
        )
    return shown


def within(option: str, value: float, bounds: Bounds) -> float:
    """The value of an option, if it is within bounds; else raises ValueError naming option and
    bounds.
    """
    if not bounds.low <= value <= bounds.high:
        limits = f"{bounds.low:g} to {bounds.high:g} {bounds.unit}".rstrip()
        raise ValueError(f"{option}: expected {limits}, got {value:g}")
    return value


def main(arguments: list[str] | None = None) -> int:
    """Print a table; returns 0, or 2 when options cannot be used or no rubber suits."""
    options = _parser().parse_args(arguments)
    try:
        print(options.run(options))
    except ValueError as error:
        print(f"softhand materials: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
