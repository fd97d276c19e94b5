"""Moulds of the shipped actuators and of random designs: `python -m bench.moulds`.

Designs are drawn by actuation ratio, stiffness and length; wishes that the rules refuse are drawn
again. What passes all checks of `softhand_design.mould.checks` counts.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from bench.row import at_least, at_most, stated
from softhand_design.commands.design import USUAL_RUBBER, chosen_rubber
from softhand_design.mould.report import CheckedMould, make_mould, refusal
from softhand_design.requirements import of_numbers
from softhand_design.sizing import design_actuator
from softhand_model.hand.actuator import Actuator, load_actuator

SHIPPED = ("P5", "P10.finger", "P10.thumb", "P10.PalmInner", "P10.PalmOuter")
SLOWEST = 30.0  # of a mould on one core [s]


def random_actuators(count: int, seed: int = 0) -> Iterator[Actuator]:
    """Feasible designs; every fourth is bent to an arc in the plane of its passive layer."""
    random = np.random.default_rng(seed)
    rubber = chosen_rubber(USUAL_RUBBER, None, None, None)
    found = 0
    while found < count:
        ratio, stiffness, length = random.uniform((0.4e-3, 2e-3, 0.06), (1.2e-3, 8e-3, 0.11))
        tip = stiffness * random.uniform(0.0, 0.5)
        try:
            wanted = of_numbers(ratio, stiffness, length, rubber, tip)
            made = design_actuator(wanted, f"random_{found}")
        except ValueError:
            continue
        found += 1
        actuator = made.actuator
        if found % 4 == 0:
            angle = random.uniform(0.5, 1.5)
            actuator = replace(actuator, arc_radius=length / angle, arc_angle=angle)
        yield actuator


def rows(count: int) -> Iterator[dict[str, Any]]:
    """Figures of all moulds."""
    actuators = [*map(load_actuator, SHIPPED), *random_actuators(count)]
    passed, slowest, off, chamber = 0, 0.0, 0.0, 0.0
    for actuator in actuators:
        start = time.process_time()
        made = _made(actuator)
        slowest = max(slowest, time.process_time() - start)
        if made is None:
            continue
        passed += not made.failed
        off = max(off, abs(100.0 * (made.volumes.measured / made.volumes.expected - 1.0)))
        chamber = made.volumes.chamber / 1e3 if actuator.name == "P5" else chamber
    yield at_least(f"moulds that pass, of {len(actuators)}", passed, "", len(actuators))
    yield at_most("rubber furthest off the corrected model", off, "%", 1.0)
    yield at_most("slowest mould, processor time", slowest, "s", SLOWEST)
    yield stated("chamber of P5 (ideal 2.16, stated 1.6)", chamber, "cm3")


def _made(actuator: Actuator) -> CheckedMould | None:
    """The mould, or None where there is no room for one; says which failed and why."""
    try:
        made = make_mould(actuator)
    except ValueError as reason:
        print(f"{actuator.name}: {reason}", flush=True)
        return None
    print(refusal(made) if made.failed else f"{actuator.name}: passed", flush=True)
    return made


def main(arguments: list[str] | None = None) -> int:
    """Print all rows; 0 when all targets are met, else 1."""
    parser = argparse.ArgumentParser(prog="python -m bench.moulds", description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="random designs (%(default)s)")
    found = list(rows(parser.parse_args(arguments).count))
    for row in found:
        print(f"{row['name']:<50}{row['value']:>10.4g} {row['unit']:<5}{row['target'] or ''}")
    return 0 if all(row["met"] is not False for row in found) else 1


if __name__ == "__main__":
    sys.exit(main())
