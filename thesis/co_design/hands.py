"""Hands described by seven numbers: RBO Hand 2 with other fingers, spread, thumb and palm.

The ranges are our choice. A hand is an ordinary YAML file: `softhand hand show` and `softhand hand
mould` open what `hand_text` returns. With the numbers SHIPPED it is RBO Hand 2.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import yaml

from softhand_common.documents.yaml_document import Node
from softhand_design.castable import LARGEST_TAPER
from softhand_design.commands.design import USUAL_RUBBER, chosen_rubber
from softhand_design.limits import pressure_limit
from softhand_design.mould.parts import check_room
from softhand_model.data_files import data_file
from softhand_model.hand.actuator import Actuator, load_actuator, own_actuators
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_trials.search import Variable

BASE = "rbo_hand_2"
VARIABLES = (
    Variable("finger_wall", 1.5e-3, 3.5e-3),  # top and side walls of the four fingers [m]
    Variable("finger_height", 0.016, 0.026),  # at the base, and the width there [m]
    Variable("finger_length", 0.070, 0.110),  # [m]
    Variable("taper", 1 / 6, 1 / 2),  # exponent of height and circumference along the finger [-]
    Variable("spread", 0.020, 0.028),  # between neighbouring fingers [m]
    Variable("thumb_angle", 0.52, 1.22),  # of the thumb's mount on the palm [rad]
    Variable("palm_wall_ratio", 1.2, 2.2),  # outer over inner arc [-]; 5.76/3.46 in section 7.3
)
SHIPPED = {
    "finger_wall": 0.002,
    "finger_height": 0.020,
    "finger_length": 0.090,
    "taper": 1 / 3,
    "spread": 0.024,
    "thumb_angle": 0.8726646259971648,
    "palm_wall_ratio": 0.00576 / 0.00346,
}
FINGERS = ("little", "ring", "middle", "index")  # from -y on
FINGER, OUTER = "finger", "palm_outer"  # names of the kinds of actuator that vary
WIDTH_ROOT = 8.0
INNER_WALL = 0.00346  # [m], of P10.PalmInner
SUPPLY_VOLUME = 9.4e-7  # [m3]
BESIDE = {"plate": 0.008, "sheet": 0.018}  # [m] beside the outer fingers' middles, both sides
LIMIT_STEP = 5e3  # [Pa], to which limits are rounded, as the shipped ones are
LARGEST_MASS = 0.250  # of the hand [kg]
LARGEST_WALL = 0.5  # of the height (eq. 3.6)
DIGITS = 9


def hand_text(values: Mapping[str, float], name: str = "designed_hand") -> str:
    """YAML of the format softhand-hand/1 of a hand with these numbers."""
    return yaml.safe_dump(_hand(values, name), sort_keys=False, default_flow_style=None)


def broken(values: Mapping[str, float]) -> list[str]:
    """Constraints that a hand violates, as sentences; empty for one that can be built and cast.

    Cheap: nothing is meshed. `bench.design` measures whether the moulds of hands that pass this
    check pass their own checks.
    """
    return list(_broken(values))


def _broken(values: Mapping[str, float]) -> Iterator[str]:
    tip = values["finger_height"] * (1.0 - LARGEST_TAPER) ** values["taper"]
    for what, wall, height in (
        ("the finger's tip", values["finger_wall"], tip),
        ("the outer palm", values["palm_wall_ratio"] * INNER_WALL, _outer_height()),
    ):
        if wall >= LARGEST_WALL * height:
            yield f"wall: below half the height of {what}, {1e3 * height:.3g} mm"
    if values["finger_height"] > values["spread"]:
        yield "spread: fingers side by side need their width"
    mass = _hand(values, "designed_hand")["mass"]
    if mass > LARGEST_MASS:
        yield f"mass: {1e3 * mass:.0f} g"
    for actuator in kinds(values).values():
        try:
            check_room(actuator)
        except ValueError as reason:
            yield f"{actuator.name}: {reason}"


def kinds(values: Mapping[str, float]) -> dict[str, Actuator]:
    """The kinds of actuator that vary, by name; all others are shipped."""
    return own_actuators(Node(BASE, "types", _types(values)))


def _types(values: Mapping[str, float]) -> dict[str, Any]:
    wall, height = _rounded(values["finger_wall"]), _rounded(values["finger_height"])
    root, palm_wall = 1.0 / values["taper"], values["palm_wall_ratio"] * INNER_WALL
    finger = {
        "length": _rounded(values["finger_length"]),
        "height": {"maximum": height, "taper": LARGEST_TAPER, "root": _rounded(root)},
        "width": {"maximum": height, "taper": LARGEST_TAPER, "root": WIDTH_ROOT},
        "circumference": {"maximum": 4.0 * height, "taper": 1.0, "root": _rounded(root)},
        "wall": wall,
        "side_wall": wall,
        "supply_volume": SUPPLY_VOLUME,
    }
    outer = _shipped_outer() | dict.fromkeys(("wall", "side_wall"), _rounded(palm_wall))
    return {name: _limited(name, entry) for name, entry in ((FINGER, finger), (OUTER, outer))}


def _limited(name: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry with its pressure limit: the pressure that stretches the top to 0.3 of what the
    rubber bears, rounded to LIMIT_STEP.
    """
    entry = dict(entry) | {"max_pressure": LIMIT_STEP}
    (actuator,) = own_actuators(Node(BASE, "types", {name: entry})).values()
    rubber = chosen_rubber(USUAL_RUBBER, None, None, None)
    steps = max(1, round(pressure_limit(actuator, rubber) / LIMIT_STEP))
    return entry | {"max_pressure": steps * LIMIT_STEP}


def _rounded(value: float) -> float:
    return round(float(value), DIGITS)


def _hand(values: Mapping[str, float], name: str) -> dict[str, Any]:
    """The document of a hand, based on that of the shipped one."""
    hand = copy.deepcopy(_base()) | {"name": name, "types": _types(values)}
    chains, spread = hand["chains"], values["spread"]
    for number, finger in enumerate(FINGERS):
        chain = chains[finger]
        chain["actuators"][finger]["type"] = FINGER
        chain["mount"]["position"][1] = _rounded((number - 1.5) * spread)
    chains["palm"]["actuators"]["palm_outer"]["type"] = OUTER
    chains["thumb"]["mount"]["rpy"][2] = -values["thumb_angle"]
    hand["plate"]["size"][1] = _rounded(3.0 * spread + BESIDE["plate"])
    hand["sheet"]["width"] = _rounded(3.0 * spread + BESIDE["sheet"])
    hand["mass"] = _rounded(_shipped_rest() + _actuators_mass(kinds(values)))
    return hand


def _actuators_mass(found: Mapping[str, Actuator]) -> float:
    return len(FINGERS) * found[FINGER].mass + found[OUTER].mass


@lru_cache(maxsize=1)
def _shipped_rest() -> float:
    """Mass [kg] of the parts of the shipped hand that do not vary."""
    shipped = {FINGER: load_actuator("P10.finger"), OUTER: load_actuator("P10.PalmOuter")}
    return load_hand(BASE).mass - _actuators_mass(shipped)


@lru_cache(maxsize=1)
def _base() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load(data_file("hands", f"{BASE}.yaml").read_text("utf-8"))
    return found


@lru_cache(maxsize=1)
def _shipped_outer() -> dict[str, Any]:
    text = data_file("actuators.yaml").read_text("utf-8")
    entry = yaml.safe_load(text)["actuators"]["P10.PalmOuter"]
    return {key: float(value) for key, value in entry.items() if key != "max_pressure"}


@lru_cache(maxsize=1)
def _outer_height() -> float:
    return float(load_actuator("P10.PalmOuter").height(0.0))


def cast_kinds(hand: HandDescription) -> dict[str, Actuator]:
    """The kinds of actuator of a hand that need a mould, by name."""
    parts = [part for chain in hand.chains for part in chain.actuators.values()]
    return {part.name: part for part in parts}
