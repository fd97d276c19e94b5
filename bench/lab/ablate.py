"""Drop the rules of a verdict one by one: `python -m bench.lab.ablate [--minutes N] [--sets N]`.

Every set is fitted once; each rule is set to its neutral value in turn and the same fits are judged
again, with such further fits as the search then asks for. The table says for each rule how many
verdicts change, and how many become right or wrong. Sets are drawn from the hidden-effect bench
with a seed that is printed and that no rule was chosen with, and from the measurements by others
that SOFTHAND_MEASUREMENTS names, whole and in pieces (these have no truth: changes are counted
alone). --together drops the named rules all at once, and each alone where that changes something;
--rules names which of the others are dropped (default: all). A finished set is a line of
out/bench/ablation.jsonl under the revision of the code; a run that is stopped goes on.

Criterion, fixed before the run with seed 640527: a rule is deleted if, on 60 sets or more of all
rows, with 10 or more that hide nothing, 10 or more from outside the catalogue and 6 or more by
others, (a) no answer changes without it, neither here nor in the 40 sets of seed 971190, or (b) of
the fresh sets with a known truth more become right than wrong without it. Rules that meet it are
deleted together only if dropping them together makes no more sets wrong than right. A rule stays if
a test on a whole set fails without it, if it limits the effort of a search, or if it decides
something else that is reported, such as whether a parameter is known.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from bench.hidden.case import Case, visible
from bench.hidden.cases import all_cases
from bench.kept import append, read
from bench.lab import real, store
from bench.lab.scoring import right

LINES = store.OUT / "ablation.jsonl"
UNDER_WAY = store.OUT / "ablation-run.json"
LEFT_OUT = ("plan",)  # rows that are no single verdict
TOGETHER = "(together)"
PER_TURN = {"nothing": 3, "outside": 3, "scarce": 3}  # cases drawn in each turn, in place of one
Record = dict[str, Any]


def drawn(seed: int, count: int) -> list[tuple[Case, float]]:
    """Cases with a noise level each, from every row in turn, in an order drawn by a seed."""
    chance = random.Random(seed)
    of_row: dict[str, list[Case]] = defaultdict(list)
    for case in all_cases():
        if case.row not in LEFT_OUT:
            of_row[case.row].append(case)
    for cases in of_row.values():
        chance.shuffle(cases)
    found: list[tuple[Case, float]] = []
    while len(found) < count and any(of_row.values()):
        for row, cases in of_row.items():
            for case in [cases.pop() for _ in range(min(PER_TURN.get(row, 1), len(cases)))]:
                found.append((case, chance.choice(case.noises)))
    return found[:count]


def ablated(
    data: Any, model: Any, seed: int, names: Sequence[str] | None = None, group: Sequence[str] = ()
) -> Record:
    """What the lab says of a set with all rules, and without some of them where that differs.

    names: rules that are dropped alone, all if None. group: rules that are dropped together, and
    alone if that changes the answer.
    """
    from model_lab.diagnosis.diagnose import candidates_of, searched
    from model_lab.diagnosis.selection import select
    from model_lab.fitting.problem import pose_problem
    from model_lab.measurements.preprocess import thinned
    from model_lab.rules import RULES, neutral_rules
    from softhand_model.effects import effect_classes

    problem, given = pose_problem(thinned(data), model, effect_classes())
    problem = replace(problem, known={})
    candidates, _ = candidates_of(problem, model)
    search = partial(select, given=[effect.name for effect in given], seed=seed, jobs=1)
    said = _said(searched(problem, candidates, search))
    single = neutral_rules()
    without: Record = {}

    def drop(name: str, rules: Any) -> None:
        other = _said(searched(replace(problem, rules=rules), candidates, search))
        if other != said:
            without[name] = other

    for name in single if names is None else names:
        if name not in group:
            drop(name, single[name])
    if group:
        drop(TOGETHER, replace(RULES, **{name: getattr(single[name], name) for name in group}))
    if TOGETHER in without:
        for name in group:
            drop(name, single[name])
    return {"answer": said, "without": without}


def _said(judged: Any) -> Record:
    """The verdict, its names and ties, and what helps."""
    return {
        "verdict": judged.verdict,
        "effects": [{"name": name} for name in judged.added],
        "tied": [list(names) for names in judged.selection.ties] if judged.added else [],
        "helps": [scored.added for scored in judged.helping],
    }


def records(
    seed: int,
    count: int,
    revision: str,
    kept: Mapping[str, Record],
    names: Sequence[str] | None = None,
    group: Sequence[str] = (),
) -> Iterator[Record]:
    """Sets as they are done: those of others and their pieces first, then those of the bench."""
    from model_lab.measurements.load import load_measurements
    from softhand_model.model_file import load_model

    for name, whole in real.sets().items():
        for part, data in [("whole", whole), *real.pieces(whole)]:
            key = f"{name}: {part}|real|{revision}"
            if key not in kept:
                found = ablated(data, real.model_of(data)[1], 0, names, group)
                yield {"key": key, "row": "real", "visible": True} | found
    for case, noise in drawn(seed, count):
        first = store.first_seed(seed)
        key = store.key_of(case.name, first, noise, revision)
        if key in kept:
            continue
        with tempfile.TemporaryDirectory(prefix="bench-ablate-") as folder:
            truth = case.make(Path(folder), first, noise)
            shows = not case.hidden or visible(truth)
            found = {}
            if shows:
                data = load_measurements(folder)
                found = ablated(data, load_model("base"), first, names, group)
        expected = {
            "verdict": case.expected.verdict,
            "names": [sorted(names) for names in case.expected.names],
            "tied": sorted(case.expected.tied),
            "besides": sorted(case.expected.besides),
        }
        yield {"key": key, "row": case.row, "visible": shows, "expected": expected} | found


def table_of(found: Sequence[Record]) -> str:
    """One line a rule: verdicts or names that change without it, right and wrong ones gained."""
    from model_lab.rules import neutral_rules

    judged = [record for record in found if "answer" in record]
    lines = [f"{'rule':24s} {'changed':>8s} {'verdict':>8s} {'now right':>10s} {'now wrong':>10s}"]
    for name in (*neutral_rules(), TOGETHER):
        changed = [record for record in judged if name in record["without"]]
        verdicts = [r for r in changed if r["without"][name]["verdict"] != r["answer"]["verdict"]]
        known = [record for record in changed if "expected" in record]
        before = [right(record) for record in known]
        after = [right(record | {"answer": record["without"][name]}) for record in known]
        better = sum(b and not a for a, b in zip(before, after, strict=True))
        worse = sum(a and not b for a, b in zip(before, after, strict=True))
        lines.append(f"{name:24s} {len(changed):8d} {len(verdicts):8d} {better:10d} {worse:10d}")
    rows = {row: sum(r["row"] == row for r in judged) for row in sorted({r["row"] for r in judged})}
    said = [right(record) for record in judged if "expected" in record]
    lines.append(f"{len(judged)} sets: " + ", ".join(f"{n} {row}" for row, n in rows.items()))
    lines.append(f"right with all rules: {sum(said)} of {len(said)}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Ablate for some minutes, print the table."""
    parser = argparse.ArgumentParser(prog="bench.lab.ablate", description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, metavar="N", help="of a run to do again, from 1")
    parser.add_argument("--sets", type=int, default=60, help="with hidden effects")
    parser.add_argument("--rules", nargs="*", metavar="RULE", help="dropped alone (default: all)")
    parser.add_argument("--together", nargs="+", default=[], metavar="RULE", help="all at once")
    parser.add_argument("--minutes", type=float, default=60.0, help="start no further set after")
    chose = parser.parse_args(arguments)
    revision = store.revision_of_the_code()
    seed = chose.seed or store.seed_of_run({"ablate": revision}, UNDER_WAY)
    print(f"bench.lab.ablate: seed {seed}, revision {revision}", flush=True)
    kept = {k: one for k, one in read(LINES).items() if k.endswith(revision)}
    until = time.monotonic() + 60.0 * chose.minutes
    chosen = records(seed, chose.sets, revision, dict(kept), chose.rules, chose.together)
    for record in chosen:
        append(record, LINES)
        kept[record["key"]] = record
        print(f"{record['key']}: {', '.join(record.get('without', {})) or '-'}", file=sys.stderr)
        if time.monotonic() > until:
            print("bench.lab.ablate: time is over; run it again to go on")
            break
    print(table_of(list(kept.values())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
