"""Inverse design: shipped actuators from their own profiles, arcs of the palm, refusals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from bench.design.requests import feasible, requests
from bench.row import at_least, at_most, stated
from softhand_design.commands.design import USUAL_RUBBER, chosen_rubber
from softhand_design.design_rules import allowed
from softhand_design.limits import cast_stiffness
from softhand_design.mould.parts import check_room
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_design.sizing import Design, design_actuator
from softhand_model.hand.actuator import Actuator, load_actuator
from softhand_model.hand.profile import ConstantProfile, TableProfile
from softhand_model.hand.rubber import Rubber

TAKES = "seconds"
SHIPPED = ("P5", "P10.finger", "P10.thumb", "P10.PalmInner", "P10.PalmOuter")
COUNTS = 1e-3  # of the largest stiffness; the tip of P10 has none
TOO_MUCH = 10.0  # times a feasible ratio
WITHIN = 1e-3  # of a bound, by which less would not do


def run(count: int = 20, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    rubber = chosen_rubber(USUAL_RUBBER, None, None, None)
    of_random = [*_refusals(count, seed), *_as_cast(count, seed)]
    return [*_round_trips(rubber), *_arcs(rubber), *_p5(rubber), *of_random]


def _again(shipped: Actuator, rubber: Rubber, pressure: float | None = None) -> Design:
    """An actuator designed anew from its own profiles."""
    ratio, stiffness = shipped.actuation_ratio, shipped.stiffness
    return design_actuator(
        Requirements(ratio, stiffness, shipped.length, rubber, pressure=pressure)
    )


def _round_trips(rubber: Rubber) -> Iterator[dict[str, Any]]:
    wall, around, profiles = 0.0, 0.0, 0.0
    for name in SHIPPED:
        shipped = load_actuator(name)
        found = _again(shipped, rubber).actuator
        x = np.linspace(0.0, shipped.length, 500)
        counts = shipped.stiffness(x) >= COUNTS * shipped.stiffness(0.0)
        wall = max(wall, _off(found.wall(x), shipped.wall(x)))
        largest = [actuator.circumference(x).max() for actuator in (found, shipped)]
        around = max(around, _off(*largest))
        for key in ("height", "width", "actuation_ratio"):
            profiles = max(profiles, _off(getattr(found, key)(x), getattr(shipped, key)(x)))
        bent = _off(found.stiffness(x)[counts], shipped.stiffness(x)[counts])
        profiles = max(profiles, bent)
    yield at_most("round trip of five actuators: wall", wall, "%", 0.5)
    yield at_most("the same: largest circumference", around, "%", 0.5)
    yield at_most("the same: height, width, ratio, stiffness", profiles, "%", 1.0)


def _off(found: Any, wanted: Any) -> float:
    """Largest deviation [%]."""
    return 100.0 * float(np.abs(np.asarray(found) / np.asarray(wanted) - 1.0).max())


def _arcs(rubber: Rubber) -> Iterator[dict[str, Any]]:
    """Arcs of the palm with curvatures as the inverse of their radii (7.3)."""
    arcs = [load_actuator(name) for name in SHIPPED[3:]]
    inner = arcs[0]
    printed, solved = [], []
    for arc in arcs:
        radii = float(inner.arc_radius or 1.0) / float(arc.arc_radius or 1.0)
        ratio = radii / (8.0 * inner.shear_modulus * float(inner.wall(0.0)))
        wanted = Requirements(
            ConstantProfile(ratio), arc.stiffness, arc.length, rubber, arc_radius=arc.arc_radius
        )
        found = design_actuator(wanted)
        printed.append(float(found.sizes_without_side_walls(np.zeros(1))[0, 0]))
        solved.append(float(found.actuator.wall(0.0)))
    stated_walls = float(arcs[1].wall(0.0) / inner.wall(0.0))
    off = _off(printed[1] / printed[0], stated_walls)
    yield stated("arcs with kappa ~ 1/r: walls by rule 1 as printed, off 5.76/3.46", off, "%")
    off = _off(solved[1] / solved[0], stated_walls)
    yield at_most("the same as built, with side walls, which the rule leaves out", off, "%", 1.0)


def _p5(rubber: Rubber) -> Iterator[dict[str, Any]]:
    design = _again(load_actuator("P5"), rubber, pressure=210e3)
    told = [broken for broken in design.broken if broken.rule == "of the model"]
    yield at_least("P5 at 210 kPa: warned of its stretch", len(told), "", 1)
    yield stated("its stretch", told[0].value if told else 1.0, "")


def _refusals(count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Infeasible requests of one ratio, and that the bound would do as it is printed and less would
    not; whether what it gives can be cast.
    """
    would_do, refused, room = 0, 0, 0
    for wanted in islice(requests(seed), count):
        middle = float(wanted.ratio(wanted.length / 2.0))
        for factor in (TOO_MUCH, 1.0 / TOO_MUCH):
            beyond = _even(wanted, factor * middle)
            try:
                design_actuator(beyond)
            except RequirementError as reason:
                refused += 1
                would_do += _is_bound(beyond, reason)
                room += _does(_even(wanted, _printed(reason)), cast=True)
    yield at_least("infeasible requests that are refused", refused, "", 2 * count)
    yield at_least("of these, whose bound would do, and no less", would_do, "", refused)
    yield at_least("of these, designs at the bound whose mould has room", room, "", refused)


def _even(wanted: Requirements, ratio: float) -> Requirements:
    x = stations(wanted.length)[[0, -1]]
    return replace(wanted, ratio=TableProfile(tuple(x), (ratio, ratio)))


def _is_bound(wanted: Requirements, reason: RequirementError) -> bool:
    """Whether the bound on the ratio does, and a little less of it does not."""
    bound = _printed(reason)
    less = bound * (1.0 - WITHIN if bound > reason.got else 1.0 + WITHIN)
    return _does(_even(wanted, bound)) and not _does(_even(wanted, less))


def _printed(reason: RequirementError) -> float:
    return allowed(reason.bound, reason.expected)


def _does(wanted: Requirements, cast: bool = False) -> bool:
    """Whether there is a design, with room for its chamber in a mould if it is to be cast."""
    try:
        actuator = design_actuator(wanted).actuator
        if cast:
            check_room(actuator)
    except ValueError:
        return False
    return True


def _as_cast(count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Stiffness of the sections that are cast against the requirements, at all stations."""
    off: dict[bool, list[float]] = {True: [], False: []}
    for design in feasible(count, seed):
        x = stations(design.requirements.length)
        reached = cast_stiffness(design.actuator, x)
        off[design.requirements.aspect is not None].append(
            _off(reached, design.requirements.stiffness(x))
        )
    for given, found in off.items():
        what = "with an aspect" if given else "with the tapers of P10"
        name = f"stiffness as cast, {len(found)} requests {what}: furthest off"
        yield at_most(name, max(found, default=0.0), "%", 2.0)
