"""Samples whose input stood at the limit of its sensor: what is left of a set without them."""

from __future__ import annotations

from dataclasses import replace

from model_lab.diagnosis.result import ADEQUATE, SLIP, UNEXPLAINED, Diagnosis
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.limited_input import Limit, limit_reached, within_limit
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import column_unit, unit_of
from model_lab.rules import RULES
from model_lab.slips.columns import column_mend
from model_lab.slips.slip import Slip

SENSOR_LIMIT = "limit"  # name of the slip


def without_limit(data: MeasurementSet, found: Diagnosis) -> tuple[MeasurementSet, Limit] | None:
    """(the set without samples whose input stands at the limit of its sensor, that limit); None if
    none is seen, or nothing is missing. found: the diagnosis of the set as stated.
    """
    limit = limit_reached(data, found.noise_floor_parts["within"])
    if limit is None or (found.verdict_mended or found.verdict) == ADEQUATE:
        return None
    return within_limit(data, limit.reading), limit


def with_limit(
    data: MeasurementSet, found: Diagnosis, limited: Diagnosis, limit: Limit
) -> Diagnosis | None:
    """The diagnosis of the set without such samples, with the slip that says so; None if that is a
    guess, explains nothing, or leaves much. found, limited: diagnoses of the set as stated and of
    `without_limit`.
    """
    verdict = limited.verdict_mended or limited.verdict
    little = limited.rmse_after <= RULES.slip_share * found.rmse_before
    if verdict == UNEXPLAINED or limited.guess or not little:
        return None
    column = DRIVING_COLUMN[data.experiment]
    usual = unit_of(column) or ""
    shown, stated = data.shown_in(usual).shown(limit.reading, 4), data.units.get(column, usual)
    number = limit.reading / column_unit(column, stated).scale
    entry = {"unit": stated, "limit": float(f"{number:.5g}")}
    slip = Slip(
        SENSOR_LIMIT,
        column,
        "what acts on the actuator",
        f"at its limit of {shown} in some samples",
        found.rmse_before,
        limited.rmse_after,
        column_mend(data, {column: entry}),
    )
    return replace(limited, verdict=SLIP, slips=(slip, *limited.slips), verdict_mended=verdict)
