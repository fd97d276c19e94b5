"""What a hand and its motion are worth: success in simulated grasps of several objects.

Places are drawn by seed, object and number, so that the first ones of a longer run are those of a
shorter one: where the object lies, its mass, the friction of all pairs, and, for each object, the
modulus of the hand's rubber.
"""

from __future__ import annotations

import tempfile
import zlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.search.codesign.hand_space import InfeasibleHand, hand_text
from grasp_strategies.search.codesign.motion_space import strategy_text
from grasp_strategies.search.objective import COST, objective
from grasp_strategies.trials import Placement, StartedScene, TrialSettings

WORST = 0.25  # weight of the worst quarter of the objects
INFEASIBLE = 1.0  # cost of a hand that cannot be built; the worst that can is 0
SPREADS = {"offset": 0.010, "mass": (0.8, 1.2), "friction": (0.9, 1.1), "modulus": (0.95, 1.05)}


@objective
def grasp(values: Mapping[str, float], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Cost of a hand and its motion, less for more success, with all that the trials said.

    Args:
        values: of `HAND_SPACE` and `MOTION_SPACE`; what is missing is shipped.
        settings: `objects`; `places`, numbers [first, last) of places of each object; `seed`;
            `step` [s]; `segments`; `offset` [m] and factors [low, high] `mass`, `friction` and
            `modulus`; `noise`: whether successes are drawn at random in place of grasps, of which
            a search must not make anything.

    Returns:
        `cost`; `successes`, by object a list of 0 and 1; `trials`, how many were run; `causes`, how
        often each reason of a failure came; `infeasible`, why no such hand can be built, or "".
    """
    try:
        hand = hand_text(values)
    except InfeasibleHand as reason:
        return {COST: INFEASIBLE, "successes": {}, "trials": 0, "causes": {}} | {
            "infeasible": str(reason)
        }
    if settings.get("noise", False):
        return _outcome({name: _by_chance(name, values, settings) for name in settings["objects"]})
    with tempfile.TemporaryDirectory() as folder:
        paths = Path(folder) / "hand.yaml", Path(folder) / "strategy.yaml"
        paths[0].write_text(hand, encoding="utf-8")
        paths[1].write_text(strategy_text(values, paths[0].name), encoding="utf-8")
        found = {name: _tried(name, paths[1], settings) for name in settings["objects"]}
    return _outcome(found)


def _outcome(found: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """What is returned, given by object why each trial failed, "" where it did not."""
    successes = {name: [int(not reason) for reason in reasons] for name, reasons in found.items()}
    causes = Counter(reason for reasons in found.values() for reason in reasons if reason)
    return {
        COST: cost_of(successes),
        "successes": successes,
        "trials": sum(len(one) for one in successes.values()),
        "causes": dict(causes),
        "infeasible": "",
    }


def _by_chance(name: str, values: Mapping[str, float], settings: Mapping[str, Any]) -> list[str]:
    seeds = [zlib.crc32(f"{name} {sorted(values.items())}".encode()), *settings["places"]]
    count = settings["places"][1] - settings["places"][0]
    return ["" if won else "chance" for won in np.random.default_rng(seeds).random(count) < 0.5]


def cost_of(successes: Mapping[str, Sequence[int]]) -> float:
    """Mean success and a quarter of that of the worst quarter of the objects, below 0.

    >>> cost_of({"a": [1, 1], "b": [1, 0], "c": [0, 0], "d": [1, 1]})
    -0.625
    """
    rates = np.sort([np.mean(one) for one in successes.values()])
    worst = rates[: max(1, len(rates) // 4)]
    return -float(rates.mean() + WORST * worst.mean())


def _tried(name: str, strategy: Path, settings: Mapping[str, Any]) -> list[str]:
    """Why each trial with an object failed, "" where it did not."""
    drawn = [
        draw(int(settings["seed"]), name, place, settings) for place in range(*settings["places"])
    ]
    started = StartedScene(
        TrialSettings(
            strategy=str(strategy),
            object=name,
            step=float(settings["step"]),
            segments=int(settings["segments"]),
            modulus_scale=modulus_of(int(settings["seed"]), name, settings),
        )
    )
    results = [started.run(placement) for placement in drawn]
    return ["" if result.gripped else result.reason for result in results]


def draw(seed: int, name: str, place: int, settings: Mapping[str, Any]) -> Placement:
    """Placement of an object for a seed and the number of a place."""
    spreads = SPREADS | dict(settings)
    random = np.random.default_rng([seed, zlib.crc32(name.encode()), place])
    x, y = (float(spreads["offset"]) * random.uniform(-1.0, 1.0, 2)).tolist()
    mass, friction = (float(random.uniform(*spreads[key])) for key in ("mass", "friction"))
    return Placement((x, y), mass, friction_scale=friction)


def modulus_of(seed: int, name: str, settings: Mapping[str, Any]) -> float:
    """Factor on the modulus of the hand's rubber in the trials with an object."""
    spreads = SPREADS | dict(settings)
    random = np.random.default_rng([seed, zlib.crc32(name.encode())])
    return float(random.uniform(*spreads["modulus"]))
