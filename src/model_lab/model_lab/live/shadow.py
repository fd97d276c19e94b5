"""Shadow of a running hand: where a model says that its fingertips would be at rest, and what a
difference from the measured positions means.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.hand_pose import HandPose, with_weight
from model_lab.measurements.hands import (
    HAND_POSE,
    MARKER_AXES,
    HandSpecimen,
    default_markers,
    marker_columns,
)
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_common.numerics.rotations import to_rpy
from softhand_common.status import Level, Report
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

LEVEL_WRIST = np.array([0.0, 0.0, 0.0, 1.0])  # a quaternion
STILL_SHARE = 0.2  # of `warn_distance`: most that a resting fingertip moves between two looks


@dataclass(frozen=True)
class ShadowLimits:
    """When the shadow warns, and when that counts as contact.

    warn_distance [m]: root mean square distance between measured and predicted fingertips.
    contact_force [N]: force at the wrist, without the weight of the hand, above which the hand
    touches something.
    """

    warn_distance: float
    contact_force: float


@dataclass(frozen=True)
class Seen:
    """What was measured of a hand at one time.

    pressures (channels,) [Pa]: gauge pressures. stood: whether they have been constant for a while.
    fingertips (tips, 3) [m]: in the frame of the wrist. orientation (4,): of the wrist in the
    world, as a quaternion x, y, z, w. force (3,) [N]: at the wrist; None if unknown.
    """

    pressures: Array
    stood: bool
    fingertips: Array
    orientation: Array
    force: Array | None


class HandShadow:
    """Predicts where the fingertips of a hand at rest are, in the order of the hand's `tips`.

    Args:
        hand: the hand.
        stated: its name or file, as the user stated it.
        model: the model of the actuators.
        limits: when to warn.
        temperature: temperature of the rubber [K].

    Raises ValueError for a model with effects that the statics of hands do not have.
    """

    def __init__(
        self,
        hand: HandDescription,
        stated: str,
        model: Model,
        limits: ShadowLimits,
        temperature: float = ROOM_TEMPERATURE,
    ) -> None:
        self._limits, self._temperature = limits, temperature
        self._markers = default_markers(hand)
        specimen = Specimen("hand", batch="hand", hand=HandSpecimen(stated, hand))
        columns = {name: np.zeros(1) for name in marker_columns(self._markers)}
        run = Run("now", "hand", "now", temperature, columns)
        self._set = MeasurementSet(
            HAND_POSE, "now", {"hand": specimen}, (run,), markers=self._markers
        )
        model = with_weight(self._set, model)
        self._effects = [effect for effect in model.effects if HAND_POSE in effect.experiments]
        self.names = tuple(self._markers)
        self._last: Array | None = None
        self.fingertips(np.zeros(len(hand.channels)), LEVEL_WRIST)  # compiles what it needs

    def fingertips(self, pressures: Array, orientation: Array) -> Array:
        """Predicted positions (tips, 3) [m] of the fingertips in the frame of the wrist, at gauge
        pressures (channels,) [Pa] and an orientation (4,) of the wrist in the world, a quaternion
        x, y, z, w.

        Raises RuntimeError if the hand has no equilibrium under the model.
        """
        data = self._set
        columns = {
            **data.runs[0].columns,
            **{name: np.array([p]) for name, p in zip(data.pressures, pressures, strict=True)},
        }
        rpy = tuple(to_rpy(orientation).tolist())
        run = Run("now", "hand", "now", self._temperature, columns, wrist_rpy=rpy)
        found = HandPose(replace(data, runs=(run,))).predict({}, self._effects)
        if not np.isfinite(found).all():
            raise RuntimeError(
                "expected a hand at rest, got none: the model has no equilibrium at these pressures"
            )
        return found.reshape(len(self.names), len(MARKER_AXES))

    def report(self, seen: Seen, predicted: Array) -> Report:
        """A report on the difference between measured and predicted fingertips: no warning,
        contact, or an effect that the model lacks. None is judged while the hand moves.
        """
        distance = np.linalg.norm(seen.fingertips - predicted, axis=1)
        rms, furthest = float(np.sqrt(np.mean(distance**2))), int(np.argmax(distance))
        force = math.nan if seen.force is None else float(np.linalg.norm(seen.force))
        values = {
            "distance, rms [mm]": f"{1e3 * rms:.2f}",
            **{
                f"{name} [mm]": f"{1e3 * one:.2f}"
                for name, one in zip(self.names, distance.tolist(), strict=True)
            },
            "force at the wrist [N]": f"{force:.2f}",
        }
        still = seen.stood and self._is_still(seen.fingertips)
        self._last = seen.fingertips
        if not still:
            return Report("shadow", Level.OK, "moving: no pose at rest to judge by", values)
        size = f"fingertips {1e3 * rms:.1f} mm rms from the model's"
        if rms <= self._limits.warn_distance:
            return Report("shadow", Level.OK, size, values)
        size += f", {self.names[furthest]} {1e3 * distance[furthest]:.1f} mm"
        if math.isnan(force):
            why = "contact, or the model lacks an effect; no message on wrist/wrench tells which"
        elif force > self._limits.contact_force:
            why = f"contact, as the wrist bears {force:.2f} N"
        else:
            why = (
                "the wrist bears nothing: the model lacks an effect, or what is held is weightless"
            )
        return Report("shadow", Level.WARN, f"{size}: {why}", values)

    def _is_still(self, fingertips: Array) -> bool:
        if self._last is None:
            return False
        moved = np.linalg.norm(fingertips - self._last, axis=1).max()
        return bool(moved <= STILL_SHARE * self._limits.warn_distance)
