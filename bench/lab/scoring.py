"""Scores of diagnoses: whether each is right, from what was hidden and what may be said."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import Any

Record = Mapping[str, Any]
SECOND_AUTHOR = "second author"  # begins the row of such a set
REAL = "real"  # row of measurements by others
EXTRA_NAMES = 2  # in a tie beside the truth


def groups(answer: Record) -> list[set[str]]:
    """Each named effect with those tied with it.

    >>> groups({"effects": [{"name": "a"}], "tied": [["b"]]}) == [{"a", "b"}]
    True
    """
    tied = answer["tied"] or [[] for _ in answer["effects"]]
    return [
        {effect["name"], *others} for effect, others in zip(answer["effects"], tied, strict=True)
    ]


def right(record: Record) -> bool:
    """Whether the diagnosis of a set says what it should.

    Catalogue and pairs: just the hidden effects, each in its own group of at most three names.
    Other form: the family is named and at most one effect besides. One rate: one group with all
    loops, and nothing besides but the lags. A set by others is judged where it is gathered.
    """
    if "expected" not in record:
        return bool(record["right"])
    answer, expected = record.get("answer"), record["expected"]
    if answer is None or answer["verdict"] != expected["verdict"]:
        return False
    found, wanted = groups(answer), [set(names) for names in expected["names"]]
    if expected["tied"]:
        tied, besides = set(expected["tied"]), set(expected["besides"])
        return len(found) == 1 and tied <= found[0] <= tied | besides
    if record["row"] == "other form":
        return len(found) <= 2 and any(wanted[0] & group and _small(group) for group in found)
    if len(found) != len(wanted):
        return False
    return any(
        all(names & group and _small(group) for names, group in zip(wanted, order, strict=True))
        for order in permutations(found)
    )


def is_guess(record: Record) -> bool:
    """Whether the verdict is said as a guess."""
    answer = record.get("answer")
    return answer is not None and bool(answer.get("guess"))


def refused(record: Record) -> bool:
    """Whether the lab says that it does not know: a guess, or nothing known explains the set."""
    answer = record.get("answer")
    return answer is not None and (is_guess(record) or answer["verdict"] == "unexplained")


def wrong_name(record: Record) -> bool:
    """Whether effects are named and are not the right ones, as a guess or not."""
    answer = record.get("answer")
    return answer is not None and bool(answer["effects"]) and not right(record)


def wrong_alone(record: Record) -> bool:
    """Whether an effect that is none of the hidden ones is named without a tie."""
    if not wrong_name(record):
        return False
    known = {name for names in record["expected"]["names"] for name in names}
    return any(len(group) == 1 and not group & known for group in groups(record["answer"]))


def _small(group: set[str]) -> bool:
    return len(group) <= 1 + EXTRA_NAMES


def after_over_floor(record: Record) -> float | None:
    """Held-out error after adding over the noise floor, where the right effects were named."""
    answer = record.get("answer")
    if answer is None or not right(record) or not answer["noise_floor"]:
        return None
    return float(answer["rmse_after"] / answer["noise_floor"])


def coverage(record: Record) -> list[bool] | None:
    """Per parameter, whether the truth lies in the stated interval; None: not named first."""
    answer, truth = record.get("answer"), record["truth"]["hidden"]
    if answer is None or not right(record):
        return None
    stated = {effect["name"]: effect["parameters"] for effect in answer["effects"]}
    inside = []
    for law in truth:
        for name, value in law["parameters"].items():
            given = stated.get(law["name"], {}).get(name)
            if given is not None:
                low, high = given["interval"]
                inside.append(low <= value <= high)
    return inside or None


def wilson(hits: int, count: int) -> tuple[float, float]:
    """95 % Wilson interval of a rate.

    >>> [round(end, 3) for end in wilson(95, 100)]
    [0.888, 0.978]
    """
    if count == 0:
        return 0.0, 1.0
    z, rate = 1.959964, hits / count
    middle = rate + z**2 / (2 * count)
    half = z * math.sqrt(rate * (1 - rate) / count + z**2 / (4 * count**2))
    below = 1 + z**2 / count
    return (middle - half) / below, (middle + half) / below


def mean_tie(records: Sequence[Record]) -> float:
    """Mean number of names in a group, over all groups that were named."""
    sizes = [len(g) for r in records if r.get("answer") for g in groups(r["answer"])]
    return sum(sizes) / len(sizes) if sizes else 0.0
