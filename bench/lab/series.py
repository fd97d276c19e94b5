"""Run the bench of a suspect series: sets with a fault of the rig, and clean ones; print a table.

Criteria, fixed before the first run. A set is a synthesised one (`model_lab.bench.synthesize`, half
of them with a hidden effect), with one fault of `bench.rig_faults`:

    step       a scale that changes by 6 to 12 % for good from a run on
    drift      a scale that grows by 10 to 20 % over the series
    sensor     a scale of 5 % less and a zero of 5 to 12 % of the largest reading from a run on
    unit       one run whose outputs are written in another unit
    exchanged  two runs with the outputs of each other

It is right if `events` has an event of this kind at this run (a drift at any run; of two repeats of
which one is odd, that one). `adequate` beside a fault is counted apart, and so are events where
there is no fault. Targets: 80 % right, no `adequate`, at most 2 % false alarms. Seeds of a run are
--seed times 10 000 and up; development took seeds below 3 000.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

import numpy as np

from bench import rig_faults as rig
from bench.lab.table import rate, text_of
from model_lab.bench.synthesize import synthesize
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.result import ADEQUATE, Diagnosis
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.model_file import Model

EXPERIMENTS = ("free_bending", "uniaxial", "blocked_tip")
SEED_STRIDE = 10_000
Faulty = tuple[MeasurementSet, str, set[str]]  # the set, and the kind and the runs that are right


def _step(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    first = int(random.integers(3, len(data.runs) - 2))
    gain = float(random.uniform(0.06, 0.12))
    return rig.slipped_winding(data, first, gain), "step", {data.runs[first].name}


def _drift(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    drifted = rig.drifting_gain(data, float(random.uniform(0.1, 0.2)))
    return drifted, "drift", {run.name for run in data.runs}


def _sensor(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    first = int(random.integers(3, len(data.runs) - 2))
    zero = float(random.uniform(0.05, 0.12))
    return rig.changed_sensor(data, first, -0.05, zero), "step", {data.runs[first].name}


def _unit(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    run = int(random.integers(len(data.runs)))
    factor = float(random.choice([180.0 / np.pi, 1e-3, 1.0 / 9.80665]))
    return rig.run_in_other_unit(data, run, factor), "odd_run", {data.runs[run].name}


def _exchanged(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    half = len(data.runs) // 2
    first, second = (int(run) for run in random.choice(half, 2, replace=False))
    names = {data.runs[first].name, data.runs[second].name}
    return rig.exchanged_plugs(data, first, second), "exchanged", names


def _clean(data: MeasurementSet, random: np.random.Generator) -> Faulty:
    return data, "", set()


FAULTS: dict[str, Callable[[MeasurementSet, np.random.Generator], Faulty]] = {
    "step": _step,
    "drift": _drift,
    "sensor": _sensor,
    "unit": _unit,
    "exchanged": _exchanged,
    "clean": _clean,
}


def right(found: Diagnosis, kind: str, runs: set[str]) -> bool:
    """Whether an event of this kind at one of these runs is named."""
    return any(event["kind"] == kind and event["run"] in runs for event in found.events)


def main(arguments: list[str] | None = None) -> int:
    """Make the sets, diagnose them, print."""
    parser = argparse.ArgumentParser(prog="bench.lab.series", description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="of the run, from 1")
    parser.add_argument("--sets", type=int, default=6, help="of each fault")
    chose = parser.parse_args(arguments)
    hits: dict[str, list[bool]] = {name: [] for name in FAULTS}
    adequate: list[bool] = []
    for number in range(chose.sets):
        seed = chose.seed * SEED_STRIDE + number
        experiment = EXPERIMENTS[number % len(EXPERIMENTS)]
        clean = synthesize(experiment, seed, hide=number % 2 == 1)
        for name, fault in FAULTS.items():
            data, kind, runs = fault(clean.data, np.random.default_rng(seed))
            found = diagnose(data, Model("pneuflex")).diagnosis
            hits[name].append(right(found, kind, runs) if kind else bool(found.events))
            if kind:
                adequate.append(found.verdict == ADEQUATE)
            said = [(event["kind"], event["run"]) for event in found.events]
            hidden = [effect["name"] for effect in clean.truth["effects"]]
            named = [effect.name for effect in found.effects]
            print(seed, experiment, name, sorted(runs), hidden, "<-", found.verdict, said, named)
    rows = [
        rate(f"{name}: right event named", hits[name], 0.8) for name in FAULTS if name != "clean"
    ]
    faulty = [hit for name in FAULTS if name != "clean" for hit in hits[name]]
    rows.append(rate("all faults: right event named", faulty, 0.8))
    rows.append(rate("adequate beside a fault", adequate, most=0.0))
    rows.append(rate("an event where there is none", hits["clean"], most=0.02))
    print(text_of(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
