"""Summary of a sweep: successes by object and variant, why trials failed, where engines differ."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import binomtest

from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from pneuflex_sim.engines import PYBULLET
from softhand_trials.agreement import Agreement
from softhand_trials.sweep.success_map import SuccessMap, map_of
from softhand_trials.sweep.task import Record

ENGINE_PART = "engine="  # of the keys of trials in engines that are compared
REASONS_SHOWN = 3  # most frequent reasons of failures in a summary


def wilson(successes: int, count: int) -> tuple[float, float]:
    """95 % interval of a ratio after Wilson (1927): low and high [-].

    >>> low, high = wilson(8, 10)
    >>> round(low, 4), round(high, 4)
    (0.4902, 0.9433)
    """
    if count == 0:
        return 0.0, 1.0
    found = binomtest(successes, count).proportion_ci(0.95, "wilson")
    return float(found.low), float(found.high)


def group_of(record: Record) -> str:
    """The key of a record without cell and replicate: plan, object and what varies."""
    return str(record["key"]).rsplit("/", 2)[0]


@dataclass(frozen=True)
class Group:
    """Trials of an object and variant, by the `name` that their keys share."""

    name: str
    records: tuple[Record, ...]

    @property
    def gripped(self) -> int:
        """Number of successes."""
        return sum(record.get("outcome") == OUTCOME_GRIPPED for record in self.records)

    @property
    def share(self) -> float:
        """Share of success [-]."""
        return self.gripped / len(self.records)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval (low, high) [-] of the share."""
        return wilson(self.gripped, len(self.records))

    @property
    def failures(self) -> Counter[str]:
        """How many trials failed, by cause."""
        return Counter(_failure(r) for r in self.records if r.get("outcome") != OUTCOME_GRIPPED)

    @property
    def contacts(self) -> dict[str, float] | None:
        """Mean of each figure of `Adaptability` over the successes whose records have contacts, and
        the share of these that is force-closed [-]; None if there are no such successes.
        """
        found = [record["contacts"] for record in self.records if record.get("contacts")]
        if not found:
            return None
        means = {name: float(np.mean([each[name] for each in found])) for name in found[0]}
        return means | {"force_closed": float(np.mean([each["margin"] > 0.0 for each in found]))}

    @cached_property
    def map(self) -> SuccessMap | None:
        """The success map of the group; None unless its cells are a grid."""
        return map_of(self.records)


def groups_of(records: Iterable[Record]) -> list[Group]:
    """Groups in the order of their first trials."""
    found: dict[str, list[Record]] = {}
    for record in records:
        found.setdefault(group_of(record), []).append(record)
    return [Group(name, tuple(chosen)) for name, chosen in found.items()]


def agreements(records: Iterable[Record]) -> list[Agreement]:
    """Verdicts of the trials that several engines ran, by object and variant; empty for results of
    one engine.
    """
    records, groups = list(records), dict[str, dict[str, dict[str, Record]]]()
    engines = tuple(dict.fromkeys(map(_engine, records)))
    if len(engines) < 2:
        return []
    for record in records:
        parts = [part for part in record["key"].split("/") if not part.startswith(ENGINE_PART)]
        name, trial = "/".join(parts[:-2]), "/".join(parts[-2:])
        groups.setdefault(name, {}).setdefault(trial, {})[_engine(record)] = record
    return [_agreement(name, engines, trials) for name, trials in groups.items()]


def _engine(record: Record) -> str:
    return str(record.get("settings", {}).get("engine", PYBULLET))


def _agreement(
    name: str, engines: tuple[str, ...], trials: Mapping[str, Mapping[str, Record]]
) -> Agreement:
    errors = [
        f"{engine}: {record['error']}"
        for found in trials.values()
        for engine, record in found.items()
        if "error" in record
    ]
    judged = {
        trial: {engine: r["outcome"] for engine, r in found.items() if "error" not in r}
        for trial, found in trials.items()
    }
    verdicts = {
        trial: tuple(found[engine] == OUTCOME_GRIPPED for engine in engines)
        for trial, found in judged.items()
        if len(found) == len(engines)
    }
    return Agreement(name, engines, verdicts, errors[0] if errors else "")


def codes_of(records: Iterable[Record]) -> list[str]:
    """Digests of the versions of the code that ran the trials."""
    return sorted({record["versions"]["code"] for record in records if "versions" in record})


def summary(records: Iterable[Record]) -> str:
    """Text that says how many trials gripped the object, for each object and variant of the
    strategy, with the 95 % confidence interval of the rate, and the most frequent failures.
    """
    records, lines = list(records), []
    for group in groups_of(records):
        low, high = (100 * end for end in group.interval)
        count = f"{group.gripped} of {len(group.records)} gripped"
        lines.append(f"{group.name}: {count} ({low:.0f} to {high:.0f} %)")
        commonest = group.failures.most_common(REASONS_SHOWN)
        lines += [f"    {count} x {failure}" for failure, count in commonest]
    lines += [f"{both.name}, engines: {both.text}" for both in agreements(records)]
    if len(codes := codes_of(records)) > 1:
        lines.append(f"run by {len(codes)} different states of the code: {', '.join(codes)}")
    return "\n".join(lines)


def _failure(record: Record) -> str:
    if "error" in record:
        return str(record["error"])
    if record.get("cause"):
        return f"{record['cause']} in {record['phase']}"
    return str(record["outcome"])
