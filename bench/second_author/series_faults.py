"""Sets whose fault lies in the rig or in one run, and controls without a fault."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from .physics import scaled
from .rig import Rig, new_rig, record, write
from .truth import Truth

FAULTS = ("event", "drift", "changed_sensor", "odd_run", "exchanged")
FAULT_SETS, CONTROL_SETS = 60, 20


def fault_of(seed: int) -> str:
    """Kind of the fault of a seed, `none` for a control: 60 of 80 in a row, 12 of each kind."""
    place = seed % (FAULT_SETS + CONTROL_SETS)
    return "none" if place % 4 == 3 else FAULTS[(place - place // 4) % len(FAULTS)]


def make(seed: int, folder: Path) -> Truth:
    """Write the set of a seed and return its truth."""
    rng = np.random.default_rng([seed, 2])
    fault = fault_of(seed)
    repeats = int(rng.integers(3, 6))
    two = fault == "exchanged" or rng.random() < 0.4
    rig = new_rig(
        rng,
        "free_bending",
        specimens=2 if two else 1,
        protocols=2 if two else int(rng.integers(2, 4)),
        repeats=repeats,
    )
    truth = FAULT_MAKERS[fault](rng, rig) if fault != "none" else recorded(rng, rig)
    write(rig, folder)
    return truth


def recorded(rng: np.random.Generator, rig: Rig) -> Truth:
    """A day without a fault."""
    record(rig, rng)
    return Truth("nothing")


def _turning_run(rng: np.random.Generator, rig: Rig) -> int:
    """A run in the middle of the day, from which on something is different."""
    count = len(rig.runs)
    return int(rng.integers(int(np.ceil(0.35 * count)), int(0.7 * count) + 1))


def event(rng: np.random.Generator, rig: Rig) -> Truth:
    """A winding slips: from one run on, the pressure acts by 5 to 15 % more on its specimen."""
    first, gain = _turning_run(rng, rig), rng.uniform(1.05, 1.15)
    finger = rig.runs[first].specimen
    softer = scaled(rig.true[finger], 1 / gain)
    record(replace(rig, true={**rig.true, finger: softer}), rng)
    late = {run.name: run.data for run in rig.runs[first:] if run.specimen == finger}
    record(rig, rng)
    for run in rig.runs:
        run.data = late.get(run.name, run.data)
    return Truth("event", event="event", runs=(rig.runs[first].name,))


def drift(rng: np.random.Generator, rig: Rig) -> Truth:
    """Zero or scale of the output's sensor drifts over the day, 6 to 15 % in the end."""
    record(rig, rng)
    whole, zero = rng.choice([-1, 1]) * rng.uniform(0.06, 0.15), rng.random() < 0.5
    for k, run in enumerate(rig.runs):
        share = whole * k / (len(rig.runs) - 1)
        column = run.data[rig.output]
        run.data[rig.output] = column + share * rig.largest if zero else column * (1 + share)
    return Truth("drift of zero" if zero else "drift of scale", event="drift")


def changed_sensor(rng: np.random.Generator, rig: Rig) -> Truth:
    """Another sensor from one run on: scale and zero of the output step."""
    record(rig, rng)
    first = _turning_run(rng, rig)
    gain = 1 + rng.choice([-1, 1]) * rng.uniform(0.04, 0.1)
    zero = rng.choice([-1, 1]) * rng.uniform(0.02, 0.06) * rig.largest
    for run in rig.runs[first:]:
        run.data[rig.output] = run.data[rig.output] * gain + zero
    return Truth("changed sensor", event="changed_sensor", runs=(rig.runs[first].name,))


def odd_run(rng: np.random.Generator, rig: Rig) -> Truth:
    """One run in another unit, with another zero, or of a specimen that is not in the set."""
    kind = str(rng.choice(["unit", "zero", "specimen"]))
    k = int(rng.integers(len(rig.runs)))
    run = rig.runs[k]
    record(rig, rng)
    if kind == "unit":
        column, factor = [("pressure", 1 / 6.895), ("pressure", 10.0), ("tip_angle", np.pi / 180)][
            int(rng.integers(3))
        ]
        run.data[column] = run.data[column] * factor
    elif kind == "zero":
        size = rng.choice([-1, 1]) * rng.uniform(0.08, 0.2)
        run.data[rig.output] = run.data[rig.output] + size * rig.largest
    else:
        finger = rig.true[run.specimen]
        other = replace(finger, wall=finger.wall * rng.choice([0.7, 1.35]))
        alone = replace(rig, true={run.specimen: other}, runs=[run])
        record(alone, rng)
    return Truth(f"odd run: {kind}", event="odd_run", runs=(run.name,))


def exchanged(rng: np.random.Generator, rig: Rig) -> Truth:
    """Two plugs are exchanged once: two runs of one protocol carry each other's specimen."""
    _part(rng, rig)
    record(rig, rng)
    protocol = rig.runs[int(rng.integers(len(rig.runs)))].protocol
    same = [
        [r for r in rig.runs if r.protocol == protocol and r.specimen == name] for name in rig.true
    ]
    turn = int(rng.integers(len(same[0])))
    one, other = same[0][turn], same[1][turn]
    one.data, other.data = other.data, one.data
    return Truth("exchanged plugs", event="exchanged", runs=(one.name, other.name))


def _part(rng: np.random.Generator, rig: Rig) -> None:
    """Make the second specimen the first one with another wall, so that an exchange shows."""
    first, second = list(rig.true)
    wall = round(rig.true[first].wall * float(rng.choice([0.72, 1.35])), 4)
    rig.true[second] = replace(rig.true[first], wall=wall)
    rig.stated[second] = {**rig.stated[first], "wall": wall}


FAULT_MAKERS = {
    "event": event,
    "drift": drift,
    "changed_sensor": changed_sensor,
    "odd_run": odd_run,
    "exchanged": exchanged,
}
