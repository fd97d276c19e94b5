"""A case: what is hidden in a set, how it is measured, and what a diagnosis may say of it."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hidden.design import ExtraRun
from hidden.laws import Parameters
from hidden.sets import make_set

NOISES = (0.002, 0.006, 0.015)  # over full scale


@dataclass(frozen=True)
class Expected:
    """What is right to say.

    verdict: adequate, effects_missing or unexplained. names: per hidden law the names of the
    catalogue that are its family. tied: names that the data cannot tell apart, all of which must
    come out in one tie (none: no such demand).
    """

    verdict: str
    names: tuple[frozenset[str], ...] = ()
    tied: frozenset[str] = frozenset()


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
            seed=zlib.crc32(self.name.encode()) % 2**20 * 1000 + seed,
            noise=noise,
            ratio=self.ratio,
            **self.options,
            **more,
        )


def visible(truth: Mapping[str, Any]) -> bool:
    """Whether what is hidden shows: each law alone at least twice the floor, or as asked."""
    return all(ratio >= 1.95 for ratio in [*truth["ratios"], truth["ratio"]])
