"""Blocked tip: its force on a gauge under pressure (section 5.2.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from model_lab.aliases import Array, Indices
from model_lab.experiments.samples import NO_TIME, SampleRows, Step, modulus_of_runs, modulus_scales
from model_lab.experiments.specimen_models import SpecimenMemory, SpecimenSections, circumference
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.measurements.specimens import require_columns
from softhand_model.bending.balance import SteppedBalance, bending_load, free_curvature
from softhand_model.bending.elastic_chain import compiled_effects
from softhand_model.bending.loaded_finger import Blocked, BlockedSolver, bulging
from softhand_model.bending.whole_runs import force_in_runs
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import StagedEffects, at_modulus, overrides, remembers
from softhand_model.effects.stages import SectionShape, StructureEffect
from softhand_model.hand import section

SPRINGS = ("exact", "linear")


class BlockedTip:
    """Tip forces (lanes, samples) [N], run after run.

    springs: with `exact`, each section is in balance; with `linear`, sections are springs B =
    2*G*d*(c/4)**3 about the free curvature, as in the simulation of the thesis (section 5.2.3). The
    shear modulus, and effects that act like it, hardly change the force: a straight section carries
    h**2*z*p/2 whatever G is.

    Raises DocumentError for a specimen that lacks a key of the model, ValueError for another value
    of `springs`.
    """

    def __init__(self, data: MeasurementSet, springs: str = "exact") -> None:
        if springs not in SPRINGS:
            raise ValueError(f"springs: expected one of {', '.join(SPRINGS)}, got {springs}")
        self._data, self._linear = data, springs == "linear"
        require_columns(data, INPUTS["blocked_tip"], "the model")
        self._rows = SampleRows(data)
        self._memory = SpecimenMemory(self._rows)
        self._sections = SpecimenSections(data, uniform=False)
        self.strained = self._sections.shape, "pure_shear"
        self._edge = circumference(data, self._sections) / 4.0
        self._pressure = self._rows.column("pressure")

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        return modulus_scales(self._data)

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Tip forces (lanes, samples) [N]: calibration (lanes,) by name, effects in lanes."""
        staged, rows = StagedEffects(effects), self._rows
        modulus = modulus_of_runs(self._data, calibration)
        modulus = modulus * rows.modulus_factor(staged)
        warming = rows.warming(staged)
        pressure = rows.chamber_pressure(staged, self._pressure) / warming
        force = warming * self._force(staged, modulus, pressure)
        rubbing = [e for e in staged.structure if overrides(e, StructureEffect, "tip_force")]
        force = rows.through(staged, rubbing, "tip_force", force)
        return rows.reading(staged, "tip_force", force)

    def _force(self, staged: StagedEffects, modulus: Array, pressure: Array) -> Array:
        """Force (lanes, rows, 1) [N] of the tip at chamber pressures (lanes, rows, 1) [Pa]."""
        sections, rows = self._sections, self._rows
        reach = sections.length - sections.x
        blocked = Blocked(reach, sections.weight, staged.tip_compliance(), sections.running)
        fingers = _Fingers(at_modulus(sections.shape, modulus), blocked, self._edge)
        force = self._of_straight(staged, fingers, pressure)
        if not staged.bulges:
            return force
        fingers = fingers.of_rows(rows.run)
        load = bending_load(staged, pressure, fingers.shape)
        return force * bulging(load, fingers.shape, fingers.blocked)

    def _of_straight(self, staged: StagedEffects, fingers: _Fingers, pressure: Array) -> Array:
        """Force (lanes, rows, 1) [N] of fingers that stay straight between base and gauge."""
        rows = self._rows
        effects = compiled_effects(staged)
        if effects is not None and not self._linear and not staged.stiffens:
            load = bending_load(staged, pressure, fingers.shape.of_rows(rows.run))
            return force_in_runs(effects, load, fingers.shape, fingers.blocked, rows.runs)

        def stepping(fingers: _Fingers) -> Step:
            stepped = SteppedBalance(staged)
            return fingers.springs(stepped) if self._linear else fingers.exact(stepped)

        if remembers(staged.elastic):
            return self._memory.in_steps(lambda: stepping(fingers), staged, pressure)
        return self._rows.at_once(
            lambda part, run: stepping(fingers.of_rows(run))(part, NO_TIME),
            pressure,
            self._sections.x.shape[-1],
        )


@dataclass(frozen=True)
class _Fingers:
    """Sections (lanes, rows, sections) of fingers with a blocked tip; edge [m] is c/4."""

    shape: SectionShape
    blocked: Blocked
    edge: Array

    def of_rows(self, rows: Indices) -> _Fingers:
        """Some of the rows, or rows that repeat."""
        return _Fingers(self.shape.of_rows(rows), self.blocked.of_rows(rows), self.edge[:, rows])

    def exact(self, stepped: SteppedBalance) -> Step:
        """Force (lanes, rows, 1) [N] after a step to a pressure [Pa], every section in balance."""
        staged = stepped.staged
        factor = staged.stiffness_factor if staged.stiffens else None
        solver = BlockedSolver(self.blocked, self.shape, factor)

        def step(pressure: Array, dt: Array) -> Array:
            load = bending_load(staged, pressure, self.shape)
            stepped.stretch(load, self.shape, dt, solver)
            return solver.force

        return step

    def springs(self, stepped: SteppedBalance) -> Step:
        """Force (lanes, rows, 1) [N] after a step to a pressure [Pa], with linear springs."""
        stiffness = section.rule_stiffness(self.edge, self.shape.wall, self.shape.shear_modulus)

        def step(pressure: Array, dt: Array) -> Array:
            free = free_curvature(stepped, pressure, self.shape, dt)
            return self.blocked.spring_force(free, stiffness, stepped.staged.stiffness_factor)

        return step
