"""What came out of a sweep: successes by object and variant, why trials failed, how fast it was."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from scipy.stats import binomtest

from grasp_strategies.judge import GRIPPED
from grasp_strategies.sweep.trial_line import Record

COMMONEST = 3  # reasons of failures that a summary shows


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
    """A key without its cell and replicate: plan, object and what varies."""
    return str(record["key"]).rsplit("/", 2)[0]


def summary(records: Iterable[Record]) -> str:
    """Successes with their interval by object and variant, and the commonest failures."""
    records = list(records)
    lines = []
    for group in dict.fromkeys(map(group_of, records)):
        chosen = [record for record in records if group_of(record) == group]
        held = sum(record.get("outcome") == GRIPPED for record in chosen)
        low, high = wilson(held, len(chosen))
        lines.append(
            f"{group}: {held} of {len(chosen)} gripped ({100 * low:.0f} to {100 * high:.0f} %)"
        )
        lines += [f"    {count} x {failure}" for failure, count in _failures(chosen)]
    codes = {record["versions"]["code"] for record in records if "versions" in record}
    if len(codes) > 1:
        lines.append(
            f"run by {len(codes)} different states of the code: {', '.join(sorted(codes))}"
        )
    return "\n".join(lines)


def _failures(records: list[Record]) -> list[tuple[str, int]]:
    failed = (record for record in records if record.get("outcome") != GRIPPED)
    return Counter(map(_failure, failed)).most_common(COMMONEST)


def _failure(record: Record) -> str:
    if "error" in record:
        return str(record["error"])
    if record.get("cause"):
        return f"{record['cause']} in {record['phase']}"
    return str(record["outcome"])
