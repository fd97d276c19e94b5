"""Numbers that shape a motion: the grasp of a lying cylinder with RBO Hand 2, as a strategy's file.

The shipped strategy comes out at the shipped numbers, but for the object's heading: these motions
come from one direction, whatever lies there.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import yaml

from grasp_strategies.search.codesign.hand_space import Range, completed
from grasp_strategies.strategy.description import DATA

STRATEGY = "rbo_hand_2_lying_cylinder"
MASSES = {"a": 9.6e-5, "b": 2.7e-5, "c": 6.9e-5, "d": 6.5e-5}  # of the shipped phase `close` [kg]
LEAST_SHARE, MOST_SHARE = 0.4, 1.3  # of these masses
MOTION_SPACE = {
    "approach_x": Range(-0.070, 0.0, -0.045),
    "approach_y": Range(-0.060, 0.0, -0.034),
    "approach_pitch": Range(1.6, 2.6, 2.036),
    "approach_yaw": Range(-0.3, 1.0, 0.45),
    "touch_force": Range(0.8, 4.0, 1.9),
    **{f"mass_{c}": Range(LEAST_SHARE * m, MOST_SHARE * m, m) for c, m in MASSES.items()},
    "ramp": Range(0.4, 2.4, 1.2),  # [s] of the closing
    "order": Range(0.0, 1.5, 1.0),  # of the air that comes first: 0 none, all at once
}


def strategy_text(values: Mapping[str, float], hand: str) -> str:
    """The strategy's file for these numbers and a hand's name or file; those that are not named are
    the shipped ones, and those of other spaces are left out.

    Raises ValueError for a number outside of its range.
    """
    given = completed(MOTION_SPACE, values)
    document = copy.deepcopy(_strategy())
    document["hand"] = hand
    for key in ("object_rpy", "objects", "scene"):
        document.pop(key)
    phases = {phase["name"]: phase for phase in document["phases"]}
    wrist = phases["approach"]["wrist"]
    wrist["position"][:2] = [given["approach_x"], given["approach_y"]]
    wrist["rpy"][1:] = [given["approach_pitch"], given["approach_yaw"]]
    phases["touch"]["until"]["contact_force"]["above"] = given["touch_force"]
    first, close = phases["thumb_first"]["air_mass"], phases["close"]
    for channel, mass in MASSES.items():
        wanted = given[f"mass_{channel}"]
        first[channel] = min(wanted, first[channel] * (given["order"] * wanted / mass))
        close["air_mass"][channel] = wanted
    close["air_ramp"] = given["ramp"]
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


@lru_cache(maxsize=1)
def _strategy() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((DATA / f"{STRATEGY}.yaml").read_text(encoding="utf-8"))
    return found
