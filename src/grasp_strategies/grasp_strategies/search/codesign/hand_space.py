"""Numbers that shape a hand: RBO Hand 2 with other fingers, palm and thumb, as a hand's file.

A pure function from numbers to YAML; the shipped hand comes out at the shipped numbers. What cannot
be built is refused with its reason: walls that leave no chamber, fingers that overlap, a hand too
heavy (ours; the mould of an actuator is checked by `hand mould`).
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import yaml

from softhand_model.documents.yaml_document import Node, data_file
from softhand_model.hand.actuator import Actuator, load_actuator, own_actuators
from softhand_model.hand.rubber import Rubber, load_rubbers
from softhand_model.hand.sizing import LEAST_TIP_HEIGHT, pressure_limit

HAND = "rbo_hand_2"
RUBBER = "Dragon Skin 10"
FINGERS = ("little", "ring", "middle", "index")  # in the order of their places across the hand
HEAVIEST = 0.250  # [kg]
BESIDE = {"plate": 0.008, "sheet": 0.018}  # by which they are wider than the fingers' middles [m]


@dataclass(frozen=True)
class Range:
    """Lowest and highest value of a number, and the shipped one, in SI units."""

    low: float
    high: float
    shipped: float


HAND_SPACE = {
    "finger_wall": Range(1.5e-3, 3.5e-3, 2.0e-3),
    "finger_height": Range(16e-3, 26e-3, 20e-3),  # and width, at the base
    "finger_length": Range(70e-3, 110e-3, 90e-3),
    "taper_exponent": Range(1.0 / 6.0, 1.0 / 2.0, 1.0 / 3.0),  # of height and circumference
    "spread": Range(20e-3, 28e-3, 24e-3),  # from finger to finger
    "thumb_angle": Range(np.radians(30.0), np.radians(70.0), np.radians(50.0)),
    "palm_walls": Range(1.2, 2.2, 5.76 / 3.46),  # wall of the outer arc over that of the inner
}


class InfeasibleHand(ValueError):
    """Numbers of which no hand can be built."""


def shipped(space: Mapping[str, Range]) -> dict[str, float]:
    """The shipped numbers of a space."""
    return {name: float(one.shipped) for name, one in space.items()}


def completed(space: Mapping[str, Range], values: Mapping[str, float]) -> dict[str, float]:
    """All numbers of a space: the given ones, and the shipped ones for the rest.

    Raises ValueError for one outside of its range.
    """
    given = shipped(space) | {k: float(v) for k, v in values.items() if k in space}
    for name, value in given.items():
        low, high = space[name].low, space[name].high
        if not low <= value <= high:
            raise ValueError(f"{name}: expected {low:.4g} to {high:.4g}, got {value:.4g}")
    return given


def hand_text(values: Mapping[str, float]) -> str:
    """The hand's file for these numbers; those that are not named are the shipped ones, and those
    of other spaces are left out.

    Raises InfeasibleHand with the reason, ValueError for a number outside of its range.
    """
    given = completed(HAND_SPACE, values)
    document, changed = copy.deepcopy(_hand()), _types(given)
    _refuse(given, changed)
    document["types"] = changed
    document["mass"] = _mass(document, changed)
    _refuse_mass(document["mass"])
    _place(document, given)
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


@lru_cache(maxsize=1)
def _hand() -> dict[str, Any]:
    text = data_file("hands", f"{HAND}.yaml").read_text(encoding="utf-8")
    found: dict[str, Any] = yaml.safe_load(text)
    return found


@lru_cache(maxsize=1)
def _entries() -> dict[str, Any]:
    text = data_file("actuators.yaml").read_text(encoding="utf-8")
    found: dict[str, Any] = yaml.safe_load(text)["actuators"]
    return found


def _types(given: Mapping[str, float]) -> dict[str, Any]:
    """Entries of the actuators that are not the shipped ones, with their pressure limits."""
    finger = copy.deepcopy(_entries()["P10.finger"])
    root = 1.0 / given["taper_exponent"]
    finger |= {"length": given["finger_length"], "wall": given["finger_wall"]}
    finger["side_wall"] = given["finger_wall"]
    for key, sides in (("height", 1.0), ("width", 1.0), ("circumference", 4.0)):
        finger[key]["maximum"] = sides * given["finger_height"]
    for key in ("height", "circumference"):
        finger[key]["root"] = root
    outer = copy.deepcopy(_entries()["P10.PalmOuter"])
    outer["wall"] = given["palm_walls"] * float(_entries()["P10.PalmInner"]["wall"])
    outer["side_wall"] = outer["wall"]
    types = {"finger": (finger, "P10.finger"), "palm_outer": (outer, "P10.PalmOuter")}
    return {name: _limited(name, entry, like) for name, (entry, like) in types.items()}


def _limited(name: str, entry: dict[str, Any], like: str) -> dict[str, Any]:
    """The entry with a pressure limit at which its top is stretched as that of the shipped one."""
    base, rubber = load_actuator(like), _rubber()
    scale = pressure_limit(_actuator(name, entry), rubber) / pressure_limit(base, rubber)
    return entry | {"max_pressure": scale * base.max_pressure}


def _actuator(name: str, entry: Mapping[str, Any]) -> Actuator:
    return own_actuators(Node("numbers", "types", {name: dict(entry)}))[name]


@lru_cache(maxsize=1)
def _rubber() -> Rubber:
    return load_rubbers()[RUBBER]


def _refuse(given: Mapping[str, float], types: Mapping[str, Any]) -> None:
    """Refuse walls that leave no chamber and fingers that overlap."""
    if given["finger_height"] > given["spread"]:
        wide, apart = 1e3 * given["finger_height"], 1e3 * given["spread"]
        raise InfeasibleHand(f"fingers {wide:.3g} mm wide overlap at {apart:.3g} mm")
    for name, entry in types.items():
        actuator = _actuator(name, entry)
        height, _, wall, _ = actuator.sides(actuator.length)
        if height < LEAST_TIP_HEIGHT * wall:  # d < 0.5*h (eq. 3.6) where it is least
            tip, room = 1e3 * float(height), 1e3 * LEAST_TIP_HEIGHT * float(wall)
            raise InfeasibleHand(f"{name}: {tip:.3g} mm high at its tip, {room:.3g} at least")


def _mass(document: Mapping[str, Any], types: Mapping[str, Any]) -> float:
    """The shipped hand's mass [kg] with the rubber that is more or less."""
    likes = {"finger": ("P10.finger", len(FINGERS)), "palm_outer": ("P10.PalmOuter", 1)}
    more = [
        count * (_actuator(name, types[name]).mass - load_actuator(like).mass)
        for name, (like, count) in likes.items()
    ]
    return float(document["mass"] + sum(more))


def _refuse_mass(mass: float) -> None:
    if mass > HEAVIEST:
        raise InfeasibleHand(f"{1e3 * mass:.4g} g, {1e3 * HEAVIEST:g} at most")


def _place(document: dict[str, Any], given: Mapping[str, float]) -> None:
    """Fingers, plate, sheet and thumb where the numbers want them."""
    chains, spread = document["chains"], given["spread"]
    middle = (len(FINGERS) - 1) / 2.0
    for k, name in enumerate(FINGERS):
        chains[name]["actuators"][name]["type"] = "finger"
        chains[name]["mount"]["position"][1] = (k - middle) * spread
    across = (len(FINGERS) - 1) * spread
    document["plate"]["size"][1] = across + BESIDE["plate"]
    document["sheet"]["width"] = across + BESIDE["sheet"]
    chains["palm"]["actuators"]["palm_outer"]["type"] = "palm_outer"
    chains["thumb"]["mount"]["rpy"][2] = -given["thumb_angle"]
