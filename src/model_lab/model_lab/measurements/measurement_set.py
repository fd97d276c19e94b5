"""Measurement set in memory: specimens, and runs with their columns in SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.drives import Drive, drive_of, driven_alike, pulsed_alike
from model_lab.measurements.hands import (
    GAUGE_AREA,
    GRASP,
    HAND_MOTION,
    HAND_POSE,
    OBJECT_PLACE,
    OBJECT_POSE,
    OF_HANDS,
    PLACE_STIFFNESS,
    PRESS,
    TORQUE_ARM,
    TORQUES,
    WITH_WRENCH,
    WRENCH_COLUMNS,
    WRIST_POSE,
    Grasped,
    HandSpecimen,
    Marker,
    Plate,
    marker_columns,
    mass_columns,
    pressure_columns,
)
from model_lab.measurements.sample_table import WHOLE_PROTOCOLS, SampleTable, make_table
from model_lab.measurements.units import (
    Display,
    display_among,
    display_of,
    stated_display,
    unit_of,
)
from softhand_common.numerics.rotations import from_rpy, rotate
from softhand_model.effects.effect import STRETCHED
from softhand_model.hand.hand import HandDescription

INVERSE_QUATERNION = np.array([-1.0, -1.0, -1.0, 1.0])  # turns a quaternion into its inverse
SET_FORMAT = "softhand-measurement/1"  # of its document on disk
TIP_POSE = tuple(f"tip_{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw"))
OUTPUTS = {
    "free_bending": ("tip_angle",),
    "blocked_tip": ("tip_force",),
    "uniaxial": ("stress",),
    "rubber": ("stress",),
    "valve_pulse": ("mass",),
    "base_torque": ("torque_x", "torque_y", "torque_z"),
    **dict.fromkeys(OF_HANDS, ()),  # those of its markers
    PRESS: WRENCH_COLUMNS,
    GRASP: WRENCH_COLUMNS,  # pressures, and places of the object
}
INPUTS = {
    "free_bending": ("pressure",),
    "blocked_tip": ("pressure",),
    "uniaxial": ("stretch",),
    "rubber": ("stretch",),
    "valve_pulse": ("direction", "duration", "p_in", "p_out"),
    "base_torque": ("time", "pressure", *TIP_POSE),
    HAND_POSE: (),  # the pressures of its channels
    HAND_MOTION: ("time",),  # and the same pressures
    PRESS: ("time", *WRIST_POSE),  # and the same pressures
    GRASP: ("time", *WRIST_POSE, *OBJECT_POSE[3:]),  # and the masses of air in its channels
}
OUTPUT_UNITS = {
    "free_bending": "rad",
    "blocked_tip": "N",
    "uniaxial": "Pa",
    "rubber": "Pa",
    "valve_pulse": "kg",
    "base_torque": "N m",
    **dict.fromkeys(OF_HANDS, "m"),
    **dict.fromkeys(WITH_WRENCH, "N"),  # torques are counted over TORQUE_ARM
}
MODES = ("uniaxial", "pure_shear", "equibiaxial")  # in which rubber is stretched
INFLATE, DEFLATE = 1.0, -1.0  # the column `direction` of valve_pulse as numbers
MODE_HOLDOUT = "modes"
SAME_TEMPERATURE = 1.0  # [K] within which runs are repeats
ROOM_TEMPERATURE = 293.15
TEMPERATURE = "temperature"  # column of a run in which it changes
UNSTATED_BATCH = "all"  # of specimens of which a set states none


@dataclass(frozen=True)
class Specimen:
    """One specimen, with its entries in SI units.

    values: numbers (length, wall, side_wall, shear_modulus, mass, gauge_length, ...), or arrays (n,
    2) of [x, value] for sizes that vary along x [m]. mount, batch: names. notes: what else its
    entry says, such as a description. hand: the hand that it is; None for other specimens.
    """

    name: str
    values: Mapping[str, float | Array] = field(default_factory=dict)
    mount: str = "bending_plane_level"
    batch: str = UNSTATED_BATCH
    notes: Mapping[str, object] = field(default_factory=dict)
    hand: HandSpecimen | None = None

    @property
    def mean_wall(self) -> float:
        """Wall thickness [m] averaged over the length of the specimen; NaN if no wall is stated.
        A tapered wall is given by points (position, thickness).

        >>> Specimen("a", {"wall": np.array([[0.0, 0.002], [0.09, 0.004]])}).mean_wall
        0.003
        """
        wall = np.asarray(self.values.get("wall", np.nan), float)
        if wall.ndim == 0:
            return float(wall)
        x, size = wall.T
        return float(np.sum(np.diff(x) * (size[1:] + size[:-1])) / 2.0 / (x[-1] - x[0]))


@dataclass(frozen=True)
class Run:
    """One run: columns (samples,) in SI units by name, with `time` [s] if it was recorded.

    protocol: runs with the same specimen, protocol and temperature [K] are repeats. virgin: whether
    the specimen has never been stretched before. steady: whether the run starts in the steady state
    of its first sample; if not, at rest at zero pressure. mode: one of MODES in the experiment
    `rubber`, else "". lead (k,): time and inputs before the first sample, with which a model is
    driven too. stretched_to [-]: largest stretch of the specimen before the run, in pulls that are
    not in the set (`measurements.preconditioning`). wrist_rpy (3,) [rad]: roll, pitch and yaw at
    which the wrist of a hand was held, in the world, z up. weights
    (outputs, samples) [-]: factors on outputs in the table (`experiments.hand_grasp.weighted`).
    """

    name: str
    specimen: str
    protocol: str
    temperature: float
    columns: Mapping[str, Array]
    virgin: bool = False
    steady: bool = False
    mode: str = ""
    lead: Mapping[str, Array] = field(default_factory=dict)
    stretched_to: float = 1.0
    wrist_rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    weights: Array | float = 1.0

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(next(iter(self.columns.values())))

    @property
    def warmth(self) -> Array:
        """Temperature (samples,) [K]: its column if it was recorded, else that of the run."""
        usual = np.full(self.samples, self.temperature)
        return self.columns.get(TEMPERATURE, usual)

    def measured(self, outputs: Sequence[str]) -> Array:
        """Values (outputs, samples) of the columns with these names; NaN for a column that the run
        does not have.
        """
        missing = np.full(self.samples, np.nan)
        return np.array([self.columns.get(name, missing) for name in outputs], float)


@dataclass(frozen=True)
class WildSample:
    """A wild reading that was replaced.

    run, sample: index of its run, and its index within the run. moved: the new reading minus the
    old one, in the SI unit of the output.
    """

    run: int
    sample: int
    moved: float


@dataclass(frozen=True)
class MeasurementSet:
    """A measurement set.

    noise: standard deviation of the noise of output columns, in SI units, as far as it was stated.
    free_modulus: whether the shear modulus itself is measured and therefore not limited to 15 %
    about the stated value; always true in the experiment `rubber`. jumps: whether the input is held
    between samples where it jumps (`measurements.held_input`); if not, it goes straight or bends as
    its neighbours say (`measurements.bent_input`). input_step: of a coarse sensor of the input,
    taken out where the input moves (`measurements.unrounded`); else 0. wild: readings that were
    replaced (`measurements.wild_samples`). units: of the columns as stated; values are in SI units
    nevertheless. bags: names of the runs that were read from bags. doubts: error messages on values
    that were kept although they are impossible for their column (`measurements.rows`). markers: of
    a hand, by name. plate: onto which a hand was pressed; None in other experiments. grasped:
    object and scene of a grasp; None in other experiments. left_out: runs that were taken out as
    the model cannot follow them, and why.
    """

    experiment: str
    title: str
    specimens: Mapping[str, Specimen]
    runs: tuple[Run, ...]
    noise: Mapping[str, float] = field(default_factory=dict)
    folder: Path = Path()
    free_modulus: bool = False
    jumps: bool = False
    input_step: float = 0.0
    wild: tuple[WildSample, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    bags: frozenset[str] = frozenset()
    doubts: tuple[str, ...] = ()
    markers: Mapping[str, Marker] = field(default_factory=dict)
    plate: Plate | None = None
    grasped: Grasped | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.experiment == "rubber":
            object.__setattr__(self, "free_modulus", True)

    @property
    def stretched(self) -> bool:
        """Whether rubber alone was tested, with the stretch as input."""
        return self.experiment in STRETCHED

    @property
    def of_hand(self) -> bool:
        """Whether a whole hand was measured."""
        return self.experiment in OF_HANDS

    @property
    def hand(self) -> HandDescription:
        """The hand that was measured; raises ValueError for a set of other specimens."""
        hands = [entry.hand for entry in self.specimens.values() if entry.hand is not None]
        if not hands:
            raise ValueError(f"specimens: expected a hand, got a set of {self.experiment}")
        return hands[0].description

    @property
    def hand_segments(self) -> int | None:
        """Number of segments of each actuator of a simulated hand; None for any other set."""
        return next((entry.hand.segments for entry in self.specimens.values() if entry.hand), None)

    @property
    def free_frame(self) -> bool:
        """Whether the frame of the positions of markers is known from the positions alone."""
        return any(entry.hand.free_frame for entry in self.specimens.values() if entry.hand)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the columns from which a model predicts the outputs."""
        if self.experiment == GRASP:
            return (*INPUTS[GRASP], *mass_columns(self.hand))
        return (*INPUTS[self.experiment], *(self.pressures if self.of_hand else ()))

    @property
    def pressures(self) -> tuple[str, ...]:
        """Names of the pressure columns of a hand, in the order of its channels."""
        return pressure_columns(self.hand)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the measured columns that a model predicts."""
        if self.experiment == GRASP:
            return (*WRENCH_COLUMNS, *self.pressures, *OBJECT_PLACE)
        if self.of_hand and self.experiment != PRESS:
            return marker_columns(self.markers)
        return OUTPUTS[self.experiment]

    @property
    def output_scales(self) -> Array:
        """Factors (outputs,) from measured columns to values of the table: 1, but for torques
        1/TORQUE_ARM [1/m], and in grasps GAUGE_AREA [m2] for pressures and PLACE_STIFFNESS [N/m]
        for places of the object.
        """
        scales = dict.fromkeys(self.outputs, 1.0) | dict.fromkeys(TORQUES, 1.0 / TORQUE_ARM)
        if self.experiment == GRASP:
            scales |= dict.fromkeys(self.pressures, GAUGE_AREA)
            scales |= dict.fromkeys(OBJECT_PLACE, PLACE_STIFFNESS)
        return np.array([scales[name] for name in self.outputs])

    def scales_of(self, run: Run) -> Array:
        """Factors (outputs, samples) from the columns of a run to values of the table:
        `output_scales` times the run's weights.
        """
        shape = len(self.outputs), run.samples
        return np.array(np.broadcast_to(self.output_scales[:, None] * run.weights, shape))

    @property
    def unit(self) -> str:
        """SI unit of the outputs."""
        return OUTPUT_UNITS[self.experiment]

    def display(self, column: str) -> Display:
        """How a column is shown: in the unit that the user stated, otherwise in a unit of daily
        use.
        """
        if column in self.units:
            return stated_display(column, self.units[column])
        return display_of(unit_of(column) or "")

    def shown_in(self, unit: str) -> Display:
        """How values in an SI unit are shown: in the unit that the user stated for the first column
        of this quantity, otherwise in a unit of daily use.
        """
        return display_among(self.units, unit)

    @property
    def output_display(self) -> Display:
        """How outputs are shown: in the unit of the first one."""
        return self.display(self.outputs[0])

    @property
    def has_time(self) -> bool:
        """Whether every run has time and it matters: the poses of `hand_pose` are taken at rest, so
        there it does not.
        """
        timed = all("time" in run.columns for run in self.runs)
        return timed and self.experiment != HAND_POSE

    @cached_property
    def table(self) -> SampleTable:
        """The sample table of the set, which defines the order of all arrays (samples,) of
        the lab.
        """
        measured = [self.scales_of(run) * run.measured(self.outputs) for run in self.runs]
        return make_table(measured, self.groups(), *self._held_out_together())

    def _held_out_together(self) -> tuple[list[str], str]:
        """What names the part of each run that is held out with others, and what that is: the
        protocol, or the mode where only that differs.
        """
        protocols = [run.protocol for run in self.runs]
        modes = [run.mode for run in self.runs]
        by_mode = len(set(protocols)) < 2 < 1 + len(set(modes))
        return (modes, MODE_HOLDOUT) if by_mode else (protocols, WHOLE_PROTOCOLS)

    def column(self, name: str) -> Array:
        """A recorded column (samples,) in the order of the table; KeyError if a run lacks it."""
        return np.concatenate([run.columns[name] for run in self.runs])[self.table.row]

    def driving(self, run: Run) -> Array:
        """The input of a run (samples of the run,): pressure [Pa], for a hand the highest of its
        channels; stretch [-]; or pressure drop of a valve pulse [Pa].
        """
        if self.of_hand:
            return np.max([run.columns[name] for name in self.pressures], axis=0)
        if self.stretched:
            return run.columns["stretch"]
        if self.experiment == "valve_pulse":
            return run.columns["p_in"] - run.columns["p_out"]
        return run.columns["pressure"]

    def of_runs(self, axis: str) -> list[Any]:
        """Value of each run on an axis.

        The axes are session (number of runs before, of any specimen), run_order (number among the
        runs of its specimen, from 1, and again from 1 at a `virgin` run), temperature [K], mode,
        wall [m] (mean), mount and specimen.
        """
        if axis == "session":
            return [float(before) for before in range(len(self.runs))]
        if axis == "run_order":
            return self._run_order()
        if axis == "temperature":
            return [run.temperature for run in self.runs]
        if axis == "mode":
            return [run.mode for run in self.runs]
        specimens = [self.specimens[run.specimen] for run in self.runs]
        if axis == "wall":
            return [specimen.mean_wall for specimen in specimens]
        return [specimen.mount if axis == "mount" else specimen.name for specimen in specimens]

    def _run_order(self) -> list[float]:
        last: dict[str, float] = {}
        order = []
        for run in self.runs:
            last[run.specimen] = 1.0 if run.virgin else last.get(run.specimen, 0.0) + 1.0
            order.append(last[run.specimen])
        return order

    def groups(self) -> list[list[int]]:
        """Groups of indices of runs that repeat each other: with the same specimen, protocol, mode
        and temperature, and driven alike where an experiment has one input or commands pulses.
        """
        groups: list[list[int]] = []
        for index, run in enumerate(self.runs):
            for group in groups:
                first = group[0]
                if _repeats(self.runs[first], run) and self._driven_alike(first, index):
                    group.append(index)
                    break
            else:
                groups.append([index])
        return groups

    def driven_otherwise(self) -> dict[str, str]:
        """Runs that are stated as repeats of an earlier one, but were driven otherwise: the name of
        the first of those, by theirs.
        """
        found = {}
        for index, run in enumerate(self.runs):
            first = next(i for i, other in enumerate(self.runs) if _repeats(other, run))
            if not self._driven_alike(first, index):
                found[run.name] = self.runs[first].name
        return found

    def _driven_alike(self, first: int, second: int) -> bool:
        if self.experiment == "valve_pulse":
            return pulsed_alike(self.runs[first].columns, self.runs[second].columns)
        if self._drives is None:
            return True
        return driven_alike(self._drives[first], self._drives[second])

    @cached_property
    def _drives(self) -> list[Drive] | None:
        if self.of_hand or self.experiment == "base_torque":
            return None
        name = "stretch" if self.stretched else "pressure"
        return [drive_of(run.columns, run.lead, name) for run in self.runs]

    def protocols(self) -> list[str]:
        """Names of the protocols, in the order in which they first appear."""
        return list(dict.fromkeys(run.protocol for run in self.runs))


def _repeats(first: Run, second: Run) -> bool:
    return (
        first.specimen == second.specimen
        and first.protocol == second.protocol
        and first.mode == second.mode
        and abs(first.temperature - second.temperature) <= SAME_TEMPERATURE
    )


def down_of(run: Run) -> Array:
    """Direction (3,) of the weight in the frame of the wrist, at the first sample.

    >>> down_of(Run("r", "h", "p", 293.15, {}, wrist_rpy=(0.0, np.pi, 0.0))).round(9).tolist()
    [0.0, 0.0, 1.0]
    """
    if WRIST_POSE[-1] in run.columns:
        turn = np.array([run.columns[name][0] for name in WRIST_POSE[3:]])
    else:
        turn = from_rpy(run.wrist_rpy)
    return rotate(turn * INVERSE_QUATERNION, [0.0, 0.0, -1.0])
