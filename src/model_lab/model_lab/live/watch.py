"""Watch over a running hand: residuals of the last seconds, and diagnostic levels (REP 107) for
them.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from model_lab.live.prediction import SECOND, Comparison, LivePrediction
from softhand_common.status import Level, Report

WARNING_PERIOD = (
    10.0  # wall time for which a refused message or a clock set back is worth a word [s]
)
REMINDER = "free bending only: contact shows as residual"
PRESSURE, ANGLE = "pneumaticbox/state", "hand/tip_angles"


@dataclass(frozen=True)
class Recent:
    """Residual of one actuator in the window.

    rms, largest [rad]: root mean square and largest magnitude over the settled samples, those whose
    pressure hardly changed just before. samples, settled: numbers of all and of settled samples.
    """

    rms: float
    largest: float
    samples: int
    settled: int


class ResidualWindow:
    """Keeps the residuals of the last `duration` [s], in the time of the stamps."""

    def __init__(self, actuators: tuple[str, ...], duration: float) -> None:
        self._duration = duration
        self._kept: dict[str, deque[tuple[int, float, bool]]] = {n: deque() for n in actuators}

    def clear(self) -> None:
        """Forget all residuals."""
        for kept in self._kept.values():
            kept.clear()

    def add(self, comparison: Comparison) -> None:
        """Add a comparison whose stamp is later than all before."""
        oldest = comparison.stamp - round(self._duration * SECOND)
        residual, settled = comparison.residual.tolist(), comparison.settled.tolist()
        for name, value, counts in zip(comparison.names, residual, settled, strict=True):
            kept = self._kept[name]
            kept.append((comparison.stamp, value, counts))
            while kept[0][0] < oldest:
                kept.popleft()

    def recent(self, actuator: str) -> Recent:
        """The residual of an actuator in the window; rms and largest are 0 without settled
        samples.
        """
        kept = self._kept[actuator]
        counted = np.array([value for _, value, settled in kept if settled] or [0.0])
        return Recent(
            float(np.sqrt(np.mean(counted**2))),
            float(np.abs(counted).max()),
            len(kept),
            sum(settled for _, _, settled in kept),
        )


@dataclass(frozen=True)
class Limits:
    """When to warn.

    warn_above [rad]: root mean square residual. stale_after [s]: wall time without a comparison.
    """

    warn_above: float
    stale_after: float


@dataclass
class _Event:
    """Something that happened, at a monotonic wall time [s]."""

    text: str = ""
    at: float = -math.inf

    def recent(self, now: float) -> str:
        return self.text if now - self.at < WARNING_PERIOD else ""


class Watch:
    """Records what the monitor has received, and makes its reports.

    Args:
        prediction: source of the comparisons.
        model_name: name of the model file, shown in reports.
        window: duration [s] over which residuals are averaged.
        limits: when to warn.

    Times `now` are monotonic wall times [s].
    """

    def __init__(
        self, prediction: LivePrediction, model_name: str, window: float, limits: Limits
    ) -> None:
        self._prediction, self._model_name, self._limits = prediction, model_name, limits
        self._window = ResidualWindow(prediction.hand.actuator_names, window)
        self._compared: dict[str, float] = {}
        self._heard: dict[str, float] = {}
        self._refused, self._failed, self._set_back = _Event(), _Event(), _Event()
        self._refusals = self._seen_set_back = 0

    def heard(self, topic: str, now: float) -> None:
        """Note that a message came on a topic that can be used."""
        self._heard[topic] = now

    def refuse(self, reason: str, now: float) -> None:
        """Note that a message came that cannot be used, and why."""
        self._refused = _Event(reason, now)
        self._refusals += 1

    def fail(self, reason: str, now: float) -> None:
        """Note that the model could not predict, and why; residuals in the window are forgotten."""
        self._failed = _Event(reason, now)
        self._window.clear()

    def take(self, comparison: Comparison, now: float) -> None:
        """Add a comparison. If the clock was set back since the last one, earlier residuals are
        forgotten.
        """
        if self._prediction.set_back != self._seen_set_back:
            self._seen_set_back = self._prediction.set_back
            self._set_back = _Event("the clock was set back: memory reset", now)
            self._window.clear()
        self._window.add(comparison)
        self._compared.update(dict.fromkeys(comparison.names, now))

    def reports(self, now: float) -> list[Report]:
        """One report on the model, and one on each actuator."""
        names = self._prediction.hand.actuator_names
        return [self._model(now), *(self._actuator(name, now) for name in names)]

    def _model(self, now: float) -> Report:
        model = self._prediction.model
        weight = "" if not model.gravity_scale else "; the actuators' weight is left out"
        values = {
            "model file": self._model_name,
            "effects": ", ".join(effect.name for effect in model.effects) or "none",
            "hand": self._prediction.hand.name,
            "refused messages": str(self._refusals),
            "clock set back": str(self._prediction.set_back),
        }
        refused = self._refused.recent(now)
        warnings = [self._set_back.recent(now), refused and f"refused {refused}"]
        failure, warning = self._failed.recent(now), "; ".join(filter(None, warnings))
        level = Level.ERROR if failure else Level.WARN if warning else Level.OK
        return Report("model", level, failure or warning or REMINDER + weight, values)

    def _actuator(self, name: str, now: float) -> Report:
        recent = self._window.recent(name)
        values = {
            "residual, rms [deg]": f"{math.degrees(recent.rms):.3f}",
            "residual, largest [deg]": f"{math.degrees(recent.largest):.3f}",
            "samples": str(recent.samples),
            "of them settled": str(recent.settled),
        }
        stale = self._stale(name, now)
        if stale:
            return Report(name, Level.STALE, stale, values)
        if not recent.settled:
            return Report(name, Level.OK, "moving: no settled sample to judge by", values)
        size = f"residual {math.degrees(recent.rms):.2f} deg rms"
        if recent.rms <= self._limits.warn_above:
            return Report(name, Level.OK, size, values)
        limit = f"above {math.degrees(self._limits.warn_above):.2f} deg"
        return Report(
            name, Level.WARN, f"{size}, {limit}: contact, or the model lacks an effect", values
        )

    def _stale(self, name: str, now: float) -> str:
        """Why there is nothing new to compare; empty when there is."""
        since = now - self._compared.get(name, -math.inf)
        if since <= self._limits.stale_after:
            return ""
        silent = [
            topic
            for topic in (PRESSURE, ANGLE)
            if now - self._heard.get(topic, -math.inf) > self._limits.stale_after
        ]
        if silent:
            return f"no message on {' and '.join(silent)}"
        if math.isinf(since):
            return f"{ANGLE} has no such actuator, or its stamps do not meet those of {PRESSURE}"
        return f"nothing to compare for {since:.0f} s"
