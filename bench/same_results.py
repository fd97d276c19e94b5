"""Do the same seeds still give the same results? For changes that must change nothing.

    python -m bench.same_results store out/before      # three minutes on an idle core
    python -m bench.same_results store out/after
    python -m bench.same_results compare out/before out/after

Stored: a grasp of each strategy, a stored grasp of the Feix taxonomy through the sequencer, a sweep
of 20 trials, a diagnosis of each experiment of the lab on a set with a hidden effect, and a mould.
`compare` names the values that differ; exit status 1 if there are any.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from bench.grasps.over_ros import in_process, options_of
from grasp_strategies.in_process_scene import build_scene
from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.fitting import simulator_parameters
from softhand_trials.trials import run_in_process

BIN = Path(sys.executable).parent
STRATEGIES = (
    "surface_constrained",
    "rbo_hand_2_ball",
    "rbo_hand_2_lying_cylinder",
    "rbo_hand_2_slide_to_wall",
    "rbo_hand_1_from_above",
    "rbo_hand_1_push",
    "rbo_hand_1_surface",
    "rbo_hand_1_edge",
)
EXPERIMENTS = ("free_bending", "blocked_tip", "uniaxial", "rubber", "valve_pulse", "base_torque")
STORED_GRASP = "feix/09"
SWEEP = {
    "format": "softhand-sweep/1",
    "name": "same",
    "strategy": "rbo_hand_1_push",
    "model": "rbo_hand_1",
    "objects": {"marker": {"place": [0.0085, -0.069]}},
    "step": 0.005,
    "segments": 6,
    "cells": [[0.0, 0.0], [0.01, -0.02], [-0.02, 0.01], [0.02, 0.02], [-0.01, -0.03]],
    "nominal": True,
    "replicates": 3,
    "seed": 0,
}
# what a run does not repeat, or what names the code and not its result
PASSING = frozenset(("versions", "wall_time", "cpu_time", "seconds", "real_time_factor", "digest"))
MOST_SHOWN = 10  # differences of a file


# ---------------------------------------------------------------------- store
def grasps() -> dict[str, Any]:
    """One grasp of each strategy in the world in which it was tried."""
    return {name: in_process(name, options_of(name, 0)) for name in STRATEGIES}


def feix() -> dict[str, Any]:
    """A stored grasp of the Feix taxonomy, run as a strategy."""
    strategy = load_strategy(STORED_GRASP)
    scene = build_scene(**simulator_parameters(strategy))
    result = run_in_process(scene, strategy, ())
    pose = scene.simulation.object_pose()
    scene.close()
    return {"result": result.summary(), "pose": [list(map(float, part)) for part in pose]}


def sweep() -> dict[str, Any]:
    """Twenty trials of a plan, by key."""
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan.yaml"
        plan.write_text(yaml.safe_dump(SWEEP))
        _run("softhand", "sweep", plan, "--out", Path(folder) / "out", "--jobs", "1")
        lines = (Path(folder) / "out" / "results.jsonl").read_text().splitlines()
    return {record["key"]: record for record in map(json.loads, lines)}


def diagnoses() -> dict[str, Any]:
    """A verdict of each experiment of the lab on a synthesised set with a hidden effect."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in EXPERIMENTS:
            data, out = Path(folder) / name, Path(folder) / f"{name}.json"
            _run("model-lab", "synthesize", name, "--hide", "--seed", "3", "--out", data)
            _run("model-lab", "diagnose", data, "--jobs", "1", "--json", out)
            found[name] = json.loads(out.read_text().replace(str(data), name))
    return found


def mould() -> dict[str, Any]:
    """Hashes of the STL files of a mould."""
    with tempfile.TemporaryDirectory() as folder:
        _run("softhand", "hand", "mould", "P10.finger", "--out", folder)
        files = sorted(Path(folder).rglob("*.stl"))
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _run(command: str, *words: object) -> None:
    done = subprocess.run(
        [str(BIN / command), *map(str, words)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{command} {' '.join(map(str, words))}: {done.stderr[-500:]}")


PARTS: Mapping[str, Callable[[], dict[str, Any]]] = {
    "grasps": grasps,
    "feix": feix,
    "sweep": sweep,
    "diagnoses": diagnoses,
    "mould": mould,
}


def store(folder: Path, parts: list[str]) -> None:
    """Run the parts and write a JSON file of each."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in parts:
        print(f"same_results: {name} ...", flush=True)
        text = json.dumps(PARTS[name](), indent=1, sort_keys=True, default=str)
        (folder / f"{name}.json").write_text(text + "\n")


# -------------------------------------------------------------------- compare
def compare(before: Path, after: Path) -> int:
    """Print what differs; the number of values that do, or of files that are on one side alone."""
    total = 0
    for name in PARTS:
        files = [folder / f"{name}.json" for folder in (before, after)]
        if not all(path.exists() for path in files):
            print(f"{name}: not stored in {' and '.join(str(f) for f in files if not f.exists())}")
            total += 1
            continue
        old, new = (dict(leaves(json.loads(path.read_text()))) for path in files)
        unlike = {key for key in old.keys() | new.keys() if old.get(key) != new.get(key)}
        total += len(unlike)
        apart = max((_apart(old.get(key), new.get(key)) for key in unlike), default=0.0)
        print(f"{name}: {len(unlike)} of {len(old)} values differ, by up to {apart:.3g} of a value")
        for key in sorted(unlike)[:MOST_SHOWN]:
            print(f"    {key}: {old.get(key)!r}, then {new.get(key)!r}")
    return total


def leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Every plain value of a document with its place, but for what a run does not repeat.

    >>> dict(leaves({"a": [1, {"b": "x"}], "seconds": 3}))
    {'a/0': 1, 'a/1/b': 'x'}
    """
    if isinstance(value, dict):
        for name, part in value.items():
            if name not in PASSING:
                yield from leaves(part, f"{key}/{name}" if key else name)
    elif isinstance(value, list):
        for index, part in enumerate(value):
            yield from leaves(part, f"{key}/{index}")
    else:
        yield key, value


def _apart(old: Any, new: Any) -> float:
    """Difference over the larger of two numbers; infinite for other values."""
    if not all(isinstance(value, int | float) for value in (old, new)):
        return math.inf
    return abs(old - new) / max(abs(old), abs(new))


def main(arguments: list[str] | None = None) -> int:
    """Store or compare; 1 where anything differs."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.same_results",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = parser.add_subparsers(dest="action", required=True)
    storing = actions.add_parser("store", help="run everything and write the results")
    storing.add_argument("folder", type=Path)
    storing.add_argument("--parts", nargs="+", choices=list(PARTS), default=list(PARTS))
    comparing = actions.add_parser("compare", help="name what differs")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args(arguments)
    if options.action == "store":
        store(options.folder, options.parts)
        return 0
    return int(compare(options.before, options.after) > 0)


if __name__ == "__main__":
    sys.exit(main())
