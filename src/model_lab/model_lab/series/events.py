"""Events in a series of measurements: steps, drifts and odd runs, seen by repeats alone.

Repeats should differ by scatter only. Each possible event is a pattern over the runs: a step (0
before a run, 1 from it on), a drift (it grows with the order of the runs) or an odd run (1 for it
alone), of all specimens or of one. The pattern that explains most of the differences between
repeats is an event if that is more than the best of all patterns explains where repeats scatter
normally. As only differences between repeats count, an error of the model does not matter. No
stated noise is needed: the repeats that do not differ by the event tell the scatter.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from scipy.special import fdtrc

from model_lab.aliases import Array, IntArray
from model_lab.measurements.hands import GRASP
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.sample_table import SampleTable
from model_lab.rules import RULES
from model_lab.series.exchange import NORMAL_DRAWS, exchanged_pair
from model_lab.series.run_scale import OUTPUT_SCALE, RunValues, as_good, run_values, within_groups

STEP_EVENT, DRIFT_EVENT, ODD_RUN, EXCHANGED = "step", "drift", "odd_run", "exchanged"
SLOW_COURSE = "course"  # repeats that vary smoothly from run to run, in no pattern that is known
STEP_OR_DRIFT = (STEP_EVENT, DRIFT_EVENT)  # of many runs, that no scatter of one run explains
MOST_EVENTS = 4  # that are sought in one series
SAME_PATTERN = 1e-9  # relative difference of what two patterns explain
SETTLING_RUNS = 0.25  # share of the series after which a drift that settles has 63 % of its size


@dataclass(frozen=True)
class Pattern:
    """What an event would do to the runs of a set.

    shape (runs,): change of each run by an event of size 1. first: index of the first run that it
    changes. specimen: name of the specimen whose runs it changes; "" for all.
    """

    kind: str
    first: int
    shape: Array
    specimen: str = ""


@dataclass(frozen=True)
class Event:
    """Something that happened in a series of measurements.

    kind: STEP_EVENT, DRIFT_EVENT, ODD_RUN, EXCHANGED, or of a doubted one SLOW_COURSE. run: name of
    the first run that it changed. before: name of the run before that. quantity: OUTPUT_SCALE or
    OUTPUT_ZERO, or LOAD_SCALE, of pressure over modulus. size: relative change of the scale, or
    change of the zero in the SI unit of the outputs; for a drift, over the whole series. p_value:
    of the null hypothesis that repeats scatter normally, over all patterns. pattern: what it does
    to the runs. output: index of the output. other: the second of two exchanged runs, or of two
    repeats of which either may be the odd one. largest: for a step, the run just before or after it
    that first reached the largest input of the series, if there is one. Names that do not apply are
    "".
    """

    kind: str
    run: str
    before: str
    quantity: str
    size: float
    p_value: float
    pattern: Pattern
    output: int = 0
    other: str = ""
    largest: str = ""

    def as_json(self) -> dict[str, Any]:
        """The event as a dictionary, without the pattern; `specimen` is None if it concerns all."""
        found: dict[str, Any] = {
            "kind": self.kind,
            "run": self.run,
            "before": self.before or None,
            "specimen": self.pattern.specimen or None,
            "quantity": self.quantity,
            "size": self.size,
            "p_value": self.p_value,
        }
        more = {"other": self.other, "largest_input": self.largest}
        return found | {name: value for name, value in more.items() if value}


@dataclass(frozen=True)
class Series:
    """What repeats tell about the series of runs.

    freedom: degrees of freedom of the differences between repeats; 0 without repeats. p_value: of
    the first event, or of the best pattern if there is no event; 1 without repeats. doubted:
    without an event, the step or drift that is too uncertain to be reported as an event, but too
    likely to be ignored as noise, or a course of another kind.
    """

    freedom: int
    p_value: float
    events: tuple[Event, ...]
    doubted: Event | None = None


NO_SERIES = Series(0, 1.0, ())


def examine(
    data: MeasurementSet, residual: Array, within: float, refused: Sequence[str] = ()
) -> Series:
    """Find the events in the series of a set, from the residual (samples,) of a model.

    within: root mean square scatter within a run, in the SI unit of the outputs; an event that
    changes runs by less is ignored. refused: kinds of events that are not looked for. In grasps an
    event must show in two protocols: a single contact lets a run differ from its repeat, whose
    object began elsewhere.
    """
    table, group = data.table, group_of_runs(data)
    freedom = len(group) - len(np.unique(group))
    sought = (p for p in _patterns(data) if p.kind not in refused)
    least = 2 if data.experiment == GRASP else 1
    patterns = [p for p in sought if _groups_changed(p, group) >= least]
    if freedom < RULES.event_freedom or not patterns:
        return Series(freedom, 1.0, ())
    measured, predicted = table.value, table.value - residual
    events, doubted = _exchanged_runs(data, residual, within, group), None
    first_p_value = events[0].p_value if events else 1.0
    while freedom - len(events) >= RULES.event_freedom and len(events) < MOST_EVENTS:
        values = run_values(table, measured, predicted, data.of_hand)
        if not values:  # a run at rest throughout has no scale
            break
        tried = [_best(data, one, patterns, group, events) for one in values]
        found = min(tried, key=lambda event: (not _matters(event, values, within), event.p_value))
        found = replace(found, p_value=min(1.0, len(values) * found.p_value))  # Bonferroni
        first_p_value = found.p_value if not events else first_p_value
        few = freedom <= RULES.few_event_freedom
        large = _over_scatter(found, values, within) >= RULES.large_event
        most = RULES.event_p_value if not (few and large) else RULES.few_event_p_value
        most = RULES.further_event_p_value if events else most
        several = [found] if found.p_value <= most else []
        paired = least == 1 and len(np.unique(group)) > 1  # two runs of different repeats
        if not several and paired and freedom - len(events) > RULES.event_freedom:
            pairs = [_two_odd_runs(data, one, group, events) for one in values]
            several = min(pairs, key=lambda pair: pair[0].p_value)
            several = several if several[0].p_value <= RULES.further_event_p_value else []
        several = [event for event in several if _matters(event, values, within)]
        if not several:
            likely = found.kind in STEP_OR_DRIFT and found.p_value <= RULES.doubted_p_value
            if likely and not events and _matters(found, values, within):
                doubted = found
            elif not events:
                doubted = _course(data, values, group, within)
            break
        events += several
        measured = without_event(several[0], table, measured)
    return Series(freedom, first_p_value, tuple(events), doubted)


def of_the_other(event: Event, data: MeasurementSet) -> Event:
    """The event as it would be if not `event.run` but its repeat `event.other` were the odd run."""
    run = next(index for index, run in enumerate(data.runs) if run.name == event.other)
    size = 1.0 / (1.0 + event.size) - 1.0 if event.quantity == OUTPUT_SCALE else -event.size
    shape = (np.arange(len(data.runs)) == run).astype(float)
    return replace(
        event,
        run=event.other,
        before=data.runs[run - 1].name if run else "",
        size=size,
        pattern=replace(event.pattern, first=run, shape=shape),
        other=event.run,
    )


def without_event(event: Event, table: SampleTable, measured: Array) -> Array:
    """Measured outputs (samples,) as they would be without a step or a drift; events of other kinds
    change nothing.
    """
    if event.kind not in STEP_OR_DRIFT:
        return measured
    shape = event.pattern.shape[table.run]
    if event.quantity == OUTPUT_SCALE:
        return np.asarray(measured * np.exp(-np.log1p(event.size) * shape))
    return np.asarray(measured - event.size * shape * (table.output == event.output))


def group_of_runs(data: MeasurementSet) -> IntArray:
    """Number (runs,) of the group of repeats to which each run belongs."""
    group = np.zeros(len(data.runs), np.int64)
    for number, members in enumerate(data.groups()):
        group[members] = number
    return group


# ---------------------------------------------------------------------- patterns
def _patterns(data: MeasurementSet) -> Iterator[Pattern]:
    """All patterns; the simpler ones first, which win where two cannot be told apart."""
    count = len(data.runs)
    for run in range(count):
        yield Pattern(ODD_RUN, run, (np.arange(count) == run).astype(float))
    specimens = [run.specimen for run in data.runs]
    of_all = np.ones(count, bool)
    yield from _courses(of_all, "")
    if len(set(specimens)) > 1:
        for name in dict.fromkeys(specimens):
            yield from _courses(np.array([each == name for each in specimens]), name)


def _courses(member: Array, specimen: str) -> Iterator[Pattern]:
    """Steps and drifts of the runs of a specimen, or of all."""
    place = np.flatnonzero(member)
    order = np.arange(len(member), dtype=float)
    for first in place[1:].tolist():
        yield Pattern(STEP_EVENT, first, (member & (order >= first)).astype(float), specimen)
    if len(place) > 2:
        share = (order - place[0]) / (place[-1] - place[0])
        settled = 1.0 - np.exp(-share / SETTLING_RUNS)
        for shape in (share, settled / settled[place[-1]]):
            yield Pattern(DRIFT_EVENT, int(place[1]), np.where(member, shape, 0.0), specimen)


def _groups_changed(pattern: Pattern, group: IntArray) -> int:
    """Number of groups of repeats that a pattern lets differ."""
    return len(np.unique(group[np.abs(within_groups(pattern.shape, group)) > SAME_PATTERN]))


# ---------------------------------------------------------------------- the test
def _best(
    data: MeasurementSet,
    one: RunValues,
    patterns: Sequence[Pattern],
    group: IntArray,
    events: Sequence[Event],
) -> Event:
    """The pattern that explains most of the differences between repeats beyond known events."""
    taken = [event.pattern.shape for event in events if _concerns(event, one)]
    known = _basis([within_groups(shape, group) for shape in taken])
    shapes = _beyond(within_groups(np.stack([p.shape for p in patterns]), group), known)
    square = np.sum(shapes**2, axis=1)
    usable = square > 1e-6
    shapes = np.where(usable[:, None], shapes / np.sqrt(np.where(usable, square, 1.0))[:, None], 0)
    differences = _beyond(within_groups(one.values, group), known)
    whole = float(differences @ differences)
    explained = (shapes @ differences) ** 2
    freedom = len(group) - len(np.unique(group)) - len(taken)
    chosen = _chosen(patterns, explained, whole, freedom, one.values)
    share = float(explained[chosen]) / whole if whole > 0.0 else 0.0
    p_value = _p_value(share, shapes[usable], group, known, freedom)
    size = float(shapes[chosen] @ differences) / float(np.sqrt(square[chosen] or 1.0))
    pattern = patterns[chosen]
    if pattern.kind == ODD_RUN:
        return _odd_run(data, one, pattern.first, group, p_value)
    return Event(
        kind=pattern.kind,
        run=data.runs[pattern.first].name,
        before=_before(data, pattern),
        quantity=one.quantity,
        size=float(np.expm1(size)) if one.quantity == OUTPUT_SCALE else size,
        p_value=p_value,
        pattern=pattern,
        output=one.output,
        largest=_largest_input(data, pattern) if pattern.kind == STEP_EVENT else "",
    )


def _course(
    data: MeasurementSet, values: Sequence[RunValues], group: IntArray, within: float
) -> Event | None:
    """How repeats vary if most runs are like the one before, as where a finger ages, rests and ages
    again: their steps are smaller than chance makes them.
    """
    drawn = within_groups(
        np.random.default_rng(0).standard_normal((NORMAL_DRAWS, len(group))), group
    )
    by_chance = _roughness(drawn)
    found = []
    for one in values:
        about = within_groups(one.values, group)
        p_value = (1.0 + np.sum(by_chance <= _roughness(about))) / (1.0 + NORMAL_DRAWS)
        size = float(np.sqrt(np.mean(about**2)))
        if size < SAME_PATTERN:  # repeats without noise
            continue
        pattern = Pattern(SLOW_COURSE, 0, about / size)
        size = float(np.expm1(size)) if one.quantity == OUTPUT_SCALE else size
        event = Event(
            kind=SLOW_COURSE,
            run=data.runs[0].name,
            before="",
            quantity=one.quantity,
            size=size,
            p_value=float(p_value * len(values)),
            pattern=pattern,
            output=one.output,
        )
        if event.p_value <= RULES.event_p_value and _matters(event, values, within):
            found.append(event)
    return min(found, key=lambda event: event.p_value, default=None)


def _roughness(values: Array) -> Array:
    """Mean root of the steps between neighbours of values (..., runs), over that of their size; a
    few large steps count little.
    """
    size = np.sqrt(np.mean(values**2, axis=-1))
    steps = np.mean(np.sqrt(np.abs(np.diff(values, axis=-1))), axis=-1)
    return np.asarray(steps / np.sqrt(np.where(size > 0.0, size, 1.0)))


def _exchanged_runs(
    data: MeasurementSet, residual: Array, within: float, group: IntArray
) -> list[Event]:
    """Two odd runs, if repeats agree far better with the two exchanged; none otherwise."""
    found = exchanged_pair(data, residual, group)
    if found is None or found[1] > RULES.event_p_value:
        return []
    values = run_values(data.table, data.table.value, data.table.value - residual, data.of_hand)
    pair = [_odd_run(data, values[0], run, group, found[1]) for run in found[0]]
    return pair if all(_over_scatter(e, values, within) > RULES.event_error for e in pair) else []


def _two_odd_runs(
    data: MeasurementSet, one: RunValues, group: IntArray, events: Sequence[Event]
) -> list[Event]:
    """The two runs of different repeats that explain most if both are odd: each hides the other."""
    taken = [event.pattern.shape for event in events if _concerns(event, one)]
    known = _basis([within_groups(shape, group) for shape in taken])
    alone = _beyond(within_groups(np.eye(len(group)), group), known)
    differences = _beyond(within_groups(one.values, group), known)
    freedom = len(group) - len(np.unique(group)) - len(taken)
    pairs = [(i, j) for i, j in combinations(range(len(group)), 2) if group[i] != group[j]]
    rest = np.array([_left(differences, alone[list(pair)]) for pair in pairs])
    least = float(rest.min())
    about = np.abs(one.values - np.median(one.values))
    alike = [pair for pair, left in zip(pairs, rest, strict=True) if as_good(left, least, freedom)]
    chosen = max(alike, key=lambda pair: about[pair[0]] + about[pair[1]])
    whole = float(differences @ differences)
    ratio = (whole - least) / 2.0 / max(least / (freedom - 2), 1e-300)
    outputs = len(data.outputs)
    p_value = min(1.0, (1 + outputs) * len(pairs) * float(fdtrc(2, freedom - 2, ratio)))
    return [_odd_run(data, one, run, group, p_value) for run in chosen]


def _left(differences: Array, shapes: Array) -> float:
    """Sum of squares of differences (runs,) that some shapes (k, runs) leave."""
    found = np.linalg.lstsq(shapes.T, differences, rcond=None)[0]
    return float(np.sum((differences - found @ shapes) ** 2))


def _odd_run(
    data: MeasurementSet, one: RunValues, run: int, group: IntArray, p_value: float
) -> Event:
    mates = np.flatnonzero((group == group[run]) & (np.arange(len(group)) != run))
    size = float(one.values[run] - one.values[mates].mean()) if len(mates) else 0.0
    return Event(
        kind=ODD_RUN,
        run=data.runs[run].name,
        before=data.runs[run - 1].name if run else "",
        quantity=one.quantity,
        size=float(np.expm1(size)) if one.quantity == OUTPUT_SCALE else size,
        p_value=p_value,
        pattern=Pattern(ODD_RUN, run, (np.arange(len(group)) == run).astype(float)),
        output=one.output,
        other=data.runs[int(mates[0])].name if len(mates) == 1 else "",
    )


def _concerns(event: Event, one: RunValues) -> bool:
    """Whether an event has used up a degree of freedom of these values. Odd runs concern all."""
    same = (event.quantity, event.output) == (one.quantity, one.output)
    return same or event.kind not in STEP_OR_DRIFT


def _chosen(
    patterns: Sequence[Pattern], explained: Array, whole: float, freedom: int, values: Array
) -> int:
    """Index of the best pattern. Of those that repeats cannot tell from it, the one that explains
    most of the values as they are, with the errors that the model has in them.
    """
    rest = np.maximum(whole - explained, SAME_PATTERN * whole)
    alike = [n for n, left in enumerate(rest) if as_good(left, float(rest.min()), freedom)]
    return max(alike, key=lambda index: _along(patterns[index].shape, values))


def _along(shape: Array, values: Array) -> float:
    """Share of values (runs,) about their mean that a shape explains."""
    about, seen = values - values.mean(), shape - shape.mean()
    return float((seen @ about) ** 2 / ((seen @ seen) * (about @ about) or 1.0))


def _largest_input(data: MeasurementSet, pattern: Pattern) -> str:
    """Name of the run just before, or first after, a step that exceeds all inputs before it."""
    peaks = [
        float(np.max(data.driving(run)))
        for run in data.runs
        if pattern.specimen in ("", run.specimen)
    ]
    names = [run.name for run in data.runs if pattern.specimen in ("", run.specimen)]
    first = names.index(data.runs[pattern.first].name)
    for place in (first, first - 1):
        if place and peaks[place] > (1.0 + RULES.larger_input) * max(peaks[:place]):
            return names[place]
    return ""


def _before(data: MeasurementSet, pattern: Pattern) -> str:
    """Name of the run before the first that changed, of the same specimen if it is about one."""
    earlier = data.runs[: pattern.first]
    mine = [run for run in earlier if pattern.specimen in ("", run.specimen)]
    return mine[-1].name if mine else ""


def _basis(rows: Sequence[Array]) -> Array:
    """Orthonormal rows that span some rows (k, runs)."""
    if not rows:
        return np.zeros((0, 0))
    return np.asarray(np.linalg.qr(np.stack(rows).T)[0].T)


def _beyond(rows: Array, basis: Array) -> Array:
    """Rows (..., runs) less their part in the span of an orthonormal basis (k, runs)."""
    return rows - (rows @ basis.T) @ basis if basis.size else rows


def _p_value(share: float, shapes: Array, group: IntArray, known: Array, freedom: int) -> float:
    """Chance that the best of all patterns explains such a share of normal scatter: drawn, and
    where no drawn one does, from the F distribution times the number of patterns if that is less.
    """
    drawn = np.random.default_rng(0).standard_normal((NORMAL_DRAWS, len(group)))
    drawn = _beyond(within_groups(drawn, group), known)
    best = np.max((drawn @ shapes.T) ** 2, axis=1) / np.sum(drawn**2, axis=1)
    chance = (1.0 + np.sum(best >= share)) / (1.0 + NORMAL_DRAWS)
    ratio = share * (freedom - 1) / max(1.0 - share, 1e-300)
    bound = len(shapes) * float(fdtrc(1, freedom - 1, ratio))
    return float(min(chance, bound))


def _matters(event: Event, values: Sequence[RunValues], within: float) -> bool:
    """Whether the runs that an event changes change by so much more than they scatter within. One
    run alone may scatter more, as runs differ by more than their samples do.
    """
    least = RULES.odd_run_error if event.kind == ODD_RUN else RULES.event_error
    return _over_scatter(event, values, within) > least


def _over_scatter(event: Event, values: Sequence[RunValues], within: float) -> float:
    """Root mean square change of the runs that an event changes, over their scatter within."""
    one = next(v for v in values if (v.quantity, v.output) == (event.quantity, event.output))
    change = abs(event.size) * one.size * event.pattern.shape
    changed = event.pattern.shape > 0.0
    return float(np.sqrt(np.mean(change[changed] ** 2))) / within
