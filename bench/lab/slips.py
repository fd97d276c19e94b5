"""How often the lab finds a slip, and how often it tells one where there is none.

    python -m bench.lab.slips [--development] [--part N] [--rows ROW ...] [--minutes M]

Each set is kept in out/bench/bench-lab-slips.jsonl as it ends, under the revision of the code: a
run that was stopped goes on.

Every kind of slip is put into sets of the independent generator `bench.hidden`: with nothing
hidden, with a hidden effect, of another make of actuator, and scarce ones. The formulas by which
slips are put in stand here and not in the lab.

A slip counts where it shows: it raises the error of the model, the calibration refitted, at least
to SHOWS times what it is without it. Criteria, written before the run:

* found: the first slip that is told has the right name and column, and the right unit to within the
  15 % that the calibration may take up: at least 90 % of each kind over all experiments;
* both named: where a hidden effect is there too, `diagnose` tells the slip and names the effect
  (or one tied with it): at least 75 %;
* false alarms: of the sets of `bench.lab` without a slip (all cases once, a hidden effect in most
  of them), at most 1 % are told one.

A strain, also in percent, where a stretch is expected counts as found if it is told and the mended
stretches are the true ones. Rules were chosen on seed 0; seeds 5000 and 5001 were run before slips
were sought beside effects; results are of seed 6100 on, where a rule is tuned on these of 6200 on.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from bench.hidden.case import DRIVEN, Case, hidden, named
from bench.hidden.cases import all_cases
from bench.kept import Unfinished, append, read, revision_of
from bench.lab.store import SOURCES
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.slip_beside_effect import find_all_slips
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.save import set_files
from model_lab.series.events import ODD_RUN
from model_lab.slips.find import Checked, score
from model_lab.slips.slip import Slip
from softhand_common.documents.output_file import write_files
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

DEVELOPMENT_SEED, SEED = 0, 6100
NOISE = 0.006
OUT = Path("out/bench/bench-lab-slips.json")
LINES = OUT.with_suffix(".jsonl")
FOUND_ROW, ALARM_ROW, BOTH_ROW = "found", "false alarms", "both named"
FOUND, BOTH, FALSE_ALARMS = 0.90, 0.75, 0.01
SCALES = {  # SI units in each usual unit
    "Pa": {"kPa": 1e3, "bar": 1e5, "mbar": 1e2, "psi": 6894.757, "mmHg": 133.3224, "MPa": 1e6,
           "kgf/cm**2": 98066.5, "inH2O": 249.0889, "Pa": 1.0},
    "rad": {"rad": 1.0, "deg": np.pi / 180.0, "turn": 2.0 * np.pi},
    "N": {"N": 1.0, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.448222, "mN": 1e-3},
    "N m": {"N*m": 1.0, "N*mm": 1e-3, "kgf*cm": 9.80665e-2, "lbf*inch": 0.1129848},
}  # fmt: skip
SHOWS = 2.0
SAME_FACTOR = 1.2  # ratio of units that the calibration cannot tell apart
QUANTITY = {"pressure": "Pa", "stress": "Pa", "tip_angle": "rad", "tip_force": "N"}
AT_LOAD = {"strain": 1.0, "percent": 0.01}  # strain by the values of the column
ODD_SCALES = (1.0 / 6.894757, 6.894757, np.pi / 180.0, 0.1)  # of a column in another unit
ODD_RUN_REPEATS = 3  # runs beyond one of each protocol
MOST_BOTH = 24  # sets that are diagnosed, which takes ten seconds each


@dataclass(frozen=True)
class Planted:
    """A set with a slip in it: its kind, the column that it is in, and the right unit, as SI units
    over those of the stated one.
    """

    data: MeasurementSet
    kind: str
    column: str
    factor: float | None = None


Plant = Callable[[MeasurementSet, np.random.Generator], Planted | None]
"""Puts a slip into a set; None where it has no room for it."""


# ---------------------------------------------------------------------- planting
def _changed(data: MeasurementSet, column: str, change: Callable[..., Any]) -> MeasurementSet:
    runs = tuple(
        replace(run, columns={**run.columns, column: change(run.columns[column], run.columns)})
        for run in data.runs
    )
    return replace(data, runs=runs)


def _unit(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    columns = [c for c in (*data.inputs, *data.outputs) if c in QUANTITY]
    if data.free_modulus or not columns:
        return None
    column = str(random.choice(columns))
    scales = SCALES[QUANTITY[column]]
    said, true = data.units[column], str(random.choice([*scales]))
    factor = scales[true] / scales[said]
    if 1.0 / SAME_FACTOR < factor < SAME_FACTOR:
        return None
    noise = {
        name: level / factor if name == column else level for name, level in data.noise.items()
    }
    changed = _changed(data, column, lambda values, _: values / factor)
    return Planted(replace(changed, noise=noise), "unit", column, factor)


def _absolute(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    if "pressure" not in data.inputs:
        return None
    air = random.uniform(99e3, 103e3)
    changed = _changed(data, "pressure", lambda values, _: values + air)
    return Planted(changed, "absolute", "pressure")


def _true_stress(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    if "stress" not in data.outputs:
        return None
    changed = _changed(data, "stress", lambda values, columns: values * columns["stretch"])
    return Planted(changed, "true_stress", "stress")


def _of_specimens(data: MeasurementSet, factors: dict[str, float], kind: str) -> Planted | None:
    if any(key not in s.values for s in data.specimens.values() for key in factors):
        return None
    specimens = {
        name: replace(
            specimen,
            values={
                key: _sized(value, factors.get(key, 1.0)) for key, value in specimen.values.items()
            },
        )
        for name, specimen in data.specimens.items()
    }
    return Planted(replace(data, specimens=specimens), kind, ", ".join(factors))


def _sized(value: Any, factor: float) -> Any:
    return value * factor if np.ndim(value) == 0 else value * np.array([1.0, factor])


def _youngs_modulus(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    if data.free_modulus or data.experiment == "blocked_tip":  # whose force shows no modulus
        return None
    return _of_specimens(data, {"shear_modulus": 3.0}, "youngs_modulus")


def _radius(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    return _of_specimens(data, {"height": 0.5, "width": 0.5}, "radius")


def _wall_total(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    return _of_specimens(data, {"wall": 2.0, "side_wall": 2.0}, "wall_total")


def _sign(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    if data.experiment == "valve_pulse":
        return None
    column = str(random.choice(data.outputs))
    return Planted(_changed(data, column, lambda values, _: -values), "sign", column)


def _angle(kind: str, change: Callable[..., Any], least: float = 0.0) -> Plant:
    def plant(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
        if data.experiment != "free_bending" or np.max(data.table.value) < least:
            return None
        return Planted(_changed(data, "tip_angle", change), kind, "tip_angle")

    return plant


def _exchanged(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    pairs = [pair for pair in (("p_in", "p_out"), ("torque_x", "torque_y")) if pair[0] in
             (*data.inputs, *data.outputs)]  # fmt: skip
    if pairs:
        first, second = pairs[0]
        runs = tuple(
            replace(run, columns={**run.columns, first: run.columns[second],
                                  second: run.columns[first]})
            for run in data.runs
        )  # fmt: skip
        return Planted(replace(data, runs=runs), "exchanged", f"{first}, {second}")
    used = list(dict.fromkeys(run.specimen for run in data.runs))
    if len(used) < 2:
        return None
    first, second = used[:2]
    one, other = data.specimens[first], data.specimens[second]
    if not _unlike(one.values, other.values):
        return None
    specimens = {**data.specimens, first: replace(one, values=other.values),
                 second: replace(other, values=one.values)}  # fmt: skip
    return Planted(replace(data, specimens=specimens), "exchanged", f"{first}, {second}")


def _unlike(one: Any, other: Any) -> bool:
    return any(not np.array_equal(one[key], other.get(key)) for key in one)


def _at_load(kind: str, change: Callable[..., Any]) -> Plant:
    def plant(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
        if "stretch" not in data.inputs:
            return None
        return Planted(_changed(data, "stretch", change), kind, "stretch")

    return plant


def _odd_run(data: MeasurementSet, random: np.random.Generator) -> Planted | None:
    """One run with a column in another unit, or with another zero; among few repeats none shows.
    Not of forces at the base, whose diagnosis takes minutes.
    """
    repeats = len(data.runs) - len(data.groups())
    if data.experiment in ("valve_pulse", "base_torque") or repeats < ODD_RUN_REPEATS:
        return None
    odd, column = int(random.integers(len(data.runs))), str(random.choice(data.outputs))
    scale, zero = (float(random.choice(ODD_SCALES)), 0.0) if random.random() < 0.5 else (1.0, 0.15)
    shift = zero * float(np.abs(data.table.value).max())
    runs = tuple(
        replace(run, columns={**run.columns, column: scale * run.columns[column] + shift})
        if place == odd
        else run
        for place, run in enumerate(data.runs)
    )
    return Planted(replace(data, runs=runs), ODD_RUN, data.runs[odd].name)


KINDS: dict[str, Plant] = {
    "unit": _unit,
    "absolute": _absolute,
    "percent": _at_load("percent", lambda values, _: 100.0 * (values - 1.0)),
    "strain": _at_load("strain", lambda values, _: values - 1.0),
    "true_stress": _true_stress,
    "youngs_modulus": _youngs_modulus,
    "radius": _radius,
    "wall_total": _wall_total,
    "sign": _sign,
    "supplement": _angle("supplement", lambda values, _: np.pi - values),
    "complement": _angle("complement", lambda values, _: 0.5 * np.pi - values),
    "chord": _angle("chord", lambda values, _: 0.5 * values),
    "wrapped": _angle(
        "wrapped", lambda values, _: np.angle(np.exp(1j * values)), least=1.1 * np.pi
    ),
    "exchanged": _exchanged,
    ODD_RUN: _odd_run,
}


# ---------------------------------------------------------------------- sets
WAYS = ("nothing", "hidden", "other make", "scarce")
HIDDEN = {
    "free_bending": "gent_stiffening pressure_offset hysteresis angle_offset",
    "blocked_tip": "pressure_offset tip_friction tube_lag",
    "uniaxial": "gent_stiffening hysteresis",
    "valve_pulse": "pulse_bias",
    "base_torque": "bend_twist_coupling",
}


def base_cases(way: str) -> Iterator[Case]:
    """Sets into which slips are put."""
    if way == "nothing":
        for experiment in HIDDEN:
            yield _case(way, experiment, None, {})
    if way == "hidden":
        for experiment, laws in HIDDEN.items():
            for law in laws.split():
                yield _case(way, experiment, law, {})
    if way == "other make":
        for design in ("walls", "tapered"):
            yield _case(f"{way} {design}", "free_bending", None, {"design": design})
        yield _case(way, "blocked_tip", None, {"design": "walls"})
    if way == "scarce":
        for experiment in DRIVEN:
            yield _case(way, experiment, None, {"runs": 3, "repeats": 1, "with_noise": False})


def _case(way: str, experiment: str, law: str | None, options: dict[str, Any]) -> Case:
    name = f"slips/{way}/{experiment}/{law or 'nothing'}"
    laws = hidden(law) if law else ()
    expected = named((law,)) if law else named()
    return Case(name, way, experiment, laws, expected, 5.0 if law else None, options, (NOISE,))


def made(case: Case, seed: int, noise: float) -> MeasurementSet:
    """The set of a case."""
    with tempfile.TemporaryDirectory() as folder:
        case.make(Path(folder), seed, noise)
        return load_measurements(folder)


# ---------------------------------------------------------------------- judging
def _shows(data: MeasurementSet, planted: Planted) -> bool:
    model = load_model("base")
    return score(planted.data, model).relative >= SHOWS * score(data, model).relative


def told_of(data: MeasurementSet) -> Checked:
    """The slips that a diagnosis begins with."""
    return find_all_slips(data, load_model("base"), effect_classes())


def found(planted: Planted) -> tuple[bool, str]:
    """Whether the slip is told first, and what is told."""
    if planted.kind in AT_LOAD:
        return _told_at_load(planted)
    if planted.kind == ODD_RUN:  # which the repeats tell, within a diagnosis
        slips = diagnose(planted.data, load_model("base")).diagnosis.slips
    else:
        slips = told_of(planted.data).slips
    return bool(slips) and _right(slips[0], planted), _words(slips)


def _words(slips: Sequence[Slip]) -> str:
    return "; ".join(f"{slip.name} {slip.column} {slip.fits}" for slip in slips)


def _right(slip: Any, planted: Planted) -> bool:
    if slip.name != planted.kind:
        return False
    if planted.kind in ("exchanged", "radius", "wall_total"):
        return set(slip.column.split(", ")) <= set(planted.column.split(", "))
    if slip.column != planted.column:
        return False
    if planted.factor is None:
        return True
    scales = SCALES[QUANTITY[planted.column]]
    ratio = scales.get(slip.fits, np.nan) / scales[slip.said] / planted.factor
    return bool(1.0 / SAME_FACTOR < ratio < SAME_FACTOR)


def _told_at_load(planted: Planted) -> tuple[bool, str]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_files(set_files(planted.data, folder))
        checked = told_of(load_measurements(folder))
    true = (1.0 + values * AT_LOAD[planted.kind] for values in _stretches(planted.data))
    pairs = zip(_stretches(checked.data), true, strict=True)
    right = all(np.allclose(mended, expected, rtol=1e-4) for mended, expected in pairs)
    return right and checked.slips[0].name in AT_LOAD, _words(checked.slips)


def _stretches(data: MeasurementSet) -> list[np.ndarray]:
    return [run.columns["stretch"] for run in data.runs]


# ---------------------------------------------------------------------- one set each
@dataclass(frozen=True)
class Task:
    """A set to make and to judge. what: FOUND_ROW, ALARM_ROW or BOTH_ROW; kind: of the slip."""

    what: str
    case: Case
    seed: int
    kind: str = ""

    def key(self, revision: str) -> str:
        """Name of the task under one revision of the code."""
        return f"{self.what}|{self.case.name}|{self.seed}|{self.kind}|{revision}"


@lru_cache(maxsize=1)
def _clean(name: str, seed: int) -> MeasurementSet:
    cases = (case for way in WAYS for case in base_cases(way))
    return made(next(case for case in cases if case.name == name), seed, NOISE)


def _planted(task: Task) -> Planted | None:
    """The set with its slip; None where it has no room for it, or does not show it."""
    data = _clean(task.case.name, task.seed)
    random = np.random.default_rng(
        [task.seed, zlib.crc32(f"{task.case.name} {task.kind}".encode())]
    )
    planted = KINDS[task.kind](data, random)
    if planted is None or not (task.kind in (*AT_LOAD, ODD_RUN) or _shows(data, planted)):
        return None
    return planted


def _detected(task: Task) -> dict[str, Any] | None:
    planted = _planted(task)
    if planted is None:
        return None
    right, told = found(planted)
    return {"right": right, "told": told, "column": planted.column, "factor": planted.factor}


def _both(task: Task) -> dict[str, Any] | None:
    planted = _planted(task)
    if planted is None:
        return None
    answer = diagnose(planted.data, load_model("base")).diagnosis
    slip = bool(answer.slips) and _right(answer.slips[0], planted)
    effects = [{e.name, *tied} for e, tied in zip(answer.effects, answer.tied, strict=True)]
    effect = len(effects) == 1 and bool(effects[0] & task.case.expected.names[0])
    told = f"{_words(answer.slips)}: {' + '.join('/'.join(sorted(names)) for names in effects)}"
    return {"right": slip and effect, "slip": slip, "told": told}


def _alarm(task: Task) -> dict[str, Any]:
    told = told_of(made(task.case, task.seed, task.case.noises[-1])).slips
    return {"right": not told, "told": _words(told)}


JUDGE: dict[str, Callable[[Task], dict[str, Any] | None]] = {
    FOUND_ROW: _detected,
    BOTH_ROW: _both,
    ALARM_ROW: _alarm,
}


def tasks_of(seeds: Sequence[int], part: int) -> dict[str, list[Task]]:
    """Tasks of each row, of each part-th case, in an order in which a part tells of the whole:
    cases at random, with all kinds of slips each.
    """
    every = [(case, seed) for way in WAYS for case in base_cases(way) for seed in seeds]
    random = np.random.default_rng(seeds[0])
    mixed = [every[place] for place in random.permutation(len(every))][::part]
    slips = [Task(FOUND_ROW, case, seed, kind) for case, seed in mixed for kind in KINDS]
    beside = [
        Task(BOTH_ROW, task.case, task.seed, task.kind)
        for task in slips
        if task.case.row == "hidden" and task.kind not in (*AT_LOAD, ODD_RUN)
    ]
    clean = all_cases()
    return {
        FOUND_ROW: slips,
        ALARM_ROW: [
            Task(ALARM_ROW, clean[place], seeds[0])
            for place in random.permutation(len(clean))[::part]
        ],
        BOTH_ROW: [beside[place] for place in random.permutation(len(beside))],
    }


# ---------------------------------------------------------------------- the run
def judged(
    tasks: Sequence[Task], revision: str, until: float, most: int | None = None
) -> list[dict[str, Any]]:
    """Records of the tasks whose sets show a slip (most: so many at most); each is kept as it ends,
    and what is kept is not done again. Raises Unfinished when the time `until` is over.
    """
    kept, records = read(LINES), []
    for number, task in enumerate(tasks, 1):
        if most is not None and len(records) >= most:
            break
        key = task.key(revision)
        if key not in kept:
            if time.monotonic() > until:
                raise Unfinished(f"{task.what}: {number - 1} of {len(tasks)} sets were looked at")
            about = {"kind": task.kind, "case": task.case.name, "seed": task.seed}
            about |= {"key": key, "way": task.case.row.split()[0]}
            kept[key] = about | (JUDGE[task.what](task) or {"right": None, "told": "does not show"})
            append(kept[key], LINES)
            _progress(task.what, number, len(tasks), kept[key])
        if kept[key]["right"] is not None:
            records.append(kept[key])
    return records


def _progress(what: str, number: int, total: int, record: dict[str, Any]) -> None:
    wrong = record["right"] is False
    if wrong or number % 20 == 0 or number == total:
        told = f": {record['kind']} told as {record['told'] or 'nothing'}" if wrong else ""
        print(f"{what}: {number}/{total} {record['case']} {record['seed']}{told}", file=sys.stderr)


def share(rows: Sequence[dict[str, Any]]) -> float:
    """Share of the rows that are right."""
    return sum(row["right"] for row in rows) / max(len(rows), 1)


def _line(what: str, rows: Sequence[dict[str, Any]], least: float) -> str:
    if not rows:
        return f"{what:28} no set yet"
    met = "yes" if share(rows) >= least else "missed"
    right = sum(row["right"] for row in rows)
    shares = f"{100 * share(rows):5.1f} %  >= {100 * least:.0f} %"
    return f"{what:28} {right:4d} of {len(rows):4d}  {shares}  {met}"


def _report(rows: dict[str, list[dict[str, Any]]]) -> None:
    if FOUND_ROW in rows:
        detected = rows[FOUND_ROW]
        print("found, of each kind")
        for kind in KINDS:
            mine = [row for row in detected if row["kind"] == kind]
            print(_line(f"  {kind}", mine, FOUND))
        print(_line("all kinds", detected, FOUND))
        for way in sorted({row["way"] for row in detected}):
            print(_line(f"  {way}", [row for row in detected if row["way"] == way], FOUND))
    if ALARM_ROW in rows:
        alarms = rows[ALARM_ROW]
        wrong = sum(not row["right"] for row in alarms)
        met = "yes" if wrong <= FALSE_ALARMS * len(alarms) else "missed"
        print(f"{'told where none is':28} {wrong:4d} of {len(alarms):4d}  <= 1 %  {met}")
    if BOTH_ROW in rows:
        print(_line("slip and effect both named", rows[BOTH_ROW], BOTH))


def main(arguments: list[str] | None = None) -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="bench.lab.slips", description=__doc__.splitlines()[0])
    parser.add_argument("--development", action="store_true", help="seeds that rules were set with")
    parser.add_argument("--seed", type=int, default=SEED, help=f"of the first sets ({SEED})")
    parser.add_argument("--part", type=int, default=1, metavar="N", help="each N-th case alone")
    parser.add_argument("--rows", nargs="+", choices=JUDGE, default=[*JUDGE], help="these alone")
    parser.add_argument("--minutes", type=float, default=240.0, help="start no set after that")
    chose = parser.parse_args(arguments)
    first = DEVELOPMENT_SEED if chose.development else chose.seed
    seeds = range(first, first + (1 if chose.development else 2))
    until, revision = time.monotonic() + 60 * chose.minutes, revision_of(SOURCES)
    every = tasks_of(seeds, chose.part)
    tasks = {what: every[what] for what in chose.rows}
    print(f"bench.lab.slips: seeds {seeds[0]} to {seeds[-1]}, revision {revision}", flush=True)
    rows: dict[str, list[dict[str, Any]]] = {}
    try:
        for what, mine in tasks.items():
            rows[what] = judged(mine, revision, until, MOST_BOTH if what == BOTH_ROW else None)
    except Unfinished as reason:
        rows[what] = _kept_rows(mine, revision)
        print(f"bench.lab.slips: {reason}; run it again to go on")
    _report(rows)
    document = {"seeds": list(seeds), "revision": revision, **rows}
    OUT.write_text(json.dumps(document, indent=1) + "\n")
    print(f"bench.lab.slips: written to {OUT}")
    return 0


def _kept_rows(tasks: Sequence[Task], revision: str) -> list[dict[str, Any]]:
    """Records of the tasks that are done and show a slip."""
    kept = read(LINES)
    done = (kept.get(task.key(revision)) for task in tasks)
    return [record for record in done if record and record["right"] is not None]


if __name__ == "__main__":
    sys.exit(main())
