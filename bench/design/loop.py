"""Closed loop: a request, its design, its file, the simulator, a measurement, the lab's verdict."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bench import kept
from bench.design.requests import feasible
from bench.design.simulated import SEGMENTS, from_file, held_against
from bench.row import at_least, at_most
from model_lab.diagnosis.diagnose import diagnose_folder
from model_lab.diagnosis.result import ADEQUATE
from softhand_design.hand_file import actuator_entry
from softhand_design.sizing import Design
from softhand_model.hand.actuator import Actuator
from thesis.chapter_3_and_5.stand import FingerStand

TAKES = "four minutes for 20 requests"
NOISE = 0.005  # of the largest angle
PROTOCOLS = {"whole": 0.8, "half": 0.45}  # of the pressure limit
LEVELS = 24  # pressures of a run, up and down
REPEATS = 2
SPACING = 0.5  # [s] between samples
PERCENT = 100.0
KEPT = Path("out/bench/design-loop.jsonl")
SOURCES = ("src/softhand_model", "src/pneuflex_sim", "src/model_lab", "bench/design")


def run(count: int = 20, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    return list(_loops(count, seed))


def _loops(count: int, seed: int) -> Iterator[dict[str, Any]]:
    found = [_known(design, seed, k) for k, design in enumerate(feasible(count, seed))]
    bend, force = (PERCENT * max(one[key] for one in found) for key in ("bend", "force"))
    modulus = PERCENT * max(abs(one["modulus_scale"] - 1.0) for one in found)
    yield at_most(f"{count} requests simulated: curvature off", bend, "%", 2.0)
    yield at_most("the same: force of the blocked tip off", force, "%", 2.0)
    adequate = sum(one["adequate"] for one in found)
    yield at_least("measured and found adequate by the lab", adequate, "", count)
    yield at_most("modulus that the lab fits, off the design's", modulus, "%", 2.0)


def _known(design: Design, seed: int, number: int) -> dict[str, Any]:
    """What came of a request, kept from an earlier run of the same code."""
    key = f"{kept.revision_of(SOURCES, ('.py', '.yaml'))}/{seed}/{number}"
    record = kept.read(KEPT).get(key)
    if record is None:
        actuator = from_file(design)
        held = vars(held_against(design, actuator))
        record = {"key": key, **held, **verdict_on(design, actuator, seed + number)}
        kept.append(record, KEPT)
    print(f"{design.actuator.name}: {record}", flush=True)
    return record


def verdict_on(design: Design, measured: Actuator, seed: int) -> dict[str, Any]:
    """What the lab says of a measured finger, taking it for the designed one."""
    with tempfile.TemporaryDirectory() as folder:
        write_measurement(Path(folder), design.actuator, measured, seed)
        found = diagnose_folder(folder)
    return {
        "adequate": found["verdict"] == ADEQUATE,
        "named": [effect["name"] for effect in found["effects"]],
        "modulus_scale": next(iter(found["calibration"]["modulus_scale"].values())),
    }


def write_measurement(folder: Path, stated: Actuator, measured: Actuator, seed: int) -> None:
    """Write free bending of a simulated finger as a measurement set whose specimen is stated to be
    another: pressures held one after the other, noise on the angle.
    """
    random = np.random.default_rng(seed)
    runs: dict[str, Any] = {}
    with FingerStand(measured, SEGMENTS) as stand:
        for protocol, share in PROTOCOLS.items():
            up = np.linspace(0.0, share * stated.max_pressure, LEVELS // 2 + 1)
            pressures = np.concatenate([up, up[-2::-1]])
            angles = np.array([_settled(stand, pressure) for pressure in pressures])
            for repeat in range(REPEATS):
                noisy = angles + NOISE * angles.max() * random.standard_normal(len(angles))
                name = f"{protocol}_{repeat}"
                time = SPACING * np.arange(len(angles))
                table = np.stack([time, pressures, noisy], axis=1)
                head = "time,pressure,tip_angle"
                np.savetxt(folder / f"{name}.csv", table, "%.9g", ",", header=head, comments="")
                runs[name] = {
                    "specimen": stated.name,
                    "temperature": 293.15,
                    "protocol": protocol,
                    "file": f"{name}.csv",
                }
    document = {
        "format": "softhand-measurement/1",
        "experiment": "free_bending",
        "title": "a designed finger in the simulator",
        "specimens": {stated.name: actuator_entry(stated)},
        "columns": {
            "time": {"unit": "s"},
            "pressure": {"unit": "Pa"},
            "tip_angle": {"unit": "rad"},
        },
        "runs": runs,
    }
    (folder / "experiment.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def _settled(stand: FingerStand, pressure: float) -> float:
    stand.settle(pressure)
    return float(stand.bends().sum())
