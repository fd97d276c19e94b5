"""Measurement set and live residual from the bag of a session."""

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
from softhand_bringup.lab_story.measuring import ANGLES, FINGER, RESIDUAL, STATE_NAME, PlayedRun
from softhand_common.documents.output_file import write_file
from softhand_model.hand.actuator import PROFILES, Actuator
from softhand_model.hand.profile import ConstantProfile, Profile

PROFILE_PIECES = 8  # linear pieces of the taper: the error of the tip angle is below 0.1 %
BATCH = "bench"
STILL_TIME = 250_000_000  # [ns]; the finger swings for 150 ms after a valve pulse
STILL_BAND = 2000.0  # [Pa]; a valve pulse changes the pressure by 2500 Pa, creep by less
LARGEST_GAP = 50_000_000  # between two pressures [ns]; in a longer one a change may be missed
ANGLE_SPACING = 100_000_000  # [ns]


def still_stamps(bag: Path) -> list[int]:
    """Rising stamps [ns] of the tip angles at which the pressure was constant for STILL_TIME before
    and after.

    The same time is left out before and after a change of pressure: the lab interpolates linearly
    between the samples on both sides, and the integral of the pressure over time stays the same.

    Raises:
        ValueError: no pressures or tip angles were recorded.
    """
    with Bag(bag) as recording:
        states = sorted((_stamp(m), float(m.effort[0])) for _, m in recording.messages(STATE_NAME))
        angles = np.array(sorted(_stamp(message) for _, message in recording.messages(ANGLES)))
    if not states or not len(angles):
        raise ValueError(f"{bag}: expected messages on {STATE_NAME} and {ANGLES}, got none")
    stamps, pressures = np.array([s for s, _ in states]), np.array([p for _, p in states])
    known = angles[(angles - STILL_TIME >= stamps[0]) & (angles + STILL_TIME <= stamps[-1])]
    first = np.searchsorted(stamps, known - STILL_TIME, side="right") - 1
    last = np.searchsorted(stamps, known + STILL_TIME) + 1
    return [
        int(angle)
        for angle, i, j in zip(known, first, last, strict=True)
        if np.ptp(pressures[i:j]) <= STILL_BAND and np.diff(stamps[i:j]).max() <= LARGEST_GAP
    ]


def spaced(stamps: Sequence[int]) -> list[int]:
    """Selection of rising stamps [ns] that are at least ANGLE_SPACING apart.

    With closer stamps the lab would diagnose a lag of some milliseconds: such a lag averages the
    noise of the pressure, which is the only noise of the simulated rig.

    >>> spaced([0, 60_000_000, 120_000_000, 180_000_000, 240_000_000])
    [0, 120000000, 240000000]
    """
    kept: list[int] = []
    for stamp in stamps:
        if not kept or stamp - kept[-1] >= ANGLE_SPACING:
            kept.append(stamp)
    return kept


def live_residual(bag: Path, runs: Sequence[PlayedRun], still: Collection[int]) -> float:
    """RMS [rad] of the monitor's residual in the runs, at the stamps `still` [ns] from
    `still_stamps`.

    Raises:
        ValueError: there is no residual at these stamps.
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
        raise ValueError(
            f"{bag}: expected the monitor's residuals where the pressure is constant, got none"
        )
    return float(np.sqrt(np.mean(np.square(counted))))


def write_set(
    folder: Path, bag: Path, runs: Sequence[PlayedRun], still: Sequence[int], actuator: Actuator
) -> None:
    """Write a measurement set with a bag for each run, cut out of the session's bag.

    Tip angles are kept only at constant pressure: the lab's model has no inertia, so that the
    swinging after a valve pulse would be diagnosed as an effect.

    Args:
        folder: folder of the set; must not exist yet.
        bag: bag of the session.
        runs: runs of the session.
        still: stamps [ns] from `still_stamps`.
        actuator: the specimen.
    """
    folder.mkdir(parents=True)
    kept = set(spaced(still))
    parts = [Part(folder / run.name, partial(_belongs, run, kept)) for run in runs]
    cut_bag(bag, parts, (STATE_NAME, ANGLES))
    topics = {
        "pressure": {"topic": STATE_NAME, "field": "effort[a]"},
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
    write_file(folder / "experiment.yaml", text)


def _belongs(run: PlayedRun, angles: Collection[int], topic: str, stamp: int) -> bool:
    inside = run.start <= stamp / SECOND <= run.end
    return inside and (topic != ANGLES or stamp in angles)


def _specimen(actuator: Actuator) -> dict[str, object]:
    """The actuator as a specimen, its taper as linear pieces."""
    return {
        "length": actuator.length,
        **{key: _size(getattr(actuator, key), actuator.length) for key in PROFILES},
        "shear_modulus": actuator.shear_modulus,
        "mass": round(actuator.mass, 6),
        "mount": "bending_plane_level",
        "batch": BATCH,
    }


def _size(profile: Profile, length: float) -> object:
    """A number for a constant profile, else points [x, value] (PROFILE_PIECES + 1, 2)."""
    if isinstance(profile, ConstantProfile):
        return profile.value
    x = np.linspace(0.0, length, PROFILE_PIECES + 1)
    return np.stack([x, profile(x)], axis=1).round(6).tolist()


class _Plain(yaml.SafeDumper):
    """Writes YAML without references."""

    def ignore_aliases(self, data: object) -> bool:
        """True always."""
        return True


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)
