"""Verdicts on hands in which an effect was hidden: each case as a row, and sums."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect
from softhand_model.model_file import load_model


def judge(
    cases: int,
    make: Callable[[int], tuple[Any, MeasurementSet]],
    unit: str,
    classes: Mapping[str, type[Effect]] | None = None,
) -> None:
    """Diagnose the cases whose numbers the command line gives, or all; print a row for each, and
    sums. make: gives what is hidden in a case (name, strength, where, value) and its set; unit: of
    the errors, a thousandth of the set's; classes: effects that are searched, all if None.
    """
    chosen = [int(text) for text in sys.argv[1:]] or range(cases)
    print(f"| # | hidden | where | verdict | named | before, after, floor [{unit}] | s | score |")
    print("|---|---|---|---|---|---|---|---|")
    scores: dict[str, list[str]] = {}
    sure, holds = 0, []
    for number in chosen:
        hidden, data = make(number)
        begun = time.process_time()
        answer = diagnose(data, load_model(), classes).diagnosis.as_json()
        took = time.process_time() - begun
        score = scored(hidden, answer)
        sure += score == "wrong" and answer["confidence"] is not None and not answer["guess"]
        if score == "right" and hidden.value is not None:
            (parameter,) = answer["effects"][0]["parameters"].values()
            low, high = parameter["interval"]
            holds.append(low <= hidden.value <= high)
        scores.setdefault(hidden.strength or hidden.name, []).append(score)
        print(row_of(number, hidden, answer, took, score), flush=True)
    print("\n| group | sets | scores |\n|---|---|---|")
    for group, found in scores.items():
        counts = ", ".join(f"{found.count(one)} {one}" for one in sorted(set(found)))
        print(f"| {group} | {len(found)} | {counts} |")
    print(f"\nwrong and sure: {sure}; intervals that hold the truth: {sum(holds)} of {len(holds)}")


def scored(hidden: Any, answer: dict[str, Any]) -> str:
    """Score of a verdict by the criteria that the bench states."""
    verdict, named = answer["verdict"], answer["effects"]
    if hidden.name == "nothing":
        return "right" if verdict == "adequate" else "wrong" if named else verdict
    if hidden.strength == "outside":
        return "right" if verdict == "unexplained" else "wrong" if named else verdict
    if hidden.strength == "control":
        return "wrong" if named else verdict if verdict == "adequate" else "right"
    if verdict != "effects_missing":
        return str(verdict)
    truth = hidden.name, hidden.where
    if len(named) == 1 and (named[0]["name"], named[0].get("where", {})) == truth:
        return "right"
    place = f"{hidden.name}[{'>'.join(hidden.where.values())}]" if hidden.where else hidden.name
    return "tied" if any(place in tied for tied in answer["tied"]) else "wrong"


def row_of(number: int, hidden: Any, answer: dict[str, Any], took: float, score: str) -> str:
    """A row of the table: number, what is hidden, answer as JSON, processor time [s] and score."""
    named = "; ".join(
        f"{effect['name']} {'>'.join(effect.get('where', {}).values())} "
        + ", ".join(f"{key} {one['value']:.3g}" for key, one in effect["parameters"].items())
        for effect in answer["effects"]
    )
    errors = ", ".join(
        f"{1e3 * answer[key]:.2f}" for key in ("rmse_before", "rmse_after", "noise_floor")
    )
    cells = (
        number,
        f"{hidden.name} {hidden.strength}".strip(),
        ">".join(hidden.where.values()),
        answer["verdict"],
        named,
        errors,
        f"{took:.0f}",
        score,
    )
    return "| " + " | ".join(map(str, cells)) + " |"
