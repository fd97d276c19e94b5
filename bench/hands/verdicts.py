"""Verdicts on hands in which an effect was hidden: each case as a row, and sums."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench import kept
from bench.lab.reliability import calibration_error, error_by_chance
from bench.lab.scoring import wilson
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect
from softhand_model.model_file import load_model

KEPT = Path("out/bench")
FLOORS_AFTER = 2.0
NAMED_ALONE = ("strong", "weak")  # groups with one hidden effect
SOURCES = ("src/model_lab", "src/softhand_model", "src/pneuflex_sim", "bench/hands")


def judge(
    bench: str,
    numbers: Sequence[int],
    make: Callable[[int], tuple[Any, MeasurementSet]],
    unit: str,
    classes: Mapping[str, type[Effect]] | None = None,
    seed: int | None = None,
) -> None:
    """Diagnose the cases of these numbers; print a row for each, and sums. A case is kept in
    `out/bench` as it ends, and is not run again while the code stays.

    bench: name of the folder of the bench. make: gives what is hidden in a case (name, strength,
    where, value) and its set; unit: of the errors, a thousandth of the set's; classes: effects
    that are searched, all if None; seed: by which the cases were drawn.
    """
    revision = kept.revision_of((*SOURCES, f"bench/{bench}"), (".py", ".yaml"))
    file = KEPT / f"{bench}.jsonl"
    print(f"| # | hidden | where | verdict | named | before, after, floor [{unit}] | s | score |")
    print("|---|---|---|---|---|---|---|---|")
    records = []
    for number in numbers:
        key = f"{revision}/{number}" if seed is None else f"{revision}/{seed}/{number}"
        record = kept.read(file).get(key)
        if record is None:
            hidden, data = make(number)
            begun = time.process_time()
            answer = diagnose(data, load_model(), classes).diagnosis.as_json()
            took = time.process_time() - begun
            record = {"key": key, **_record(number, hidden, answer, took)}
            kept.append(record, file)
        print(record["row"], flush=True)
        records.append(record)
    _print_sums(records)


def _record(number: int, hidden: Any, answer: dict[str, Any], took: float) -> dict[str, Any]:
    """A case as it is kept."""
    score, holds, named = scored(hidden, answer), None, answer["effects"]
    if score == "right" and hidden.value is not None:
        (parameter,) = answer["effects"][0]["parameters"].values()
        low, high = parameter["interval"]
        holds = bool(low <= hidden.value <= high)
    sure = answer["confidence"] is not None and not answer["guess"]
    return {
        "group": hidden.strength or hidden.name,
        "score": score,
        "holds": holds,
        "over_floor": answer["rmse_after"] / answer["noise_floor"],
        "wrong_and_sure": score == "wrong" and sure,
        "place": named[0].get("where", {}) == hidden.where
        if hidden.strength in NAMED_ALONE and [one["name"] for one in named] == [hidden.name]
        else None,
        "confidence": answer["confidence"],
        "seconds": took,
        "row": row_of(number, hidden, answer, took, score),
        "answer": {key: answer[key] for key in KEPT_OF_ANSWER},
    }


KEPT_OF_ANSWER = (
    *("verdict", "effects", "tied", "ranking", "helps", "slips", "noise_floor_parts"),
    "evidence",  # from which a confidence can be fitted
)


def _print_sums(records: Sequence[dict[str, Any]]) -> None:
    """Scores by group, intervals and errors."""
    print("\n| group | sets | scores | right, 95 % interval |\n|---|---|---|---|")
    for group in dict.fromkeys(record["group"] for record in records):
        found = [record["score"] for record in records if record["group"] == group]
        counts = ", ".join(f"{found.count(one)} {one}" for one in sorted(set(found)))
        low, high = wilson(found.count("right"), len(found))
        print(f"| {group} | {len(found)} | {counts} | {low:.2f} to {high:.2f} |")
    right = [record for record in records if record["score"] == "right"]
    holds = [record["holds"] for record in right if record["holds"] is not None]
    over = [record["over_floor"] for record in right if record["answer"]["effects"]]
    print(f"\nwrong and sure: {sum(record['wrong_and_sure'] for record in records)}")
    print(f"intervals that hold the truth: {sum(holds)} of {len(holds)}")
    if over:
        within = sum(one <= FLOORS_AFTER for one in over)
        print(
            f"error after adding over the floor: median {np.median(over):.2f}, max {max(over):.2f}"
            f"; at most {FLOORS_AFTER:g} in {within} of {len(over)}"
        )
    places = [record["place"] for record in records if record.get("place") is not None]
    print(f"right place of those whose effect is right: {sum(places)} of {len(places)}")
    stated = [record for record in records if record.get("confidence") is not None]
    sure, true = [one["confidence"] for one in stated], [one["score"] == "right" for one in stated]
    error, chance = calibration_error(sure, true), error_by_chance(sure)
    print(f"calibration error of {len(stated)} confidences: {error:.3f} (by chance {chance:.3f})")
    took = [record["seconds"] for record in records if "seconds" in record]
    if took:
        print(f"processor time [s]: median {np.median(took):.0f}, max {max(took):.0f}")


def scored(hidden: Any, answer: dict[str, Any]) -> str:
    """Score of a verdict by the criteria that the bench states."""
    verdict, named = answer["verdict"], answer["effects"]
    if hidden.name == "nothing":
        return "right" if verdict == "adequate" else "wrong" if named else verdict
    if hidden.strength == "outside":
        return "right" if verdict == "unexplained" else "wrong" if named else verdict
    if hidden.strength == "control":
        return "wrong" if named else verdict if verdict == "adequate" else "right"
    if hidden.strength == "slip":
        found = [(slip["name"], slip["column"]) for slip in answer["slips"]]
        return "right" if found == [hidden.slip] and not named else "wrong"
    if verdict != "effects_missing":
        return str(verdict)
    if hidden.strength == "two":
        places = [(effect["name"], effect.get("where", {})) for effect in named]
        if any(place not in hidden.both for place in places):
            return "wrong"
        return "right" if len(places) == len(hidden.both) else "one of two"
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
