"""The table of the benchmark: one line a figure, with count and interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bench.lab.planning import broken, proposed, tied_with_truth
from bench.lab.scoring import after_over_floor, coverage, groups, mean_tie, right, wilson

Record = Mapping[str, Any]
Row = dict[str, Any]
TARGETS = {
    "catalogue": 0.95,
    "other form": 0.90,
    "pairs": 0.90,
    "triples": 0.75,
    "quadruples": 0.60,
    "nothing": 0.97,
    "outside": 0.92,
    "one rate": 0.90,
    "plan": 0.90,
}
TITLES = {
    "catalogue": "catalogue: right effect named, or in the tie",
    "other form": "other form: its family named",
    "pairs": "two effects: both named",
    "triples": "three effects: all named",
    "quadruples": "four effects: all named",
    "nothing": "nothing hidden: adequate",
    "outside": "outside the catalogue: unexplained",
    "one rate": "one rate only: the loops come out tied",
    "plan": "plan: the proposed experiment breaks the tie",
}
AFTER = {"catalogue": 1.2, "other form": 2.0}
COVERED = 0.90


def rate(name: str, hits: Sequence[bool], target: float | None) -> Row:
    """A rate with its Wilson interval."""
    low, high = wilson(sum(hits), len(hits))
    value = sum(hits) / len(hits) if hits else float("nan")
    met = None if target is None or not hits else value >= target
    return {"name": name, "n": len(hits), "value": value, "interval": [low, high]} | {
        "target": target,
        "met": met,
    }


def rows_of(records: Sequence[Record]) -> list[Row]:
    """All figures of finished sets; sets in which nothing shows are left out."""
    counted = [record for record in records if record["visible"]]
    rows = []
    for row, target in TARGETS.items():
        of_row = [record for record in counted if record["row"] == row]
        if row == "plan":
            rows.append(rate(TITLES[row], [broken(r) for r in of_row if _done(r)], target))
        elif of_row:
            rows.append(rate(TITLES[row], [right(record) for record in of_row], target))
            rows += _by(of_row, "experiment", row) if row == "catalogue" else []
            rows += _by(of_row, "noise", row) if row in ("catalogue", "nothing") else []
    rows += _after(counted) + _covered(counted)
    return [row for row in rows if row["n"]]


def _done(record: Record) -> bool:
    """Whether a proposed experiment was done on a set that held the truth in a tie."""
    return "before" in record and tied_with_truth(record) and proposed(record)


def _by(records: Sequence[Record], field: str, row: str) -> list[Row]:
    values = sorted({record[field] for record in records})
    return [
        rate(f"  {row}, {field} {value}", [right(r) for r in records if r[field] == value], None)
        for value in values
    ]


def _after(records: Sequence[Record]) -> list[Row]:
    rows = []
    for row, most in AFTER.items():
        found = [after_over_floor(record) for record in records if record["row"] == row]
        within = [value <= most for value in found if value is not None]
        rows.append(rate(f"{row}: held-out error after <= {most:g} x floor", within, 0.95))
    return rows


def _covered(records: Sequence[Record]) -> list[Row]:
    found = [coverage(record) for record in records if record["row"] == "catalogue"]
    sets = [inside for inside in found if inside is not None]
    each = [one for inside in sets for one in inside]
    return [
        rate(
            "parameters: all of a set within their 95 % intervals", [all(s) for s in sets], COVERED
        ),
        rate("  each parameter by itself", each, None),
    ]


def text_of(rows: Sequence[Row]) -> str:
    """Rows as text."""
    words = {True: "yes", False: "NO", None: "-"}
    lines = [["what", "n", "rate", "95 % interval", "target", "met"]]
    for row in rows:
        low, high = row["interval"]
        target = "-" if row["target"] is None else f">= {100 * row['target']:.0f} %"
        value = f"{100 * row['value']:.1f} %"
        between = f"{100 * low:.1f} .. {100 * high:.1f}"
        lines.append([row["name"], str(row["n"]), value, between, target, words[row["met"]]])
    widths = [max(len(line[k]) for line in lines) for k in range(6)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def notes_of(records: Sequence[Record]) -> list[str]:
    """What else to know: ties, time, sets left out, failures."""
    answered = [record for record in records if record.get("answer")]
    named = [record for record in answered if record["row"] in ("catalogue", "other form", "pairs")]
    seconds = sorted(record["seconds"] for record in answered)
    floors = [r["answer"]["noise_floor"] / r["truth"]["floor"] for r in answered]
    lines = [f"mean size of ties (names a group): {mean_tie(named):.2f}", *_plan_notes(records)]
    if seconds:
        middle, longest = seconds[len(seconds) // 2], seconds[-1]
        lines.append(f"seconds a diagnosis: median {middle:.1f}, longest {longest:.1f}")
        lines.append(f"stated floor over true one: median {sorted(floors)[len(floors) // 2]:.2f}")
    hidden = sum(not record["visible"] for record in records)
    lines.append(f"left out, since what is hidden does not reach twice the floor: {hidden}")
    failed = [record for record in records if record.get("error")]
    lines += [
        f"FAILED {r['case']} seed {r['seed']} noise {r['noise']}: {r['error']}" for r in failed
    ]
    return lines


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
    """One line for each set that was not right, with what was said instead."""
    lines = []
    for record in sorted(records, key=lambda r: (r["row"], r["case"], r["noise"], r["seed"])):
        if record["row"] == "plan":
            lines += [_still_tied(record)] if _done(record) and not broken(record) else []
        elif record["visible"] and not right(record):
            lines.append(
                f"{record['case']:52s} noise {record['noise']:g} seed {record['seed']} "
                f"ratio {record['truth']['ratio']:.1f}: {_said(record)}"
            )
    return lines


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
    return f"{answer['verdict']} {named} ({errors})"
