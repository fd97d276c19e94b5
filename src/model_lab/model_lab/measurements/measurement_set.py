"""A measurement set in memory: specimens, runs with their columns in SI units, and its samples as
series.

The samples of a measurement set as series: what is held out together, repeats, and outputs.

A series is one output of one run, or a contiguous block of it where blocks are held out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OUTPUTS = {
    "free_bending": ("tip_angle",),
    "blocked_tip": ("tip_force",),
    "uniaxial": ("stress",),
    "valve_pulse": ("mass",),
    "base_torque": ("torque_x", "torque_y", "torque_z"),
}
INPUTS = {
    "free_bending": ("pressure",),
    "blocked_tip": ("pressure",),
    "uniaxial": ("stretch",),
    "valve_pulse": ("direction", "duration", "p_in", "p_out"),
    "base_torque": (
        "time",
        "pressure",
        "tip_x",
        "tip_y",
        "tip_z",
        "tip_qx",
        "tip_qy",
        "tip_qz",
        "tip_qw",
    ),
}
OUTPUT_UNITS = {
    "free_bending": "rad",
    "blocked_tip": "N",
    "uniaxial": "Pa",
    "valve_pulse": "kg",
    "base_torque": "N m",
}
INFLATE, DEFLATE = 1.0, -1.0  # the column `direction` of valve_pulse as numbers
SAME_TEMPERATURE = 1.0  # [K] within which runs are repeats
ROOM_TEMPERATURE = 293.15


@dataclass(frozen=True)
class Specimen:
    """One specimen: its entries in SI units; height and width may be lists of (x, value).

    `values` holds numbers (length, wall, side_wall, shear_modulus, mass, gauge_length, ...) and
    profiles as arrays (n, 2) of [x, value]; `mount` and `batch` are names. `notes` holds what else
    its entry says, such as a description.
    """

    name: str
    values: Mapping[str, float | Array] = field(default_factory=dict)
    mount: str = "bending_plane_level"
    batch: str = "all"
    notes: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Run:
    """One run: columns (samples,) in SI units by name, `time` [s] among them if it was recorded.

    protocol: runs of one specimen, protocol and temperature [K] are repeats. `virgin`: the specimen
    has never been stretched before; `steady`: it starts in the steady state of its first sample
    instead of at rest at zero pressure.
    """

    name: str
    specimen: str
    protocol: str
    temperature: float
    columns: Mapping[str, Array]
    virgin: bool = False
    steady: bool = False

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(next(iter(self.columns.values())))


@dataclass(frozen=True)
class MeasurementSet:
    """A measurement set; `noise` holds one sigma by output column in SI units, as far as stated."""

    experiment: str
    title: str
    specimens: Mapping[str, Specimen]
    runs: tuple[Run, ...]
    noise: Mapping[str, float] = field(default_factory=dict)
    folder: Path = Path()

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the measured columns that a model predicts."""
        return OUTPUTS[self.experiment]

    @property
    def unit(self) -> str:
        """SI unit of the outputs."""
        return OUTPUT_UNITS[self.experiment]

    @property
    def has_time(self) -> bool:
        """Whether every run was recorded against time."""
        return all("time" in run.columns for run in self.runs)

    def groups(self) -> list[list[int]]:
        """Indices of runs that repeat each other: same specimen and protocol, same temperature."""
        groups: list[list[int]] = []
        for index, run in enumerate(self.runs):
            for group in groups:
                if _repeats(self.runs[group[0]], run):
                    group.append(index)
                    break
            else:
                groups.append([index])
        return groups

    def protocols(self) -> list[str]:
        """Names of the protocols, in the order in which they first appear."""
        return list(dict.fromkeys(run.protocol for run in self.runs))


def _repeats(first: Run, second: Run) -> bool:
    return (
        first.specimen == second.specimen
        and first.protocol == second.protocol
        and abs(first.temperature - second.temperature) <= SAME_TEMPERATURE
    )


IntArray = NDArray[np.int64]

PROTOCOLS, BLOCKS = "protocols", "blocks"
BLOCKS_A_RUN = 10  # where there are fewer than two protocols; every fifth is held out together
BLOCK_FOLDS = 5


@dataclass(frozen=True)
class Series:
    """Samples start..stop of a set laid out run after run, output after output.

    group: index of the repeats it belongs to. fold: what is held out together with it.
    """

    run: int
    output: int
    group: int
    fold: int
    start: int
    stop: int


@dataclass(frozen=True)
class SeriesLayout:
    """All series of a set in the order of its samples; `holdout` says what the folds are."""

    series: tuple[Series, ...]
    holdout: str
    folds: tuple[str, ...]

    @property
    def samples(self) -> int:
        """Number of samples of all series."""
        return self.series[-1].stop

    def fold_of(self) -> IntArray:
        """Fold of every sample (samples,)."""
        return np.concatenate([np.full(part.stop - part.start, part.fold) for part in self.series])


def series_of(data: MeasurementSet) -> SeriesLayout:
    """The series of a set; with fewer than two protocols blocks of runs are held out."""
    protocols = data.protocols()
    by_block = len(protocols) < 2
    folds = [f"block {fold + 1}" for fold in range(BLOCK_FOLDS)] if by_block else protocols
    group_of = {run: index for index, group in enumerate(data.groups()) for run in group}
    series: list[Series] = []
    start = 0
    for index, run in enumerate(data.runs):
        for output in range(len(data.outputs)):
            edges = _edges(run.samples, by_block)
            for block, (low, high) in enumerate(pairwise(edges)):
                fold = block % BLOCK_FOLDS if by_block else protocols.index(run.protocol)
                series.append(
                    Series(index, output, group_of[index], fold, start + low, start + high)
                )
            start += run.samples
    return SeriesLayout(tuple(series), BLOCKS if by_block else PROTOCOLS, tuple(folds))


def _edges(samples: int, by_block: bool) -> list[int]:
    count = min(BLOCKS_A_RUN, samples) if by_block else 1
    return [int(edge) for edge in np.linspace(0, samples, count + 1).round()]
