"""Findings of a co-design run, each with its target where there is one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from thesis.co_design.arms import ARMS, CO_DESIGN, NOISE, RANDOM, SHUFFLED, SINGLE
from thesis.co_design.plan import LEAST_CLAIM, LEAST_RANK, LEAST_RATE, MOST_GAIN, MOST_SHRINKAGE
from thesis.co_design.statistics import Interval, gain, interval
from thesis.frame import Finding, Results

SHIPPED_PAIR, BEST = "shipped", "best"
CLUSTER = 2000  # cores, in the thesis
LEAST_RANKED = 5  # designs, for a rank correlation that is judged
Shares = Mapping[str, Sequence[float]]


def findings(results: Results) -> Iterator[Finding]:
    """All of them."""
    shares = shares_of(results)
    yield from _budgets(results)
    yield from _successes(shares, shares_of(results, "training"))
    yield from _gains(shares)
    yield _shrinkage(results)
    yield from _checked(results)
    yield from _controls(results, shares)
    yield from _costs(results["cost"])
    yield _model(results["plan"], sum(s["trials"] > 0 for s in results["searches"].values()))


def shares_of(results: Results, kind: str = "held_out") -> dict[str, list[float]]:
    """Success [-] of each arm's winners at each seed, and of the shipped pair."""
    found: dict[str, list[float]] = {}
    for one in results["searches"].values():
        found.setdefault(one["arm"], []).append(one[kind]["success"])
    return found | {SHIPPED_PAIR: [one[kind]["success"] for one in results[SHIPPED_PAIR]]}


def _budgets(results: Results) -> Iterator[Finding]:
    names = [arm.name for arm in ARMS]
    spent = {one["trials"] for one in results["searches"].values() if one["arm"] in names}
    ours = f"{', '.join(f'{count:,}' for count in sorted(spent))} in each of {len(ARMS)} arms"
    yield Finding("trials a search", "a million a day", ours, spent == {results["budget"]})
    found = [one for one in results["searches"].values() if one["arm"] == CO_DESIGN.name]
    designs, infeasible = (sum(one[key] for one in found) for key in ("designs", "infeasible"))
    ours = f"{designs} tried, {infeasible} besides could not be built or cast"
    yield Finding("hands with motions, co-design", "-", ours)


def _successes(shares: Shares, training: Mapping[str, Sequence[float]]) -> Iterator[Finding]:
    for name, values in shares.items():
        ours = f"{interval(values).share()}, training {100 * np.mean(training[name]):.0f} %"
        yield Finding(f"held-out success, {name}", "-", ours, None, float(np.mean(values)))


def _gains(shares: Shares) -> Iterator[Finding]:
    for other in (*(arm.name for arm in (*SINGLE, RANDOM)), SHIPPED_PAIR):
        ours = gain(shares, other)
        what = f"gain of co-design over {other}, held out"
        yield Finding(what, "argued, not shown", ours.points(), None, ours.mean)


def _shrinkage(results: Results) -> Finding:
    found = [one for one in results["searches"].values() if one["arm"] == CO_DESIGN.name]
    points = 100 * np.mean(
        [one["training"]["success"] - one["held_out"]["success"] for one in found]
    )
    pair = results[SHIPPED_PAIR]
    of_pair = 100 * np.mean(
        [one["training"]["success"] - one["held_out"]["success"] for one in pair]
    )
    ours = (
        f"{points:.0f} points (<= {MOST_SHRINKAGE:g}); of the shipped pair, which was not searched "
        f"for, {of_pair:.0f}"
    )
    met = bool(points <= MOST_SHRINKAGE)
    return Finding("shrinkage from training to held out", "-", ours, met, float(points), "points")


def _checked(results: Results) -> Iterator[Finding]:
    moulds, best = results["moulds"], results[BEST]
    ours = "; ".join(moulds) or f"all pass ({best})"
    yield Finding("moulds of the best hand", "-", ours, not moulds)
    refused = sum(len(one["refused"]) for one in results["searches"].values())
    yield Finding("better designs that cannot be cast, of all searches", "-", str(refused))
    held = results["postures"]
    ours = f"best {held[BEST]} of 6, shipped {held[SHIPPED_PAIR]} of 6"
    yield Finding("postures in which 0.5 kg stays in the hand", "-", ours)
    told = {n: one for n, one in results["searches"].items() if one["arm"] in _true_arms()}
    off = max(abs(one["told"] - one["training"]["score"]) for one in told.values())
    yield Finding("winners' training, run again", "-", f"{off:.2g} off (0)", off == 0.0)
    yield _rank(results["ranked"])
    pair = {name: results["fine"][name]["success"] for name in (BEST, SHIPPED_PAIR)}
    coarse = results["searches"][best]["held_out"]["success"], _pair_at(results, best)
    same = (pair[BEST] - pair[SHIPPED_PAIR]) * (coarse[0] - coarse[1])
    ours = (
        f"best {100 * pair[BEST]:.0f} %, shipped {100 * pair[SHIPPED_PAIR]:.0f} %; at the "
        f"searches' step {100 * coarse[0]:.0f} and {100 * coarse[1]:.0f}"
    )
    met = bool(same > 0.0) if same else None  # a tie has no order
    yield Finding("held out at the fine step: same order", "-", ours, met)


def _true_arms() -> tuple[str, ...]:
    return tuple(arm.name for arm in ARMS)


def _pair_at(results: Results, search: str) -> float:
    """Held-out success of the shipped pair at the seed of a search."""
    number = list(results["plan"]["seeds"]).index(results["searches"][search]["seed"])
    return float(results[SHIPPED_PAIR][number]["held_out"]["success"])


def _rank(ranked: Sequence[Mapping[str, float]]) -> Finding:
    what = f"rank correlation of the best {len(ranked)} with the fine step"
    coarse, fine = ([one[key] for one in ranked] for key in ("coarse", "fine"))
    judged = len(ranked) >= LEAST_RANKED
    if len(set(coarse)) < 2 or len(set(fine)) < 2:
        return Finding(what, "-", "all scores are equal", False if judged else None)
    found = float(spearmanr(coarse, fine).statistic)
    if not judged:
        return Finding(what, "-", f"{found:.2f}; too few to be judged", None, found)
    low, high = _between(found, len(ranked))
    ours = f"{found:.2f} ({low:.2f} to {high:.2f}; >= {LEAST_RANK:g})"
    return Finding(what, "-", ours, found >= LEAST_RANK, found)


def _between(rank: float, count: int) -> tuple[float, float]:
    """Interval of 95 % of a rank correlation, by Fisher's transform with Fieller's variance."""
    half = 1.96 * math.sqrt(1.06 / (count - 3))
    middle = np.arctanh(np.clip(rank, -1.0 + 1e-9, 1.0 - 1e-9))
    return float(np.tanh(middle - half)), float(np.tanh(middle + half))


def _controls(results: Results, shares: Shares) -> Iterator[Finding]:
    for arm in (SHUFFLED, NOISE):
        found = [one for one in results["searches"].values() if one["arm"] == arm.name]
        numbers = [list(results["plan"]["seeds"]).index(one["seed"]) for one in found]
        over = interval(
            [
                share - shares[SHIPPED_PAIR][k]
                for share, k in zip(shares[arm.name], numbers, strict=True)
            ]
        )
        what = f"negative control, {arm.name}: gain over the shipped pair"
        ours = f"{over.points()} (mean <= {100 * MOST_GAIN:g})"
        yield Finding(what, "-", ours, over.mean <= MOST_GAIN, over.mean)
    claim = interval([one["told"] - one["training"]["score"] for one in found])
    ours = f"{_plain(claim)} below what noise told (from {LEAST_CLAIM:g} on)"
    met = claim.mean >= LEAST_CLAIM
    yield Finding("negative control, noise: score, evaluated again", "-", ours, met, claim.mean)


def _plain(found: Interval) -> str:
    return f"{found.mean:.2f} ({found.low:.2f} to {found.high:.2f})"


def _costs(cost: Mapping[str, float]) -> Iterator[Finding]:
    rate = 3600.0 / cost["cpu_time"]
    ours = f"{rate:,.0f} by processor time (>= {LEAST_RATE:,.0f})"
    yield Finding("trials a core-hour", "21", ours, rate >= LEAST_RATE, rate, "1/h")
    ours = (
        f"{cost['trials']:,.0f} trials, {cost['cpu_hours']:.2f} core-hours, {cost['broken']} broken"
    )
    yield Finding("cost of all", "-", ours)


def _model(plan: Mapping[str, Any], searches: int) -> Finding:
    """Model of the utilisation of a cluster if trials took equally long and dispatch no time. A
    rung waits for the one before, so a search has no more simultaneous trials than its widest rung.
    """
    counts = (plan["generation"], *plan["kept"])
    more = np.diff([0, *plan["rungs"]])
    rungs = [count * int(trials) for count, trials in zip(counts, more, strict=True)]
    alone, together = (
        sum(n * rung for rung in rungs)
        / (CLUSTER * sum(math.ceil(n * rung / CLUSTER) for rung in rungs))
        for n in (1, searches)
    )
    ours = (
        f"{100 * alone:.1f} %, as searches run one after the other; {100 * together:.0f} % were "
        f"all {searches} run side by side (a model, not measured)"
    )
    return Finding(f"share of {CLUSTER:,} cores that would be busy", "100 %", ours)
