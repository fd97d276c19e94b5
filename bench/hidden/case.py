"""One case of the benchmark: what is hidden in a set, how it is measured, what is right to say.

The names seed the sets: a case that is renamed is another set.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.hidden.design import ExtraRun
from bench.hidden.laws.registry import Parameters
from bench.hidden.sets.driven import make_set

NOISES = (0.002, 0.006, 0.015)  # over full scale
LOW_NOISES, FINEST, MIDDLE = NOISES[:2], NOISES[:1], NOISES[1:2]
DRIVEN = ("free_bending", "blocked_tip", "uniaxial")


@dataclass(frozen=True)
class Expected:
    """What is right to say.

    verdict: adequate, effects_missing or unexplained. names: per hidden law the names of the
    catalogue that are its family. tied: names that the data cannot tell apart, all of which must
    come out in one tie (none: no such demand); besides: names that may be in it too.
    """

    verdict: str
    names: tuple[frozenset[str], ...] = ()
    tied: frozenset[str] = frozenset()
    besides: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Case:
    """One case of a row of the benchmark; `ratio` is error before over floor of each law alone."""

    name: str
    row: str
    experiment: str
    hidden: tuple[tuple[str, Parameters], ...]
    expected: Expected
    ratio: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    noises: tuple[float, ...] = NOISES

    def make(
        self, folder: Path, seed: int, noise: float, extra: tuple[ExtraRun, ...] = ()
    ) -> dict[str, Any]:
        """Write the set and return its truth, see `make_set`."""
        more = {"extra": extra} if extra else {}
        return make_set(
            folder,
            self.experiment,
            [(name, dict(parameters)) for name, parameters in self.hidden],
            seed=seed_of(self.name, seed),
            noise=noise,
            ratio=self.ratio,
            **self.options,
            **more,
        )


def seed_of(name: str, seed: int) -> int:
    """Seed of the generator for a named set; below 1000 those that were used while developing."""
    return zlib.crc32(name.encode()) % 2**20 * 1000 + seed


def visible(truth: Mapping[str, Any]) -> bool:
    """Whether what is hidden shows: each law alone at least twice the floor, or as asked."""
    return all(ratio >= 1.95 for ratio in [*truth["ratios"], truth["ratio"]])


ADEQUATE, UNEXPLAINED = Expected("adequate"), Expected("unexplained")


def named(*families: tuple[str, ...]) -> Expected:
    """One effect of each of these families must be named."""
    return Expected("effects_missing", tuple(map(frozenset, families)))


def hidden(*laws: str) -> tuple[tuple[str, Parameters], ...]:
    """Laws by name, with parameters that are drawn."""
    return tuple((law, {}) for law in laws)
