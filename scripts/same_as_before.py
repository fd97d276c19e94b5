"""Do the same seeds still give the same results? Records what they give, and compares two records.

    python scripts/same_as_before.py record out/before        # at the commit before a change
    python scripts/same_as_before.py record out/after
    python scripts/same_as_before.py compare out/before out/after

A record holds 20 grasp trials in process (verdict, poses, air masses), five diagnoses of the lab,
one for each experiment, and the results of the experiments of chapters 3, 4 and 5. Everything is
compared to the last bit, but for wall times. Half an hour on two cores; parts of it by name.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

SKIPPED = {"real_time_factor", "seconds", "written", "created", "versions", "wall_time"}
HANDS = {"surface_constrained": 4, "rbo_hand_1_from_above": 3}  # strategy: seeds at each step
STEPS = (0.001, 0.002, 0.005)
EXTRA = (("surface_constrained", 4, 0.005),)  # the twentieth and more
DIAGNOSES = {
    "free_bending": 1,
    "blocked_tip": 2,
    "uniaxial": 3,
    "valve_pulse": 4,
    "base_torque": 5,
}
CHAPTER_4 = ("pulse_error", "drift_pulses", "six_channels")


def trials() -> list[dict[str, Any]]:
    """The grasp trials: verdict, and the state in which each has ended."""
    from grasp_strategies.trials import TrialSettings, run_trial, started_scene

    records = []
    plan = [(name, seed, step) for name, n in HANDS.items() for step in STEPS for seed in range(n)]
    for strategy, seed, step in [*plan, *EXTRA]:
        settings = TrialSettings(strategy=strategy, step=step)
        record = run_trial(seed, settings).record()
        simulation = started_scene(settings).scene.simulation
        position, orientation = simulation.object_pose()
        record |= {
            "air_masses": simulation.air_masses().tolist(),
            "object_pose": [*map(float, position), *map(float, orientation)],
            "tip_angles": {name: float(angle) for name, angle in simulation.tip_angles().items()},
            "wrist": [float(x) for part in simulation.wrist_pose() for x in part],
        }
        records.append({"strategy": strategy, "step": step} | record)
        print(f"{strategy} {seed} {step}: {record['outcome']}", file=sys.stderr, flush=True)
    return records


def run(*words: str) -> None:
    """Run a module of the suite; a verdict that falls short (1) is a result, too."""
    done = subprocess.run([sys.executable, "-m", *words], stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(words)}: exit status {done.returncode}")


def diagnoses(out: Path) -> None:
    """A diagnosis of a set with a hidden effect for each experiment."""
    for experiment, seed in DIAGNOSES.items():
        folder = out / experiment
        lab = ("model_lab.cli.main",)
        run(*lab, "synthesize", experiment, "--hide", "--seed", str(seed), "--out", str(folder))
        run(*lab, "diagnose", str(folder), "--json", str(out / f"{experiment}.json"))


def chapter_4(out: Path) -> None:
    """Three experiments on the pretended bench of chapter 4."""
    for name in CHAPTER_4:
        run("thesis", "run", name, "--out", str(out / name))


def chapters_3_and_5(out: Path) -> None:
    """All experiments of chapters 3 and 5."""
    from thesis.frame import experiments

    for name in experiments("chapter_3_and_5"):
        run("thesis", "run", name, "--out", str(out / name))


def record(out: Path, parts: list[str]) -> None:
    """Write the record, or these parts of it."""
    for part in parts or PARTS:
        folder = out / part
        folder.mkdir(parents=True)
        if part == "trials":
            (folder / "trials.json").write_text(json.dumps(trials(), indent=1))
        else:
            PARTS[part](folder)


PARTS: dict[str, Any] = {
    "trials": trials,
    "diagnoses": diagnoses,
    "chapter_4": chapter_4,
    "chapters_3_and_5": chapters_3_and_5,
}


def differences(before: Any, after: Any, where: str = "") -> Iterator[str]:
    """Where two records differ, and by what."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted((before.keys() | after.keys()) - SKIPPED):
            if key not in before or key not in after:
                yield f"{where}/{key}: only {'after' if key in after else 'before'}"
            else:
                yield from differences(before[key], after[key], f"{where}/{key}")
    elif isinstance(before, list) and isinstance(after, list):
        if len(before) != len(after):
            yield f"{where}: {len(before)} entries before, {len(after)} after"
        for index, (one, other) in enumerate(zip(before, after, strict=False)):
            yield from differences(one, other, f"{where}[{index}]")
    elif before != after and not (before != before and after != after):
        yield f"{where}: {before!r} before, {after!r} after"


def compare(before: Path, after: Path) -> int:
    """Print the differences of two records; 1 if there are any."""
    files = sorted(path.relative_to(before) for path in before.rglob("*") if path.is_file())
    kept = [path for path in files if path.suffix in (".json", ".csv", ".txt", ".npz")]
    different = 0
    for path in kept:
        found = list(_file_differences(before / path, after / path))
        different += bool(found)
        print(f"{path}: {'same' if not found else f'{len(found)} differences'}")
        print("".join(f"    {line}\n" for line in found[:5]), end="")
    print(f"{len(kept) - different} of {len(kept)} files are the same")
    return int(different > 0)


def _file_differences(before: Path, after: Path) -> Iterator[str]:
    if before.parts[-3] in ("chapter_4", "chapters_3_and_5"):
        after = after if after.suffix == ".npz" else after.with_name("result.json")
    if not after.exists():
        yield "missing"
    elif before.suffix == ".npz":
        yield from differences(_arrays(before), _arrays(after))
    elif after.name == "result.json":
        one = _thesis_content(before)
        other = _thesis_content(after)
        yield from differences(one, {key: other.get(key) for key in one})
    elif before.suffix == ".json":
        yield from differences(json.loads(before.read_text()), json.loads(after.read_text()))
    elif before.read_text() != after.read_text():
        yield "other text"


def _arrays(path: Path) -> dict[str, Any]:
    """Arrays of a result of the thesis; those of more axes were once kept in single precision."""
    with np.load(path) as kept:
        arrays = {key: kept[key] for key in kept.files}
    return {k: (v.astype(np.float32) if v.ndim > 1 else v).tolist() for k, v in arrays.items()}


def _thesis_content(path: Path) -> dict[str, Any]:
    """What a result of the thesis says, in the keys of today's result.json.

    Before there was one frame, chapter 4 had `settings` and `seed` (today `parameters`), `metrics`
    with a `name` each (`findings`, `what`; no finding of the thesis was "", today "-") and a
    verdict without a capital and a stop; chapters 3 and 5 had results.json and verdict.txt.
    """
    if path.suffix == ".txt":
        return {"verdict": path.read_text().strip()}
    content = json.loads(path.read_text())
    if "metrics" in content:
        verdict = content["verdict"]
        rows = [[m["name"], m["value"], m["unit"], m["thesis"] or "-"] for m in content["metrics"]]
        return {
            "parameters": content["settings"] | {"seed": content["seed"]},
            "findings": rows,
            "verdict": f"{verdict[0].upper()}{verdict[1:]}.",
        }
    if "findings" in content:
        rows = [[f["what"], f["value"], f["unit"], f["thesis"]] for f in content["findings"]]
        return content | {"findings": rows}
    return {"results": content["results"]}


def main() -> int:
    """Record or compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record")
    recording.add_argument("out", type=Path)
    recording.add_argument("parts", nargs="*", help=f"of {', '.join(PARTS)}; default: all")
    comparing = commands.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args()
    if options.command == "compare":
        return compare(options.before, options.after)
    record(options.out, options.parts)
    return 0


if __name__ == "__main__":
    sys.exit(main())
