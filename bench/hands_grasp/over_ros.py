"""Grasps recorded over ROS, with an effect hidden in the simulator: `python -m
bench.hands_grasp.over_ros`.

For each hidden effect MuJoCo's hand grasps the cylinder four times, by simulator, driver and
sequencer as nodes: two strategies, the object at two places each. The bags are imported and
diagnosed by the commands of a user, and the lab predicts in PyBullet.

Criteria, fixed before the first run: *right* if the verdict names the hidden effect and nothing
else, or `adequate` where nothing is hidden. Wanted: 4 of 4.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from threading import Event
from typing import Any

import yaml

from bench.command_line import command_line
from grasp_strategies.strategy import load_strategy
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import Demo, object_place

THING, HAND, ENGINE = "cylinder", "rbo_hand_2", "mujoco"
STRATEGIES = ("surface_constrained", "rbo_hand_2_lying_cylinder")
PLACES = ((0.0, 0.0), (0.003, -0.004))  # [m] of the object from where the strategy expects it
HIDDEN = {"nothing": 1.0, "object_mass": 1.6, "strut_stiffness": 0.45, "friction": 0.6}  # factors


def main() -> None:
    """Record, import and diagnose each hidden effect, and print a row for each."""
    parser = command_line("bench.hands_grasp.over_ros", __doc__)
    parser.add_argument("--only", nargs="+", choices=HIDDEN, default=list(HIDDEN))
    parser.add_argument("--jobs", default="2", help="processes that simulate (%(default)s)")
    parser.add_argument(
        "--keep", type=Path, help="folder for bags, sets and diagnoses; what is there is used"
    )
    given = parser.parse_args()
    print("| hidden | verdict | right | before, after, floor [mN] |\n|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in given.only:
            print(row(name, (given.keep or Path(folder)) / name, given.jobs), flush=True)


def row(name: str, folder: Path, jobs: str) -> str:
    """Record and diagnose one hidden effect in a folder; returns its row."""
    folder.mkdir(parents=True, exist_ok=True)
    effects = [("gravity", {"mass_scale": 1.0})]
    effects += [] if name == "nothing" else [(name, {"factor": HIDDEN[name]})]
    model = {
        "format": "softhand-model/1",
        "base": "pneuflex",
        "effects": [{"name": effect, "parameters": values} for effect, values in effects],
    }
    (folder / "hidden.yaml").write_text(yaml.safe_dump(model), encoding="utf-8")
    answer = folder / "diagnosis.json"
    if not answer.exists():
        _record_and_diagnose(folder, jobs)
    found = json.loads(answer.read_text())
    named = [effect["name"] for effect in found["effects"]]
    right = named == [name] or (name == "nothing" and found["verdict"] == "adequate")
    values = [_told(effect) for effect in found["effects"]]
    keys = ("rmse_before", "rmse_after", "noise_floor")
    errors = ", ".join(f"{1e3 * found[key]:.0f}" for key in keys)
    told = ", ".join((found["verdict"], *values))
    return f"| {name} | {told} | {'yes' if right else 'no'} | {errors} |"


def _told(effect: dict[str, Any]) -> str:
    """An effect with its values and intervals, in words."""
    words = [
        f"{entry['value']:.3g} ({entry['interval'][0]:.3g} to {entry['interval'][1]:.3g})"
        for entry in effect["parameters"].values()
    ]
    return " ".join((effect["name"], *effect.get("where", {}).values(), *words))


def _record_and_diagnose(folder: Path, jobs: str) -> None:
    """Write diagnosis.json of four grasps with the model hidden.yaml."""
    bags = [
        _recorded(folder / f"{strategy}_{number}", strategy, place, folder / "hidden.yaml")
        for strategy in STRATEGIES
        for number, place in enumerate(PLACES)
    ]
    of_set, answer = str(folder / "set"), str(folder / "diagnosis.json")
    about = ("--hand", HAND, "--experiment", "grasp", "--object", THING)
    if not Path(of_set).exists():
        _lab("import", *map(str, bags), "-o", of_set, *about, "--yes")
    _lab("diagnose", of_set, "--model", "gravity", "--jobs", jobs, "--json", answer)


def _recorded(folder: Path, strategy: str, shift: tuple[float, float], model: Path) -> Path:
    """The bag of one grasp over ROS, recorded if it is not there."""
    if (folder / "bag").exists():
        return folder / "bag"
    tried = load_strategy(strategy).tried_with
    place = object_place(tried, THING)
    options = SuiteOptions(
        hand=HAND,
        strategy=strategy,
        object=THING,
        scene=tried.scene,
        model=str(model),
        segments=tried.segments,
        step=tried.step,
        finger_contact=tried.finger_contact,
        engine=ENGINE,
        object_offset=(place[0] + shift[0], place[1] + shift[1]),
        real_time_factor=0.0,
    )
    folder.mkdir()
    verdict = Demo(options, folder, lambda line: None, Event()).run()
    print(f"{folder.name}: {verdict.reason}", file=sys.stderr)
    return folder / "bag"


def _lab(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "model_lab", *words], check=True, stdout=sys.stderr)


if __name__ == "__main__":
    main()
