"""The table of the benchmark: one line a figure, with count and interval."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bench.hidden.people import DISTURBED, undisturbed
from bench.hidden.reserved import is_reserved
from bench.lab.planning import broken, proposed, tied_with_truth
from bench.lab.reliability import calibration_error, error_by_chance, error_interval
from bench.lab.scoring import (
    after_over_floor,
    coverage,
    is_guess,
    refused,
    right,
    wilson,
    wrong_alone,
    wrong_name,
)

Record = Mapping[str, Any]
Records = Sequence[Record]
Row = dict[str, Any]
TARGETS = {
    "catalogue": 0.97,
    "weak": 0.88,
    "other form": 0.93,
    "pairs": 0.90,
    "triples": 0.75,
    "quadruples": 0.60,
    "nothing": 0.97,
    "outside": 0.92,
    "one rate": 0.90,
}
TITLES = {
    "catalogue": "catalogue: right effect named, or in the tie",
    "weak": "weak (two to three floors): named, or in the tie",
    "other form": "other form: its family named",
    "pairs": "two effects: both named",
    "triples": "three effects: all named",
    "quadruples": "four effects: all named",
    "nothing": "nothing hidden: adequate",
    "outside": "outside the catalogue: unexplained",
    "one rate": "one rate only: the loops come out tied",
}
ROWS = (*TARGETS, "scarce", *DISTURBED, "plan", "learn")
PARTS = {"catalogue": ("experiment", "noise"), "nothing": ("noise",), "weak": ("ratio",)}
NOT_COUNTED = ("plan", "learn")  # of the rows, among verdicts
AFTER = {"catalogue": 1.2, "other form": 2.0}
COVERED = (0.92, 0.98)
NEAR_CLEAN = 0.03  # below the same sets undisturbed
CALIBRATED, REFUSED = 0.04, 0.80


def figure(
    name: str,
    count: int,
    value: float,
    interval: tuple[float, float],
    least: float | None = None,
    most: float | None = None,
) -> Row:
    """One figure with its 95 % interval; target: what it must reach, may be, or both ends."""
    met = (least is None or value >= least) and (most is None or value <= most)
    target = [least, most] if least is not None and most is not None else None
    return {"name": name, "n": count, "value": value, "interval": list(interval)} | {
        "target": target or (most if least is None else least),
        "target_text": _target_text(least, most),
        "met": met if count and (least is not None or most is not None) else None,
    }


def _target_text(least: float | None, most: float | None) -> str:
    if least is not None and most is not None:
        return f"{100 * least:.0f} .. {100 * most:.0f} %"
    if least is None and most is None:
        return "-"
    return f">= {100 * least:.0f} %" if least is not None else f"<= {100 * (most or 0.0):.0f} %"


def rate(
    name: str, hits: Sequence[bool], least: float | None = None, most: float | None = None
) -> Row:
    """A share with its Wilson interval."""
    value = sum(hits) / len(hits) if hits else float("nan")
    return figure(name, len(hits), value, wilson(sum(hits), len(hits)), least, most)


def judged(records: Records, row: str) -> list[Record]:
    """The sets of a row in which what is hidden shows.

    Weak are the catalogue's weakest effects too, which lie in both rows.
    """
    found = [record for record in records if record["visible"] and record["row"] == row]
    if row == "weak":
        more = judged(records, "catalogue")
        found += [record for record in more if record["case"].endswith("/weak")]
    return found


def rows_of(records: Records) -> list[Row]:
    """All figures of finished sets; rows without a set are left out."""
    rows: list[Row] = []
    for row, target in TARGETS.items():
        of_row = judged(records, row)
        rows.append(rate(TITLES[row], _each(right, of_row), target))
        for field in PARTS.get(row, ()):
            rows += _by(of_row, field, row)
        if row == "weak":
            rows.append(
                rate("weak: a wrong name without a tie", _each(wrong_alone, of_row), most=0.04)
            )
        if row == "outside":
            unseen = [record for record in of_row if is_reserved(record["case"])]
            rows.append(rate("  outside, families kept for blind runs", _each(right, unseen)))
    rows += [*_scarce(judged(records, "scarce")), *_disturbed(records), *_plan(records)]
    rows += [*_learned(judged(records, "learn")), *_sure(verdicts(records))]
    rows += [*_after(records), *_covered(judged(records, "catalogue"))]
    return [row for row in rows if row["n"]]


def verdicts(records: Records) -> list[Record]:
    """Sets with one verdict each."""
    return [
        record
        for record in records
        if record["visible"] and record.get("answer") and record["row"] not in NOT_COUNTED
    ]


def _each(question: Callable[[Record], bool], records: Records) -> list[bool]:
    return [question(record) for record in records]


def _by(records: Records, field: str, row: str) -> list[Row]:
    values = sorted({record[field] for record in records})
    return [
        rate(f"  {row}, {field} {value}", [right(r) for r in records if r[field] == value])
        for value in values
    ]


def _scarce(records: Records) -> list[Row]:
    sure = [wrong_name(record) and not is_guess(record) for record in records]
    said = [right(record) or refused(record) for record in records]
    return [
        rate("scarce: right, or refused", said, 0.97),
        rate("  scarce: right", _each(right, records)),
        rate("scarce: a wrong name that is not said as a guess", sure, most=0.03),
        rate("  scarce: a wrong name, guesses too", _each(wrong_name, records)),
    ]


def _disturbed(records: Records) -> list[Row]:
    """Disturbed sets beside the same effects in clean ones."""
    names, rows = undisturbed(), []
    clean = [r for r in records if r["visible"] and r["case"] in names and r["noise"] == 0.006]
    value = sum(_each(right, clean)) / len(clean) if clean else None
    if any(judged(records, way) for way in DISTURBED):
        rows.append(rate("as clean: the same effects, undisturbed", _each(right, clean)))
    for way in DISTURBED:
        least = None if value is None else value - NEAR_CLEAN
        rows.append(rate(f"{way}: right", _each(right, judged(records, way)), least))
    return rows


def _plan(records: Records) -> list[Row]:
    done = [broken(record) for record in judged(records, "plan") if plan_done(record)]
    return [rate("plan: the proposed experiment breaks the tie", done, 0.90)]


def plan_done(record: Record) -> bool:
    """Whether a proposed experiment was done on a set that held the truth in a tie."""
    return "before" in record and tied_with_truth(record) and proposed(record)


def _learned(records: Records) -> list[Row]:
    hidden = [r for r in records if "answer" not in r or r["truth"]["hidden"]]
    nothing = [r for r in records if r not in hidden]
    return [
        rate("learn: stage and axis right", [bool(r.get("right")) for r in hidden], 0.80),
        rate("  learn: right, or in the tie", [bool(r.get("tied")) for r in hidden]),
        rate("learn: held-out error <= 1.5 floors", [bool(r.get("near")) for r in hidden], 0.80),
        rate("  learn: nothing where nothing is hidden", [bool(r.get("right")) for r in nothing]),
    ]


def _sure(records: Records) -> list[Row]:
    """Whether confidence comes true, and what is refused."""
    stated = [record for record in records if record["answer"].get("confidence") is not None]
    said, true = [r["answer"]["confidence"] for r in stated], _each(right, stated)
    wrong = [record for record in stated if not right(record)]
    fine = [record for record in stated if right(record)]
    error = calibration_error(said, true) if stated else float("nan")
    chance = f"  confidence: the same if it held exactly, of {len(stated)} sets"
    interval, by_chance = error_interval(said, true), error_by_chance(said)
    return [
        figure(
            "confidence: expected calibration error", len(stated), error, interval, most=CALIBRATED
        ),
        figure(chance, len(stated), by_chance, (by_chance, by_chance)),
        rate("confidence: refused among the wrong ones", _each(refused, wrong), REFUSED),
        rate("  confidence: said as a guess among the wrong ones", _each(is_guess, wrong)),
        rate("  confidence: said as a guess among the right ones", _each(is_guess, fine)),
    ]


def _after(records: Records) -> list[Row]:
    rows = []
    for row, most in AFTER.items():
        found = [after_over_floor(record) for record in judged(records, row)]
        within = [value <= most for value in found if value is not None]
        rows.append(rate(f"{row}: held-out error after <= {most:g} x floor", within, 0.95))
    return rows


def _covered(records: Records) -> list[Row]:
    sets = [inside for inside in map(coverage, records) if inside is not None]
    each = [one for inside in sets for one in inside]
    return [
        rate("parameters: within their 95 % intervals", each, *COVERED),
        rate("  parameters: all of a set within", [all(inside) for inside in sets]),
    ]


def text_of(rows: Sequence[Row]) -> str:
    """Rows as text."""
    words = {True: "yes", False: "NO", None: "-"}
    lines = [["what", "n", "value", "95 % interval", "target", "met"]]
    for row in rows:
        low, high = row["interval"]
        value = f"{100 * row['value']:.1f} %"
        between = f"{100 * low:.1f} .. {100 * high:.1f}"
        lines.append(
            [row["name"], str(row["n"]), value, between, row["target_text"], words[row["met"]]]
        )
    widths = [max(len(line[k]) for line in lines) for k in range(6)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )
