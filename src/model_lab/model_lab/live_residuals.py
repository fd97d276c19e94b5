"""Residuals of the last seconds, by actuator."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from model_lab.live_prediction import SECOND, Comparison


@dataclass(frozen=True)
class Recent:
    """Residual of one actuator in the window: rms and largest size [rad] of the settled samples,
    and how many samples there were in all and settled.
    """

    rms: float
    largest: float
    samples: int
    settled: int


class ResidualWindow:
    """Keeps the residuals of the last `duration` [s] of the measurement's own time."""

    def __init__(self, actuators: tuple[str, ...], duration: float) -> None:
        self._duration = duration
        self._kept: dict[str, deque[tuple[int, float, bool]]] = {n: deque() for n in actuators}

    def clear(self) -> None:
        """Forget all."""
        for kept in self._kept.values():
            kept.clear()

    def add(self, comparison: Comparison) -> None:
        """Take a comparison that is newer than all before."""
        oldest = comparison.stamp - round(self._duration * SECOND)
        residual, settled = comparison.residual.tolist(), comparison.settled.tolist()
        for name, value, counts in zip(comparison.names, residual, settled, strict=True):
            kept = self._kept[name]
            kept.append((comparison.stamp, value, counts))
            while kept[0][0] < oldest:
                kept.popleft()

    def recent(self, actuator: str) -> Recent:
        """What the window holds of an actuator; rms and largest are 0 without settled samples."""
        kept = self._kept[actuator]
        counted = np.array([value for _, value, settled in kept if settled] or [0.0])
        return Recent(
            float(np.sqrt(np.mean(counted**2))),
            float(np.abs(counted).max()),
            len(kept),
            sum(settled for _, _, settled in kept),
        )
