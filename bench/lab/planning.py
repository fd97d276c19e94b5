"""Sets that end in a tie: the proposed experiment is done, and the set is judged again."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.hidden.case import Case
from bench.hidden.design import ExtraRun
from bench.hidden.sets.writing import append_runs
from bench.lab.adapter import diagnosis_of
from bench.lab.scoring import groups

REPEATS = 2
SAID = ("verdict", "effects", "tied")


def answers(case: Case, folder: Path, seed: int, noise: float) -> dict[str, Any]:
    """What is said of a set before and after the experiment that is proposed for it.

    Without `after` nothing was proposed, or nothing that was said to break a tie.
    """
    before = diagnosis_of(folder, seed)
    planned = before["next_experiment"]
    record: dict[str, Any] = {"before": {name: before[name] for name in SAID}}
    if planned is None:
        return record
    record["planned"] = {name: value for name, value in planned.items() if name != "inputs"}
    if not planned["breaks"]:
        return record
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as place:
        longer = Path(place) / "longer"
        case.make(longer, seed, noise, (_extra(planned),) * REPEATS)
        append_runs(folder, longer)
    after = diagnosis_of(folder, seed)
    return record | {"after": {name: after[name] for name in SAID}}


def _extra(planned: Mapping[str, Any]) -> ExtraRun:
    """The proposed run as the generator takes it."""
    inputs = planned["inputs"]
    drive = inputs["pressure"] if "pressure" in inputs else np.array(inputs["stretch"]) - 1.0
    changes = {"mount": planned["mount"]}
    changes |= {key: planned[key] for key in ("wall", "length") if planned[key] is not None}
    return ExtraRun(
        planned["protocol"],
        planned["specimen"],
        planned["temperature"],
        np.array(inputs["time"]),
        np.array(drive),
        changes,
    )


def tied_with_truth(record: Mapping[str, Any]) -> bool:
    """Whether the first answer holds the hidden effect in a tie."""
    group = group_with(record["before"], record["expected"]["names"][0])
    return group is not None and len(group) > 1


def proposed(record: Mapping[str, Any]) -> bool:
    """Whether an experiment was proposed that is said to break the tie."""
    return "after" in record


def broken(record: Mapping[str, Any]) -> bool:
    """Whether the experiment left fewer names beside the hidden effect, and the effect in."""
    names = record["expected"]["names"][0]
    before, after = group_with(record["before"], names), group_with(record["after"], names)
    return before is not None and after is not None and len(after) < len(before)


def group_with(answer: Mapping[str, Any], names: list[str]) -> set[str] | None:
    """The group of names that holds one of these."""
    return next((group for group in groups(answer) if set(names) & group), None)
