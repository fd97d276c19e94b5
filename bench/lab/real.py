"""Measurements by others: named or learned, and how far the held-out error falls.

`python -m bench.lab.real [--only WORD ...] [--pieces] [--learn]`, or row `real` of `bench.lab`: for
every set in the folder that SOFTHAND_MEASUREMENTS names, what `diagnose` names and what `learn`
learns, each with the model that it would be tried with (`base`, or `linear` for an actuator of
another make). --pieces: parts of the sets stand for sets that nobody here has seen: a mode, every
other run, one run, few samples, small inputs; --learn: nothing is diagnosed.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

VARIABLE = "SOFTHAND_MEASUREMENTS"
OUT = Path("out/bench/bench-real.json")
FALL = 3.0  # of the held-out error
SHARE = 5.0 / 6.0  # of the sets
SECONDS = 60.0  # of processor time that `learn` may take
COARSE, FEWEST = 4, 80  # every so many samples, of runs of so many at least
SMALL = 0.7  # of the input's range
Record = dict[str, Any]


def sets() -> dict[str, Any]:
    """Measurement sets of the folder by name; none without it."""
    from model_lab.measurements.load import load_measurements

    folder = os.environ.get(VARIABLE)
    paths = sorted(Path(folder).glob("*/experiment.yaml")) if folder else []
    return {path.parent.name: load_measurements(path.parent) for path in paths}


def pieces(data: Any) -> Iterator[tuple[str, Any]]:
    """Parts of a set that could be sets of their own, by name."""
    runs = data.runs
    for mode in dict.fromkeys(run.mode for run in runs if run.mode):
        yield mode, replace(data, runs=tuple(run for run in runs if run.mode == mode))
    if len(runs) > 3:
        yield "odd runs", replace(data, runs=runs[::2])
        yield "even runs", replace(data, runs=runs[1::2])
        yield "last run", replace(data, runs=runs[-1:])
    if min(run.samples for run in runs) >= FEWEST:
        yield (
            "few samples",
            replace(data, runs=tuple(_kept(r, slice(None, None, COARSE)) for r in runs)),
        )
    if len(runs) == 1:
        driving = data.driving(runs[0])
        small = driving <= driving.min() + SMALL * np.ptp(driving)
        yield "small inputs", replace(data, runs=(_kept(runs[0], small),))


def _kept(run: Any, which: Any) -> Any:
    return replace(run, columns={name: values[which] for name, values in run.columns.items()})


def record_of(name: str, data: Any, diagnosed: bool = True) -> Record:
    """What is said of a set: effects that are named, the curves that are learned, errors."""
    from model_lab.diagnosis.diagnose import diagnose
    from model_lab.learning.learn import learn

    chosen, model = model_of(data)
    record: Record = {"set": name, "model": chosen, "named": [], "fall_named": 1.0}
    if diagnosed:
        found = diagnose(data, model, jobs=1).diagnosis
        record["named"] = [effect.name for effect in found.effects]
        record["fall_named"] = found.rmse_before / found.rmse_after if found.effects else 1.0
    started = time.process_time()
    learned = learn(data, model)
    record["seconds"] = time.process_time() - started
    shapes = [one.shape for one in learned.curves]
    record["learned"] = [f"{s.stage} {s.form}, {s.abscissa.partition(' [')[0]}" for s in shapes]
    before, after = learned.base.held_out.rmse, learned.final.held_out.rmse
    record |= {"before": before, "after": after, "floor": learned.problem.floor.total}
    return record | {"unit": data.unit, "fall_learned": before / after, "reason": learned.reason}


def model_of(data: Any) -> tuple[str, Any]:
    """The base model, or `linear` for an actuator whose inside is not stated."""
    from model_lab.comparison.compare import errors_of
    from softhand_common.documents.yaml_document import DocumentError
    from softhand_model.model_file import load_model

    try:
        errors_of(data, load_model("base"))
    except DocumentError:
        return "linear", load_model("linear")
    return "base", load_model("base")


def fall_of(record: Record) -> float:
    """Error before over after, by names or by curves, whichever is more."""
    return float(max(record["fall_named"], record["fall_learned"]))


def lines_of(record: Record) -> str:
    """One set in one line."""
    from model_lab.measurements.units import display_of

    shown = display_of(record["unit"]).shown
    names = " + ".join(record["named"]) or "-"
    curves = " + ".join(record["learned"]) or record["reason"] or "-"
    return (
        f"{'ok ' if fall_of(record) >= FALL else 'NO '} {record['set']:38s} named: {names} "
        f"({record['fall_named']:.1f}); learned: {curves}: {shown(record['before'])} -> "
        f"{shown(record['after'])} ({record['fall_learned']:.1f}), {record['seconds']:.0f} s"
    )


def summary(records: list[Record]) -> list[str]:
    """How many sets come to the target, and the longest `learn`."""
    if not records:
        return [f"real: no measurements; {VARIABLE} names no folder of sets"]
    good = sum(fall_of(record) >= FALL for record in records)
    longest = max(record["seconds"] for record in records)
    met = good >= SHARE * len(records)
    return [
        f"real: held-out error falls by {FALL:g} or more, named or learned: {good} of "
        f"{len(records)} (target 5 of 6: {'yes' if met else 'NO'}); longest learn {longest:.0f} s "
        f"of processor time (target {SECONDS:g})"
    ]


def measure_real(only: list[str], parts: bool = False, diagnosed: bool = True) -> list[Record]:
    """Records of the sets whose name holds one of the words (all if none), printed on the way."""
    records = []
    for name, data in sets().items():
        if only and not any(word in name for word in only):
            continue
        whole = [(name, data)]
        some = [(f"{name}: {part}", piece) for part, piece in pieces(data)] if parts else whole
        for title, piece in some:
            records.append(record_of(title, piece, diagnosed))
            print(lines_of(records[-1]), flush=True)
    return records


def main(arguments: list[str] | None = None) -> int:
    """Learn, print, write."""
    parser = argparse.ArgumentParser(prog="bench.lab.real", description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD")
    parser.add_argument("--pieces", action="store_true", help="parts of the sets")
    parser.add_argument("--learn", action="store_true", help="learn alone")
    chose = parser.parse_args(arguments)
    records = measure_real(chose.only, chose.pieces, not chose.learn)
    print(*summary(records), sep="\n")
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps(records, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
