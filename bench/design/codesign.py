"""Co-design as it lies in out/codesign: budgets, speed, shrinkage, gain; hands that can be cast."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.row import at_least, at_most, stated
from grasp_strategies.search.codesign.command import FOLDER
from grasp_strategies.search.codesign.hand_space import HAND_SPACE, InfeasibleHand, hand_text
from grasp_strategies.search.codesign.plan import load_plan
from grasp_strategies.search.codesign.run import RESULT, SHIPPED
from pneuflex_sim.mould.report import make_mould, refusal
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import load_hand

TAKES = "two minutes; nothing is searched"
HANDS = 5  # random ones that are cast
RATE, SHRINKAGE = 2000.0, 15.0  # trials a core-hour, points


def run(seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    path = FOLDER / load_plan().name / RESULT
    if not path.is_file():
        print(f"{path} is not there: `softhand codesign` makes it", flush=True)
        return list(_castable(seed))
    return [*_found(json.loads(path.read_text())), *_castable(seed)]


def _found(result: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    winners = result["winners"]
    trials = [one["trials"] for one in winners]
    generation = load_plan().halving.rungs[-1] * load_plan().generation
    yield at_most("trials of an arm and seed, most less least", np.ptp(trials), "", generation)
    yield at_least("trials a core-hour", result["trials_per_core_hour"], "", RATE)
    for arm in dict.fromkeys(one["arm"] for one in winners):
        mean = 100.0 * np.mean([one["held_out"] for one in winners if one["arm"] == arm])
        yield stated(f"held-out success of {arm}", float(mean), "%")
    yield stated(f"held-out success of the {SHIPPED} pair", 100.0 * result["shipped"], "%")
    if result["gain"]:
        yield stated("gain of both over the better single arm", 100.0 * result["gain"]["mean"], "")
    best = max(winners, key=lambda one: one["training"])  # what a search would hand over
    shrunk = 100.0 * (best["training"] - best["held_out"])
    yield at_most("shrinkage of the winner, points", shrunk, "", SHRINKAGE)
    failed = [actuator for actuator in _own(best["values"]) if not _casts(actuator)]
    yield at_most("actuators of the winner that cannot be cast", len(failed), "", 0)


def _castable(seed: int) -> Iterator[dict[str, Any]]:
    """Random hands of the space: each of their own actuators as a mould."""
    random, passed, made = np.random.default_rng(seed), 0, 0
    hands = 0
    while hands < HANDS:
        values = {name: random.uniform(one.low, one.high) for name, one in HAND_SPACE.items()}
        try:
            actuators = _own(values)
        except InfeasibleHand:
            continue
        hands += 1
        made += len(actuators)
        passed += sum(_casts(actuator) for actuator in actuators)
    yield at_least(f"own actuators of {HANDS} random hands that can be cast", passed, "", made)


def _own(values: Mapping[str, float]) -> list[Actuator]:
    """The actuators of a hand that are not shipped ones, each kind once."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hand.yaml"
        path.write_text(hand_text(values), encoding="utf-8")
        hand = load_hand(path)
    kinds = {one.name: one for chain in hand.chains for one in chain.actuators.values()}
    return [actuator for name, actuator in kinds.items() if not name.startswith("P")]


def _casts(actuator: Actuator) -> bool:
    try:
        made = make_mould(actuator)
    except ValueError as reason:
        print(f"{actuator.name}: {reason}", flush=True)
        return False
    if made.failed:
        print(refusal(made), flush=True)
    return not made.failed
