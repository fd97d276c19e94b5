"""Statistics of held-out success over seeds: intervals, and the conclusion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from thesis.co_design.arms import CO_DESIGN, SINGLE
from thesis.co_design.plan import CONFIDENCE

Shares = Mapping[str, Sequence[float]]  # held-out success [-] at each seed, by arm


class Interval(NamedTuple):
    """A mean over seeds and its interval."""

    mean: float
    low: float
    high: float

    def points(self) -> str:
        """In percentage points.

        >>> Interval(0.1, -0.02, 0.22).points()
        '+10 points (-2 to +22)'
        """
        mean, low, high = (100.0 * value for value in self)
        return f"{mean:+.0f} points ({low:+.0f} to {high:+.0f})"

    def share(self) -> str:
        """As a share; the interval is clipped to 0 and 100 %.

        >>> Interval(0.9, 0.75, 1.05).share()
        '90 % (75 to 100)'
        """
        low, high = np.clip(self[1:], 0.0, 1.0)
        return f"{100 * self.mean:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def interval(values: Sequence[float]) -> Interval:
    """Mean and Student's interval of CONFIDENCE; the interval of a single value is infinite.

    >>> [round(float(end), 3) for end in interval([0.4, 0.5, 0.6])]
    [0.5, 0.252, 0.748]
    """
    given = np.asarray(values, float)
    mean = float(given.mean())
    if len(given) < 2:
        return Interval(mean, -np.inf, np.inf)
    half = student.ppf(0.5 + CONFIDENCE / 2.0, len(given) - 1)
    half *= given.std(ddof=1) / np.sqrt(len(given))
    return Interval(mean, mean - float(half), mean + float(half))


def gain(shares: Shares, other: str, arm: str = CO_DESIGN.name) -> Interval:
    """Difference of an arm's success from another's, seed by seed."""
    pairs = zip(shares[arm], shares[other], strict=True)
    return interval([one - two for one, two in pairs])


def helps(shares: Shares) -> bool:
    """Whether co-design is better than both single arms by intervals above 0."""
    return all(gain(shares, arm.name).low > 0.0 for arm in SINGLE)


def sentence(shares: Shares, budget: int) -> str:
    """The conclusion, in one sentence."""
    verdict = "helps" if helps(shares) else "was not shown to help"
    better = [arm.name for arm in SINGLE if gain(shares, arm.name).high < 0.0]
    worse = f" It was worse than {' and '.join(better)} alone." if better else ""
    gains = ", ".join(f"{gain(shares, arm.name).points()} over {arm.name} alone" for arm in SINGLE)
    return (
        f"Co-design {verdict} at this budget ({budget:,} trials a search, "
        f"{len(shares[CO_DESIGN.name])} seeds): held-out success {gains}.{worse}"
    )
