"""Prediction of the torque on the base of an actuator whose tip is held (section 5.2.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from model_lab.experiments.calibrated import modulus_of_runs, modulus_scales
from model_lab.experiments.chain_springs import chain_springs
from model_lab.experiments.lane_order import lane_values, neutral_lane, waves
from model_lab.experiments.sample_rows import SampleRows, Step
from model_lab.experiments.specimen_memory import SpecimenMemory
from model_lab.experiments.specimen_segments import SpecimenSegments
from model_lab.measurement import INPUTS, OUTPUTS, MeasurementSet
from model_lab.specimens import require_columns, require_keys
from softhand_model.effects import Effect
from softhand_model.effects.gravity import STANDARD_GRAVITY
from softhand_model.effects.staged import StagedEffects, at_modulus, remembers
from softhand_model.effects.stages import SectionShape
from softhand_model.free_bending import SteppedBalance, free_curvature
from softhand_model.held_chain import BaseLoad, HeldChain, Hold
from softhand_model.segments import SegmentChain
from softhand_model.spring_model import THESIS, SpringModel
from softhand_model.vector_fields import matrices

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SEGMENTS = 10
DOWN = {
    "bending_plane_level": (0.0, -1.0, 0.0),
    "base_up": (0.0, 0.0, 1.0),
    "base_down": (0.0, 0.0, -1.0),
}  # in the frame of the base: z along the actuator, x to the bending side
HEAVY = {"mass_scale": 1.0}  # of the base model, where there is gravity at all
OUT_OF_REACH = 1.05  # lengths of the actuator between base and tip


class BaseTorque:
    """Torques (lanes, samples) [N m] of actuators on their bases, run after run, x, y and z within.

    The actuator is the simulator's chain, straight and cut into equal segments, with the springs
    `joints`; base and tip are held where they were measured. The free
    angles follow the pressure with the effects as in free bending. `gravity` pulls at the segments
    beyond the first joint; a level bending plane has it along -y. The pose is taken as it is: the
    stiffness along a nearly straight chain is high, so that errors of the pose show as torque.

    Raises ValueError naming the run for a pose that is out of reach, DocumentError for a missing
    column or key.
    """

    def __init__(
        self, data: MeasurementSet, segments: int = SEGMENTS, joints: SpringModel = THESIS
    ) -> None:
        require_columns(data, INPUTS["base_torque"], "the model of base_torque")
        self._data = data
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(data, self._rows)
        self._segments = SpecimenSegments(data, segments, joints)
        self._pressure = self._rows.column("pressure")
        place = [self._rows.column(f"tip_{axis}")[0, :, 0] for axis in "xyz"]
        turn = [self._rows.column(f"tip_q{axis}")[0, :, 0] for axis in "xyzw"]
        self._position, quaternion = np.array(place), np.array(turn)
        self._check(quaternion)
        self._orientation = matrices(quaternion)
        self._solved: dict[str, Solved] = {}  # last prediction, by specimen
        self._plain: dict[tuple[str, bool], BaseLoad] = {}

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Names of the calibration with the values from which a search starts."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Torques (lanes, samples) [N m]: calibration (lanes,) by name, effects in lanes."""
        staged = StagedEffects(effects)
        modulus = modulus_of_runs(self._data, calibration)
        modulus = modulus * staged.modulus_factor(self._rows.temperature())
        pressure = self._rows.through(
            staged.chamber_pressure, remembers(staged.input), self._pressure
        )
        shape = at_modulus(self._segments.shape, modulus)
        acting = [effect for effect in staged.all if effect not in staged.output]
        values = lane_values(calibration, acting)
        plain = neutral_lane(values, calibration, acting, HEAVY)
        angles = self._free_angles(staged, shape, pressure)
        torque = self._torque(staged, values, plain, modulus, angles)
        shown = [
            self._rows.through(
                partial(staged.reading, name), remembers(staged.output), part[:, :, None]
            )[:, :, 0]
            for name, part in zip(OUTPUTS["base_torque"], torque, strict=True)
        ]
        return self._in_order(shown)

    def _free_angles(self, staged: StagedEffects, shape: SectionShape, pressure: Array) -> Array:
        """Free angles (lanes, rows, segments or 1) [rad] at chamber pressures (lanes, rows, 1)."""
        weight = self._segments.weight

        def bend(stepped: SteppedBalance, at: SectionShape, of: Array, *step: Array) -> Array:
            curvature = free_curvature(stepped, step[0], at, step[1])
            return np.sum(of * curvature.reshape(*curvature.shape[:2], *of.shape[2:]), axis=-1)

        def begin() -> Step:
            return partial(bend, SteppedBalance(staged), shape, weight)

        if remembers(staged.elastic):
            return self._memory.in_steps(begin, staged, pressure)
        return self._rows.at_once(
            lambda part, run: bend(
                SteppedBalance(staged), shape.of_rows(run), weight[:, run], part, np.zeros(1)
            ),
            pressure,
        )

    def _torque(
        self, staged: StagedEffects, values: Array, plain: Array, modulus: Array, angles: Array
    ) -> Array:
        """Torques (3, lanes, rows) [N m] of all specimens, for lanes of such values.

        plain (1, k): values of the base model.
        """
        lanes = len(values)
        modulus = np.broadcast_to(modulus[:, :, 0], (lanes, modulus.shape[1]))[:, self._rows.run]
        angles = np.broadcast_to(angles, (lanes, *angles.shape[1:]))
        torque = np.empty((3, lanes, len(self._rows.run)))
        for name, chain in self._segments.chains.items():
            rows = self._rows_of(name)
            springs = chain_springs(chain, modulus[:, rows], angles[:, rows], staged.structure)
            scales = [e.values["mass_scale"] for e in staged.load if e.name == "gravity"]
            pull = self._gravity(name, scales[0], lanes, rows) if scales else None
            hold = Hold(springs, *self._poses(rows, lanes), pull)
            before = self._solved.get(name)
            if before is None or before.values.shape[1] != values.shape[1]:
                like = self._plain_load(name, chain, rows, heavy=bool(scales))
                before = Solved(plain, like)
            self._solved[name] = before.others(HeldChain(chain), hold, values)
            torque[:, :, rows] = self._solved[name].loads.torque.reshape(3, lanes, len(rows))
        return torque

    def _plain_load(self, name: str, chain: SegmentChain, rows: Indices, heavy: bool) -> BaseLoad:
        """Load of the base model, heavy or weightless, from which every search begins; kept."""
        if (name, heavy) not in self._plain:
            angles = self._free_angles(StagedEffects(), self._segments.shape, self._pressure)
            springs = chain_springs(chain, np.ones((1, len(rows))), angles[:, rows], ())
            pull = self._gravity(name, np.ones(1), 1, rows) if heavy else None
            hold = Hold(springs, *self._poses(rows, 1), pull)
            self._plain[name, heavy] = HeldChain(chain).base_load(hold)
        return self._plain[name, heavy]

    def _rows_of(self, specimen: str) -> Indices:
        runs = [index for index, run in enumerate(self._data.runs) if run.specimen == specimen]
        return np.flatnonzero(np.isin(self._rows.run, runs))

    def _poses(self, rows: Indices, lanes: int) -> tuple[Array, Array]:
        """Positions (3, points) [m] and orientations (3, 3, points) of the tip in all lanes."""
        position, orientation = self._position[:, rows], self._orientation[:, :, rows]
        return np.tile(position, (1, lanes)), np.tile(orientation, (1, 1, lanes))

    def _gravity(self, specimen: str, scale: Array, lanes: int, rows: Indices) -> Array:
        """Gravity (3, points) [m/s2] times the scale of the mass."""
        require_keys(self._data, self._data.specimens[specimen], ("mass",), "the effect gravity")
        down = np.reshape(DOWN[self._data.specimens[specimen].mount], (3, 1))
        pull = STANDARD_GRAVITY * np.broadcast_to(np.ravel(scale), lanes)
        return np.asarray(down * np.repeat(pull, len(rows)))

    def _in_order(self, torques: list[Array]) -> Array:
        """Torques (lanes, samples): per run, and output after output within a run."""
        stacked = np.stack(torques)
        parts = []
        for run in range(len(self._data.runs)):
            of_run = stacked[:, :, self._rows.run == run]
            parts.append(of_run.swapaxes(0, 1).reshape(of_run.shape[1], -1))
        return np.concatenate(parts, axis=1)

    def _check(self, quaternion: Array) -> None:
        """Refuse poses that no actuator can have."""
        reach = np.sqrt(np.sum(self._position**2, axis=0))
        runs = [self._data.specimens[run.specimen] for run in self._data.runs]
        length = np.array([float(np.asarray(run.values["length"])) for run in runs])[self._rows.run]
        expected = "a tip that is not farther from the base than the actuator is long, {:g} m"
        self._refuse(reach > OUT_OF_REACH * length, "tip_x, tip_y, tip_z", expected, reach, length)
        size = np.sqrt(np.sum(quaternion**2, axis=0))
        expected = "a quaternion of length {:g}"
        self._refuse(~(size > 0.5), "tip_qx ... tip_qw", expected, size, np.ones_like(size))

    def _refuse(
        self, wrong: NDArray[np.bool_], columns: str, expected: str, got: Array, wanted: Array
    ) -> None:
        """Raise ValueError for the first wrong sample, if there is one."""
        if wrong.any():
            row = int(np.argmax(wrong))
            run = self._rows.run[row]
            sample = row - int(np.argmax(self._rows.run == run))
            raise ValueError(
                f"run {self._data.runs[run].name}: {columns}: expected "
                f"{expected.format(wanted[row])}, got {got[row]:.3g} in sample {sample}"
            )


@dataclass(frozen=True)
class Solved:
    """Loads that have been found in lanes of such values (lanes, k), lane after lane."""

    values: Array
    loads: BaseLoad

    def others(self, chain: HeldChain, hold: Hold, values: Array) -> Solved:
        """Loads of holds in other lanes, each sought from the one of the lanes nearest to it."""
        lanes = np.concatenate([self.values, values])
        samples = np.arange(hold.position.shape[1] // len(values))
        found = BaseLoad.unknown(len(lanes) * len(samples))
        found.put(np.arange(self.loads.settled.size), self.loads)
        first = len(self.values) * len(samples)
        for wave, starts in waves(lanes, len(self.values)):
            points = (wave[:, None] * len(samples) + samples).ravel()
            begin = (starts[:, None] * len(samples) + samples).ravel()
            found.put(points, chain.base_load(hold.take(points - first), found.take(begin)))
        return Solved(values, found.take(np.arange(first, len(lanes) * len(samples))))
