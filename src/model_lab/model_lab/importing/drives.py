"""Which runs were driven alike. Only those repeat each other, whatever their names say: a model
errs differently on a slow and on a fast ramp, which is no noise.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from string import ascii_lowercase

import numpy as np
from scipy.ndimage import median_filter

from model_lab.aliases import Array
from model_lab.importing.runs import ImportedRun
from model_lab.importing.specimens import Assigned

ALIKE_RANGES = 1.2  # ratio of the ranges of two inputs, and of their paces, up to which repeats by
ALIKE_PACES = 1.7  # hand differ; both chosen by hand
TURN = 0.1  # of the range of an input, from which its course has turned
SPIKE = 3  # samples, of which the middle one counts if it is the median


def protocols_by_drive(
    found: Assigned, runs: Sequence[ImportedRun], driving: str, modes: Mapping[str, str]
) -> dict[str, str]:
    """The protocol of each run, by its name: as `found` from the names, but runs of one protocol
    that were driven otherwise get one of their own, with a letter.

    driving: name of the input. modes: of each run in a test of rubber.
    """
    kinds: dict[tuple[str, str, str], list[tuple[float, float]]] = defaultdict(list)
    protocols = {}
    for run in runs:
        name = found.protocols[run.name]
        kind = kinds[found.specimens[run.name], name, modes.get(run.name, "")]
        drive = range_and_pace(run, driving)
        number = next((at for at, other in enumerate(kind) if _alike(drive, other)), len(kind))
        if number == len(kind):
            kind.append(drive)
        protocols[run.name] = f"{name}_{_letters(number)}" if number else name
    return protocols


def range_and_pace(run: ImportedRun, driving: str) -> tuple[float, float]:
    """Range of the input of a run, in its unit, and the mean rate [unit/s] at which it rises and
    falls between the first and the last time above a tenth of its range; 0 without a clock.

    >>> time = np.arange(11.0)
    >>> pressure = np.interp(time, [0.0, 4.0, 6.0, 10.0], [0.0, 8.0, 8.0, 0.0])
    >>> range_and_pace(ImportedRun("r", {"time": time, "p": pressure}, {}, ()), "p")
    (8.0, 1.6)
    """
    lead, course = (part.get(driving, np.zeros(0)) for part in (run.lead, run.columns))
    value = median_filter(np.concatenate([lead, course]), SPIKE, mode="nearest")
    extent = float(np.ptp(value))
    if "time" not in run.columns or extent == 0.0:
        return extent, 0.0
    time = np.concatenate([run.lead.get("time", np.zeros(0)), run.columns["time"]])
    driven = np.flatnonzero(np.abs(value - value[0]) > TURN * extent)
    first, last = max(int(driven[0]) - 1, 0), min(int(driven[-1]) + 1, len(value) - 1)
    return extent, _travelled(value[first : last + 1], TURN * extent) / float(
        time[last] - time[first]
    )


def _travelled(value: Array, least: float) -> float:
    """The way that a course goes up and down, without turns of less than `least`, which are noise.

    >>> _travelled(np.array([0.0, 5.0, 4.9, 8.0, 0.0]), 1.0)
    16.0
    """
    turns = [float(value[0])]
    extreme = turns[0]
    rises = bool(value[int(np.argmax(np.abs(value - value[0]) >= least))] > value[0])
    for now in map(float, value):
        if (now > extreme) == rises:
            extreme = now
        elif abs(now - extreme) >= least:
            turns.append(extreme)
            extreme, rises = now, not rises
    return float(np.sum(np.abs(np.diff([*turns, extreme]))))


def _alike(one: tuple[float, float], other: tuple[float, float]) -> bool:
    pairs = zip(one, other, (ALIKE_RANGES, ALIKE_PACES), strict=True)
    return all(max(a, b) <= most * min(a, b) for a, b, most in pairs)


def _letters(number: int) -> str:
    """b, c, ..., z, 27, 28, ...: 0 is the protocol that needs none."""
    return ascii_lowercase[number] if number < len(ascii_lowercase) else str(number + 1)
