"""Valve pulses: the air mass that each moves (eq. 4.1 and what it leaves out)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, INPUTS, MeasurementSet
from model_lab.measurements.rows import require_possible
from model_lab.measurements.specimens import require_columns
from softhand_model.effects import Effect
from softhand_model.effects.pipeline import in_order, moved_mass
from softhand_model.effects.stages import FlowEffect, Pulse
from softhand_model.gas import psi

DIRECTIONS = {"inflate": INFLATE, "deflate": DEFLATE}  # name of the calibration: column's value
USUAL_CONDUCTANCE = {"inflate": 7e-11, "deflate": 6e-10}  # [kg/(s Pa)] of the chokes of section 4.3


class ValvePulse:
    """Masses (lanes, samples) [kg] that the pulses of a set move, run after run.

    The base is the naive model c*p_in*duration with one coefficient c [kg/(s Pa)] per direction
    (section 4.4.3). If `friction_integral` or `injector_integral` were not recorded, pressures
    count as constant during the pulse.

    Raises ValueError, which names run and column, for a direction other than 1 and -1 and for
    durations or pressures that are not above 0; DocumentError for a missing column.
    """

    def __init__(self, data: MeasurementSet) -> None:
        require_columns(data, INPUTS["valve_pulse"], "the model of valve_pulse")
        require_possible(data)
        for run in data.runs:
            _check(run.name, run.columns)
        direction, duration, p_in, p_out = (data.column(name) for name in INPUTS["valve_pulse"])
        friction = (p_in - p_out) * duration
        injector = p_in * psi(p_out / p_in) * duration
        self._inflating = direction == INFLATE
        self._columns = (
            duration,
            p_in,
            p_out,
            _joined(data, "friction_integral", friction),
            _joined(data, "injector_integral", injector),
        )
        self._measured = data.table.value

    def calibration(self, effects: Sequence[type[Effect] | Effect] = ()) -> dict[str, float]:
        """Least-squares values [kg/(s Pa)] of the calibration parameters of a model with these
        effects, by name.

        They are `inflate` and `deflate`, if the set has such pulses; usual values if no mass was
        measured. Empty if an effect replaces the naive term.
        """
        if any(getattr(effect, "replaces_naive", False) for effect in effects):
            return {}
        product = self._columns[0] * self._columns[1]
        chosen = {"inflate": self._inflating, "deflate": ~self._inflating}
        known = np.isfinite(self._measured)
        return {
            name: _slope(
                product[rows & known], self._measured[rows & known], USUAL_CONDUCTANCE[name]
            )
            for name, rows in chosen.items()
            if rows.any()
        }

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Masses (lanes, samples) [kg]: calibration (lanes,) by name, effects in lanes.

        A calibration value that is absent counts as 0. Effects of other stages have no influence.
        """
        flow = [effect for effect in in_order(effects) if isinstance(effect, FlowEffect)]
        return moved_mass(self._naive(calibration), flow)

    def _naive(self, calibration: Mapping[str, Array]) -> Pulse:
        """The pulses as commanded, with what the naive model says of them."""
        duration, p_in, p_out, friction, injector = (column[None] for column in self._columns)
        inflate, deflate = (
            np.reshape(np.asarray(calibration.get(name, 0.0), float), (-1, 1))
            for name in DIRECTIONS
        )
        inflating = self._inflating[None]
        conductance = np.where(inflating, inflate, deflate)
        naive = conductance * (p_in * duration)
        return Pulse(inflating, duration, p_in, p_out, friction, injector, naive)


def _slope(product: Array, mass: Array, otherwise: float) -> float:
    """Factor of the product that fits the masses best, or another one if there are none."""
    return float(product @ mass / (product @ product)) if product.size else otherwise


def _joined(data: MeasurementSet, column: str, otherwise: Array) -> Array:
    """A column (samples,) of all runs; for a run without it, its samples of `otherwise`."""
    parts = [
        run.columns.get(column, otherwise[data.table.run == index])
        for index, run in enumerate(data.runs)
    ]
    return np.concatenate(parts)


def _check(run: str, columns: Mapping[str, Array]) -> None:
    for name in INPUTS["valve_pulse"]:
        if name == "direction":
            wrong = ~np.isin(columns[name], list(DIRECTIONS.values()))
            wanted = "inflate or deflate"
        else:
            wrong, wanted = ~(np.asarray(columns[name]) > 0.0), "numbers above 0"
        if wrong.any():
            row = int(np.argmax(wrong))
            raise ValueError(
                f"run {run}: {name}: expected {wanted}, got {columns[name][row]:g} in sample {row}"
            )
