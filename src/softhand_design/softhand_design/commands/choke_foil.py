"""The command `softhand choke-foil`: the foil that chokes a box of valves, as SVG (4.3)."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from softhand_common.documents.output_file import check_new, write_new
from softhand_design.choke_foil import FoilParameters, foil_drawing, nominal_flow
from softhand_model.pneumatics.parameters import load_pneumatics

FOIL_FILE = Path("out/choke_foil.svg")


def _parser() -> argparse.ArgumentParser:
    found = argparse.ArgumentParser(
        prog="softhand choke-foil",
        description="Draw the choke foil of Fig. 4.5 as SVG [mm]: what a plotter cuts, what a "
        "needle pierces, marks. Foil and holes are the thesis's (0.1 mm PET), the layout is ours: "
        "measure your valves' socket.",
    )
    found.add_argument("-o", "--out", type=Path, default=FOIL_FILE, help="file (%(default)s)")
    found.add_argument("--force", action="store_true", help="overwrite it")
    for entry in fields(FoilParameters):
        found.add_argument(
            f"--{entry.name.replace('_', '-')}",
            type=type(entry.default),
            default=entry.default,
            help=f"{entry.metadata['text']} [{entry.metadata['unit']}] (%(default)s)",
        )
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the drawing and print the flows; returns 0, or 2 for what cannot be drawn."""
    options = _parser().parse_args(arguments)
    try:
        given = FoilParameters(**{e.name: getattr(options, e.name) for e in fields(FoilParameters)})
        check_new(options.out, options.force, (".svg",))
        write_new(options.out, foil_drawing(given), options.force)
    except ValueError as error:
        print(f"softhand choke-foil: {error}", file=sys.stderr)
        return 2
    box = load_pneumatics()
    for side in ("inlet", "outlet"):
        holes, diameter = getattr(given, f"{side}_holes"), getattr(given, f"{side}_diameter")
        flow = nominal_flow(holes, diameter, box)
        print(
            f"{side}: {holes} x {diameter:g} mm, {flow:.3g} slpm from "
            f"{1e-3 * box.supply.pressure:g} kPa to ambient"
        )
    print(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
