"""Evaluation of the designs that searches end with: held-out trials, moulds, the fine step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.world import Diverged
from softhand_design.mould.report import make_mould, refusal
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import load_hand
from softhand_trials.sweep.results import Results
from softhand_trials.sweep.run import finish
from softhand_trials.sweep.task import Record
from thesis.chapter_3_and_5.payload import GRASPS, JUDGED_HAND, held_up, kept
from thesis.co_design.halving import Tried, Workers, best_first
from thesis.co_design.hands import cast_kinds
from thesis.co_design.plan import Plan
from thesis.co_design.trials import HAND, SHIPPED, Design, design_of, write_design
from thesis.co_design.worlds import USUAL, score, success, trials_of

PAYLOAD = 0.5  # [kg]
HELD_OUT = 1000  # added to the seed of a search for that of its held-out trials


def first_castable(tried: Iterable[Tried], most: int, folder: Path) -> tuple[Tried, list[str]]:
    """The best design whose moulds pass all checks, written into a folder, and the refusals of
    those before it. A hand that cannot be cast does not count.

    Raises ValueError where there is none.
    """
    refused: list[str] = []
    for one in best_first(tried, most):
        write_design(SHIPPED | dict(one.values), folder)
        reasons = refusals(folder / HAND)
        if not reasons:
            return one, refused
        refused += [f"design {one.number}: {reason}" for reason in reasons]
    raise ValueError(f"no design can be cast: {'; '.join(refused)}")


def refusals(hand: Path) -> list[str]:
    """Why moulds of a hand's actuators fail; empty when all pass."""
    reasons = map(mould_refusal, cast_kinds(load_hand(hand)).values())
    return [reason for reason in reasons if reason]


@lru_cache
def mould_refusal(actuator: Actuator) -> str:
    """Why an actuator's mould fails its checks; empty when it passes."""
    try:
        made = make_mould(actuator)
    except ValueError as reason:
        return str(reason)
    return refusal(made) if made.failed else ""


def judge(
    workers: Workers, name: str, design: Design, seed: int, plan: Plan, results: Results
) -> Any:
    """A design's trials in training and held out, as plain data."""
    kinds = {"training": (plan.training, seed), "held_out": (plan.held_out, seed + HELD_OUT)}
    found = {}
    for kind, (world, world_seed) in kinds.items():
        lines = trials_of(f"{name}/{kind}", design, world, world_seed)
        found[kind] = summary(finish(workers, lines, results, again=False))
    return found


def summary(records: Sequence[Record]) -> dict[str, Any]:
    """Success, score, success by object, and how many trials diverged or ended in an error."""
    names = sorted({record["object"] for record in records})
    return {
        "trials": len(records),
        "success": success(records),
        "score": score(records),
        "objects": {n: success([r for r in records if r["object"] == n]) for n in names},
        "broken": sum(broke(record) for record in records),
    }


def broke(record: Mapping[str, Any]) -> bool:
    """Whether a trial ended in an error or its simulation diverged."""
    return "error" in record or record.get("cause") == "diverged"


def fine_scores(
    workers: Workers, designs: Sequence[Design], seed: int, plan: Plan, results: Results
) -> list[dict[str, float]]:
    """Scores of designs on the same training trials at the searches' step and at the fine one."""
    found = []
    for number, design in enumerate(designs):
        scores = {}
        for what, physics in {"coarse": USUAL, "fine": plan.fine}.items():
            key, numbers = f"fine/{number}/{what}", range(plan.fine_trials)
            lines = trials_of(key, design, plan.training, seed, numbers, physics)
            scores[what] = score(finish(workers, lines, results, again=False))
        found.append(scores)
    return found


def fine_held_out(
    workers: Workers, designs: Mapping[str, Design], seed: int, plan: Plan, results: Results
) -> dict[str, Any]:
    """Designs by name on the held-out trials of a seed at the fine step."""
    found = {}
    for name, design in designs.items():
        key, world_seed = f"fine/held_out/{name}", seed + HELD_OUT
        lines = trials_of(key, design, plan.held_out, world_seed, physics=plan.fine)
        found[name] = summary(finish(workers, lines, results, again=False))
    return found


def postures(hand: Path) -> int:
    """In how many of six postures a hand holds 0.5 kg, as in the experiment `payload`, at pressures
    within its limits; 0 when its simulation diverges.
    """
    usual, limits = GRASPS[JUDGED_HAND], load_hand(hand).max_pressures()
    pressures = tuple(np.minimum(usual.pressures, limits).tolist())
    try:
        found = held_up(replace(usual, hand=str(hand), pressures=pressures), PAYLOAD)
    except Diverged:
        return 0
    return sum(map(kept, found["holds"].values()))


def best_designs(tried: Iterable[Tried], plan: Plan) -> list[Design]:
    """Those that are run at the fine step, the best first."""
    best = best_first(tried, plan.rungs[-1])[: plan.fine_designs]
    return [design_of(one.values) for one in best]
