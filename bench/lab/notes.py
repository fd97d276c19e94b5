"""What else to know beside the table: ties, time, sets left out, and what was named instead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bench.hidden.reserved import is_reserved
from bench.lab import learn
from bench.lab.planning import broken, proposed, tied_with_truth
from bench.lab.scoring import groups, is_guess, mean_tie, refused, right
from bench.lab.table import plan_done, verdicts
from model_lab.diagnosis.result import SLIP, UNEXPLAINED

Record = Mapping[str, Any]


def notes_of(records: Sequence[Record]) -> list[str]:
    """What else to know: ties, time, sets left out, failures."""
    answered = verdicts(records)
    named = [record for record in answered if record["row"] in ("catalogue", "other form", "pairs")]
    seconds = sorted(record["seconds"] for record in answered)
    floors = [r["answer"]["noise_floor"] / r["truth"]["floor"] for r in answered]
    lines = [f"mean size of ties (names a group): {mean_tie(named):.2f}", *_plan_notes(records)]
    if answered:
        middle, longest = seconds[len(seconds) // 2], seconds[-1]
        lines.append(f"seconds a diagnosis: median {middle:.1f}, longest {longest:.1f}")
        lines.append(f"stated floor over true one: median {sorted(floors)[len(floors) // 2]:.2f}")
        sure = [record for record in answered if not right(record) and not refused(record)]
        stated = sum(record["answer"]["confidence"] is not None for record in sure)
        slips = sum(record["answer"]["verdict"] == SLIP for record in answered)
        lines.append(f"wrong and sure: {len(sure)} of {len(answered)}, {stated} with a confidence")
        unnamed = [r for r in named if r["answer"]["verdict"] == UNEXPLAINED and not right(r)]
        helped = sum(family_helps(record) for record in unnamed)
        lines.append(f"unexplained, though known: {len(unnamed)}; its family helps in {helped}")
        lines.append(f"slips told where none is: {slips} of {len(answered)}")
    hidden = sum(not record["visible"] for record in records)
    lines.append(f"left out, since what is hidden does not reach twice the floor: {hidden}")
    failed = [record for record in records if record.get("error")]
    lines += [
        f"FAILED {r['case']} seed {r['seed']} noise {r['noise']}: {r['error']}" for r in failed
    ]
    return lines


def family_helps(record: Record) -> bool:
    """Whether the first effect that is said to help, without being the whole, is of the family of
    what is hidden.
    """
    known = {name for names in record["expected"]["names"] for name in names}
    helps = record["answer"].get("helps") or []
    return bool(helps) and helps[0]["name"] in known


def _plan_notes(records: Sequence[Record]) -> list[str]:
    """How many sets of the row `plan` end in a tie, and for how many nothing is proposed."""
    before = [record for record in records if "before" in record]
    if not before:
        return []
    tied = [record for record in before if tied_with_truth(record)]
    refused = sum(not proposed(record) for record in tied)
    return [
        f"plan: {len(tied)} of {len(before)} sets hold the truth in a tie; of these {refused} "
        "are said to be told apart by no experiment within the limits"
    ]


def misses_of(records: Sequence[Record]) -> list[str]:
    """One line for each set that was not right, with what was said instead.

    Families that are kept for blind runs are counted only: once seen they would be blind no more.
    """
    kept = [r for r in records if is_reserved(r["case"]) and r["visible"] and not right(r)]
    lines = [f"{len(kept)} sets of the families kept for blind runs"] if kept else []
    records = [record for record in records if not is_reserved(record["case"])]
    for record in sorted(records, key=lambda r: (r["row"], r["case"], r["noise"], r["seed"])):
        if record["row"] == "plan":
            lines += [_still_tied(record)] if plan_done(record) and not broken(record) else []
        elif record["row"] == "learn":
            lines += [] if record.get("right") else [_learned(record)]
        elif record["visible"] and not right(record):
            lines.append(
                f"{record['case']:52s} noise {record['noise']:g} seed {record['seed']} "
                f"ratio {record['truth']['ratio']:.1f}: {_said(record)}"
            )
    return lines


def _learned(record: Record) -> str:
    """A place of the effect that was learned wrongly."""
    said = learn.line_of(record) if "answer" in record else record.get("error", "no answer")
    return f"{record['case']:52s} seed {record['seed']}: {said}"


def _still_tied(record: Record) -> str:
    """A tie that the proposed experiment did not break."""
    said = [
        " + ".join("/".join(sorted(group)) for group in groups(answer)) or answer["verdict"]
        for answer in (record["before"], record["after"])
    ]
    planned = record["planned"]
    return (
        f"{record['case']:52s} noise {record['noise']:g} seed {record['seed']}: {said[0]} -> "
        f"{said[1]} by {planned['protocol']} {planned['changes']} {planned['separation']:.1f} sigma"
    )


def _said(record: Record) -> str:
    answer = record.get("answer")
    if answer is None:
        return record.get("error", "no answer")
    named = " + ".join("/".join(sorted(group)) for group in groups(answer))
    floor = answer["noise_floor"] or float("nan")
    errors = f"{answer['rmse_before'] / floor:.1f} -> {answer['rmse_after'] / floor:.2f} floors"
    sure = answer.get("confidence")
    guess = " (a guess)" if is_guess(record) else ""
    how = "" if sure is None else f", confidence {sure:.2f}{guess}"
    return f"{answer['verdict']} {named} ({errors}{how})"
