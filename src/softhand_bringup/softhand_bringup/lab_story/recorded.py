"""Measurement set and live residual out of the bag of a session."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from model_lab.live.prediction import SECOND
from softhand_bringup.bags.reading import Bag
from softhand_bringup.bags.writing import Part, cut_bag
from softhand_bringup.lab_story.measuring import ANGLES, FINGER, RESIDUAL, STATE, Played
from softhand_model.hand.actuator import PROFILES, Actuator
from softhand_model.hand.profile import ConstantProfile, Profile

PROFILE_PIECES = 8  # straight lines for the taper: the tip angle is exact within 0.1 %
BATCH = "bench"
STILL = 250_000_000  # [ns]; the finger swings for 150 ms after a pulse of the valves
BAND = 2000.0  # [Pa]; a pulse of the valves moves it by 2500, creep under enclosed air by less
GAP = 50_000_000  # [ns] without a pressure, in which it may have done anything
SPACING = 100_000_000  # [ns]


def still_stamps(bag: Path) -> list[int]:
    """Rising stamps [ns] of the tip angles before and after which the pressure stands for STILL.

    As much is left out before a change of pressure as after it: between the samples on both sides
    the lab draws a straight line, which then holds as much pressure over time as the change itself.

    Raises:
        ValueError: nothing of a finger was recorded.
    """
    with Bag(bag) as recording:
        states = sorted((_stamp(m), float(m.effort[0])) for _, m in recording.messages(STATE))
        angles = np.array(sorted(_stamp(message) for _, message in recording.messages(ANGLES)))
    if not states or not len(angles):
        raise ValueError(f"{bag}: expected messages on {STATE} and {ANGLES}, got none")
    stamps, pressures = np.array([s for s, _ in states]), np.array([p for _, p in states])
    known = angles[(angles - STILL >= stamps[0]) & (angles + STILL <= stamps[-1])]
    first = np.searchsorted(stamps, known - STILL, side="right") - 1
    last = np.searchsorted(stamps, known + STILL) + 1
    return [
        int(angle)
        for angle, i, j in zip(known, first, last, strict=True)
        if np.ptp(pressures[i:j]) <= BAND and np.diff(stamps[i:j]).max() <= GAP
    ]


def spaced(stamps: Sequence[int]) -> list[int]:
    """Those of rising stamps [ns] that lie SPACING apart.

    Closer ones would let a lag of some milliseconds pass for an effect: it averages the noise of
    the pressure, which is all the noise that the simulated bench has.

    >>> spaced([0, 60_000_000, 120_000_000, 180_000_000, 240_000_000])
    [0, 120000000, 240000000]
    """
    kept: list[int] = []
    for stamp in stamps:
        if not kept or stamp - kept[-1] >= SPACING:
            kept.append(stamp)
    return kept


def live_residual(bag: Path, runs: Sequence[Played], still: Collection[int]) -> float:
    """Rms [rad] of the monitor's residual in the runs, at still stamps [ns].

    Raises:
        ValueError: there is none.
    """
    counts = set(still)
    with Bag(bag) as recording:
        residuals = {_stamp(m): float(m.position[0]) for _, m in recording.messages(RESIDUAL)}
    counted = [
        value
        for stamp, value in residuals.items()
        if stamp in counts and any(run.start <= stamp / SECOND <= run.end for run in runs)
    ]
    if not counted:
        raise ValueError(f"{bag}: expected residuals where the pressure stands, got none")
    return float(np.sqrt(np.mean(np.square(counted))))


def write_set(
    folder: Path, bag: Path, runs: Sequence[Played], still: Sequence[int], actuator: Actuator
) -> None:
    """Write a measurement set with a bag a run, cut out of the session's.

    Tip angles are kept where the pressure stands: the lab's model has no inertia, and what swings
    after a pulse of the valves would pass for an effect.

    Args:
        folder: must not exist yet.
        bag: of the session.
        runs: what was played when.
        still: stamps [ns] as from `still_stamps`.
        actuator: the specimen.
    """
    folder.mkdir(parents=True)
    kept = set(spaced(still))
    parts = [Part(folder / run.name, partial(_belongs, run, kept)) for run in runs]
    cut_bag(bag, parts, (STATE, ANGLES))
    topics = {
        "pressure": {"topic": STATE, "field": "effort[a]"},
        "tip_angle": {"topic": ANGLES, "field": f"position[{FINGER}]"},
    }
    document = {
        "format": "softhand-measurement/1",
        "experiment": "free_bending",
        "title": "a finger on the simulated bench, recorded over ROS",
        "specimens": {FINGER: _specimen(actuator)},
        "runs": {
            run.name: {
                "specimen": FINGER,
                "temperature": 293.15,
                "protocol": run.protocol,
                "bag": run.name,
                "topics": topics,
            }
            for run in runs
        },
    }
    text = yaml.dump(document, Dumper=_Plain, sort_keys=False, width=120)
    (folder / "experiment.yaml").write_text(text, encoding="utf-8")


def _belongs(run: Played, angles: Collection[int], topic: str, stamp: int) -> bool:
    inside = run.start <= stamp / SECOND <= run.end
    return inside and (topic != ANGLES or stamp in angles)


def _specimen(actuator: Actuator) -> dict[str, object]:
    """The actuator as a specimen; taper as straight lines."""
    return {
        "length": actuator.length,
        **{key: _size(getattr(actuator, key), actuator.length) for key in PROFILES},
        "shear_modulus": actuator.shear_modulus,
        "mass": round(actuator.mass, 6),
        "mount": "bending_plane_level",
        "batch": BATCH,
    }


def _size(profile: Profile, length: float) -> object:
    """A number where the profile is one, else points [x, value]."""
    if isinstance(profile, ConstantProfile):
        return profile.value
    x = np.linspace(0.0, length, PROFILE_PIECES + 1)
    return np.stack([x, profile(x)], axis=1).round(6).tolist()


class _Plain(yaml.SafeDumper):
    """Writes what is repeated out in full, lists of numbers in one line."""

    def ignore_aliases(self, data: object) -> bool:
        """Never a reference."""
        return True


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)
