"""Verdict of a demo: the sequencer's result of a grasp, in one line and as result.json."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from softhand_common.documents.output_file import write_file

REPORTED_PACKAGES = (
    "softhand_model",
    "pneuflex_sim",
    "pneumaticbox_driver",
    "grasp_strategies",
    "softhand_bringup",
    "ros-jazzy-rclpy",
    "pybullet",
    "numpy",
    "scipy",
    "numba",
)


@dataclass(frozen=True)
class Verdict:
    """Outcome of one grasp in SI units.

    Args:
        gripped: whether the object was lifted by 100 mm and held for 1 s, touched by the hand only.
        reason: the sequencer's sentence.
        lift_height: height of the object above its start [m].
        slip: translation of the object in the hand during the hold [m]; None without a hold.
        duration: duration of the grasp in simulated time [s].
        real_time_factor: simulated over wall time during the grasp.
        seed: seed of the run.
        turn: rotation of the object in the hand during the hold [rad]; None without a hold.
        phase, cause: phase and cause of a failure; empty for a success.
    """

    gripped: bool
    reason: str
    lift_height: float
    slip: float | None
    duration: float
    real_time_factor: float
    seed: int
    turn: float | None = None
    phase: str = ""
    cause: str = ""

    def line(self, folder: Path) -> str:
        """The line printed at the end of the demo."""
        cause = f", {self.cause}" if self.cause else ""
        word = "gripped" if self.gripped else f"not gripped{cause} ({self.reason})"
        slip = "never held" if self.slip is None else f"slip {1e3 * self.slip:.2f} mm in the hold"
        return (
            f"{word}: lifted {1e3 * self.lift_height:.0f} mm, {slip}, "
            f"real-time factor {self.real_time_factor:.2f}; "
            f"bag {folder}/bag, pictures {folder}/grasp.png and {folder}/frames.png"
        )

    def write(self, path: Path) -> None:
        """Write `result.json`, with the versions of the packages."""
        content = {**asdict(self), "versions": versions()}
        write_file(path, json.dumps(content, indent=2) + "\n")


def verdict_from(
    values: Mapping[str, str], success: bool, reason: str, real_time_factor: float, seed: int
) -> Verdict:
    """Verdict from the key-value pairs of `grasp/result` and the answer of the service.

    Args:
        values: `outcome` (gripped, lost or none), `lift_height` [m], `slip` [m] (nan without a
            hold), `duration` [s]; optionally `turn` [rad], `phase`, `cause`.
        success, reason: `success` and `message` of the service's answer.
        real_time_factor: simulated over wall time.
        seed: seed of the run.

    Raises:
        ValueError: a value is missing or is not a number.
    """
    numbers = {}
    for key in ("lift_height", "slip", "duration", "turn"):
        got = values.get(key, "nan" if key == "turn" else "nothing")
        try:
            numbers[key] = float(got)
        except ValueError:
            raise ValueError(f"grasp/result: {key}: expected a number, got {got}") from None
    return Verdict(
        gripped=success and values.get("outcome") == "gripped",
        reason=values.get("reason", "") or reason,
        lift_height=numbers["lift_height"],
        slip=_seen(numbers["slip"]),
        duration=numbers["duration"],
        real_time_factor=real_time_factor,
        seed=seed,
        turn=_seen(numbers["turn"]),
        phase=values.get("phase", ""),
        cause=values.get("cause", ""),
    )


def _seen(number: float) -> float | None:
    return None if math.isnan(number) else number


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that affect a result; `absent` for a package that is
    not installed.
    """
    found = {"python": platform.python_version()}
    for name in REPORTED_PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "absent"
    return found
