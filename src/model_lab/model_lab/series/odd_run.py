"""What explains an odd run: another unit, another specimen, or an exchange with another run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.measurements.rows import is_possible
from model_lab.rules import RULES
from model_lab.series.events import EXCHANGED, ODD_RUN, Event
from model_lab.slips.candidates import candidates
from model_lab.slips.slip import Slip

Residual = Callable[[MeasurementSet], Array]
"""Residual (samples,) of a fitted model on a set with other runs."""


@dataclass(frozen=True)
class _Reading:
    """A run read as something else: the run as it would be, what is said of it, and the mend."""

    column: str
    said: str
    fits: str
    mend: str
    data: MeasurementSet


def odd_run_slips(
    data: MeasurementSet, events: Sequence[Event], residual_of: Residual, floor: float
) -> tuple[tuple[Event, ...], tuple[Slip, ...]]:
    """(events, slips): two odd runs that fit once their outputs are exchanged become one event of
    kind EXCHANGED, and each odd run or exchanged pair gets a slip.

    residual_of: returns the residual (samples,) of the model, which was fitted to the other runs,
    on a set. floor: root mean square error of runs that fit.
    """
    named = _exchanged(data, events, residual_of, floor)
    slips = []
    for event in named:
        if event.kind == EXCHANGED:
            slips.append(_exchange_slip(data, event, residual_of))
        elif event.kind == ODD_RUN:
            slips.append(odd_run_slip(data, event.run, residual_of, floor))
    return named, tuple(slips)


def error_of_runs(data: MeasurementSet, names: Sequence[str], residual_of: Residual) -> float:
    """Root mean square error over the runs with these names."""
    index = [k for k, run in enumerate(data.runs) if run.name in names]
    mine = np.isin(data.table.run, index)
    return float(np.sqrt(np.mean(residual_of(data)[mine] ** 2)))


# ---------------------------------------------------------------------- exchanged
def _exchanged(
    data: MeasurementSet, events: Sequence[Event], residual_of: Residual, floor: float
) -> tuple[Event, ...]:
    """Two odd runs that fit when each takes the outputs of the other become one event."""
    odd = [event for event in events if event.kind == ODD_RUN]
    for first, second in combinations(odd, 2):
        tried = [
            (error_of_runs(swapped(data, one, other), (one, other), residual_of), one, other)
            for one in filter(None, (first.run, first.other))
            for other in filter(None, (second.run, second.other))
            if _can_be_exchanged(data, one, other)
        ]
        error, one, other = min(tried, default=(np.inf, "", ""))
        if error <= RULES.odd_run_fits * floor:
            pair = replace(first, kind=EXCHANGED, run=one, other=other)
            return tuple(pair if e is first else e for e in events if e is not second)
    return tuple(events)


def swapped(data: MeasurementSet, first: str, second: str) -> MeasurementSet:
    """The set in which two runs, given by name, have each other's outputs."""
    of = {run.name: {name: run.columns[name] for name in data.outputs} for run in data.runs}
    other = {first: of[second], second: of[first]}
    runs = tuple(
        replace(run, columns={**run.columns, **other.get(run.name, {})}) for run in data.runs
    )
    return replace(data, runs=runs)


def _can_be_exchanged(data: MeasurementSet, first: str, second: str) -> bool:
    samples = {run.name: run.samples for run in data.runs}
    has = {run.name: set(data.outputs) <= set(run.columns) for run in data.runs}
    return samples[first] == samples[second] and has[first] and has[second]


def _exchange_slip(data: MeasurementSet, event: Event, residual_of: Residual) -> Slip:
    pair = (event.run, event.other)
    return Slip(
        EXCHANGED,
        event.run,
        f"{event.run} and {event.other}",
        f"{event.other} and {event.run}",
        error_of_runs(data, pair, residual_of),
        error_of_runs(swapped(data, *pair), pair, residual_of),
        f"runs: exchange the outputs of {event.run} and {event.other}",
    )


# ---------------------------------------------------------------------- one odd run
def odd_run_slip(data: MeasurementSet, name: str, residual_of: Residual, floor: float) -> Slip:
    """The slip of an odd run, given by name: what it fits as, or that it is to be left out.
    residual_of, floor: as of `odd_run_slips`.
    """
    before = error_of_runs(data, (name,), residual_of)
    tried = [
        (error_of_runs(reading.data, (name,), residual_of), number, reading)
        for number, reading in enumerate(_readings(data, name))
    ]
    after, _, best = min(tried, default=(np.inf, 0, None))
    if best is None or after > RULES.odd_run_fits * floor:
        mend = f"runs: leave out {name}, or measure it again"
        return Slip(ODD_RUN, name, "a repeat", "no repeat of its protocol", before, before, mend)
    return Slip(ODD_RUN, name, best.said, best.fits, before, after, best.mend)


def _readings(data: MeasurementSet, name: str) -> Iterator[_Reading]:
    """The set with one run read in all other ways: other units, another specimen."""
    index = next(k for k, run in enumerate(data.runs) if run.name == name)
    alone = replace(data, runs=(data.runs[index],))
    for candidate in candidates(alone):
        specimens = candidate.mended.specimens
        kept = all(specimens[key] is specimen for key, specimen in data.specimens.items())
        if len(candidate.mended.runs) == 1 and kept and is_possible(candidate.mended):
            said, fits = (
                f"{candidate.column} in {unit}" for unit in (candidate.said, candidate.fits)
            )
            mend = f"of {name} alone, {candidate.mend}"
            run = candidate.mended.runs[0]
            yield _Reading(candidate.column, said, fits, mend, _with_run(data, index, run))
    for specimen in data.specimens:
        run = data.runs[index]
        if specimen != run.specimen:
            mend = f"runs: {{{name}: {{specimen: {specimen}}}}}"
            changed = _with_run(data, index, replace(run, specimen=specimen))
            said, fits = f"specimen {run.specimen}", f"specimen {specimen}"
            yield _Reading("specimen", said, fits, mend, changed)


def _with_run(data: MeasurementSet, index: int, run: Run) -> MeasurementSet:
    runs = list(data.runs)
    runs[index] = run
    return replace(data, runs=tuple(runs))
