"""Formats of the mutated files: what writes a sound file of each, and what reads it."""

from __future__ import annotations

import base64
import json
import random
import shutil
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
import zstandard
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bench.robust.mutations import damaged_csv, damaged_json, damaged_yaml, is_refusal
from bench.robust.samples import (
    BAG_SET,
    DIAGNOSIS,
    EVALUATIONS,
    MODEL,
    OBJECT,
    OBJECT_OF_MESH,
    SCENE,
    TRIALS,
    TRUTH,
)
from grasp_strategies.strategy import STRATEGY_FOLDER as STRATEGIES
from grasp_strategies.strategy import load_strategy
from model_lab.bench.synthesize import SEAL, open_seal
from model_lab.measurements.load import load_measurements
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.mesh import box, write_meshes
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from pneumaticbox_driver.backends.hardware.hardware_file import read_hardware
from pneumaticbox_driver.calibration.file import (
    SHIPPED_CALIBRATION,
    load_box_note,
    load_calibration,
)
from softhand_bringup.bags.reading import Bag
from softhand_bringup.bags.repair import repair
from softhand_bringup.lab_story.fingers import read_diagnosis
from softhand_model.data_files import data_file
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_model.pneumatics.parameters import load_pneumatics
from softhand_trials.search.command import summary
from softhand_trials.search.objective import COST
from softhand_trials.search.run import SearchResult
from softhand_trials.sweep.report_files import REPORT_DATA, write_report
from softhand_trials.sweep.results import Results, read_results
from softhand_trials.sweep.trial_task import trial_of
from thesis.chapter_8.dexterity.patterns import FILE as PATTERNS
from thesis.chapter_8.dexterity.patterns import load_patterns

ROOT = Path(__file__).resolve().parents[2]
SET = ROOT / "examples" / "measurements" / "finger"
FRICTION = ROOT / "src" / "pneuflex_sim" / "pneuflex_sim" / "data" / "friction.yaml"
LARGEST = 1e15  # of any number that is taken


@dataclass(frozen=True)
class Format:
    """A format: writes a sound file of it into a folder and tells which file to mutate; reads what
    lies there; mutates its structure, if that is known; tells the file that a refusal must name.
    """

    write: Callable[[Path], Path]
    read: Callable[[Path], Any]
    mutate: Callable[[bytes, random.Random], bytes] | None = damaged_yaml
    named: Callable[[Path], str] = lambda path: path.name


def _copy(source: Path) -> Callable[[Path], Path]:
    return lambda folder: Path(shutil.copy(source, folder / "own.yaml"))


def _text(text: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / "own.yaml").write_text(text, encoding="utf-8")
        return folder / "own.yaml"

    return write


def _measurements(folder: Path) -> Path:
    shutil.copytree(SET, folder, dirs_exist_ok=True)
    return folder / "experiment.yaml"


def _table(folder: Path) -> Path:
    _measurements(folder)
    return folder / "thin_ramp_1.csv"


def _calibration(path: Path) -> Any:
    return load_calibration(path, 4), load_box_note(path)


def _bag_set(folder: Path, storage: StoragePlugin) -> Path:
    (folder / "experiment.yaml").write_text(BAG_SET, encoding="utf-8")
    types = get_typestore(Stores.ROS2_JAZZY)
    state = types.types["sensor_msgs/msg/JointState"]
    header, stamp = types.types["std_msgs/msg/Header"], types.types["builtin_interfaces/msg/Time"]
    with Writer(folder / "bag", version=9, storage_plugin=storage) as bag:
        topics = [
            bag.add_connection(topic, state.__msgtype__, typestore=types)
            for topic in ("/state", "/tips")
        ]
        for tick in range(60):
            value, none = np.array([0.01 * tick]), np.array([])
            message = state(header(stamp(tick, 0), ""), ["a"], value, none, 1e3 * value)
            for topic in topics:
                data = types.serialize_cdr(message, state.__msgtype__)
                bag.write(topic, 10**9 * tick, data)
    return next(path for path in (folder / "bag").iterdir() if path.suffix != ".yaml")


def _mcap(path: Path) -> Any:
    """The lab's reading, and the repair of the same file without its metadata."""
    broken = path.parent.parent / "broken"
    broken.mkdir()
    shutil.copy(path, broken / path.name)
    try:
        repair(broken)
    except ValueError as reason:
        if str(broken) not in str(reason):
            raise
    return _database(path)


def _database(path: Path) -> Any:
    try:
        with Bag(path.parent) as bag:
            for topic in bag.topics():
                deque(bag.messages(topic), maxlen=0)
    except ValueError as reason:
        if not is_refusal(str(reason), path.parent.name):
            raise
    return load_measurements(path.parent.parent)


def _swept(folder: Path) -> Path:
    (folder / "results.jsonl").write_text(TRIALS, encoding="utf-8")
    return folder / "results.jsonl"


def _report(path: Path) -> Any:
    """The report, and what the films of single trials read."""
    out = path.parent / "report"
    for record in read_results(path, ("object", "settings", "placement"), "outcome"):
        try:
            trial_of(record)
        except ValueError as reason:
            if not is_refusal(str(reason), str(record["key"])):
                raise
    write_report(path, out)
    return json.loads((out / REPORT_DATA).read_text(encoding="utf-8"))


def _searched(folder: Path) -> Path:
    (folder / "results.jsonl").write_text(EVALUATIONS, encoding="utf-8")
    return folder / "results.jsonl"


def _evaluations(path: Path) -> Any:
    with Results(path.parent, None, COST, ("values",)) as results:
        found = SearchResult(list(results.records.values()))
    if len(found.records) > found.failed:
        summary(found)
    return [record.get(COST) for record in found.records if abs(record.get(COST, 0)) < LARGEST]


def _json(text: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / "own.json").write_text(text, encoding="utf-8")
        return folder / "own.json"

    return write


def _seal(folder: Path) -> Path:
    (folder / SEAL).write_bytes(base64.b64encode(TRUTH.encode()))
    return folder / SEAL


def _damaged_truth(content: bytes, chance: random.Random) -> bytes:
    return base64.b64encode(damaged_json(base64.b64decode(content), chance))


def _mesh(ending: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        text = OBJECT_OF_MESH.format(file=f"block{ending}")
        (folder / "own.yaml").write_text(text, encoding="utf-8")
        write_meshes(folder / f"block{ending}", {"block": box((0.04, 0.06, 0.08), np.zeros(3))})
        return folder / f"block{ending}"

    return write


def _object_of_mesh(path: Path) -> Any:
    return load_object(path.parent / "own.yaml", load_friction())


def _metadata(folder: Path) -> Path:
    return _bag_set(folder, StoragePlugin.SQLITE3).parent / "metadata.yaml"


def _packed(folder: Path) -> Path:
    """A set whose bag is packed as a file."""
    path = _bag_set(folder, StoragePlugin.SQLITE3)
    packed = path.with_name(f"{path.name}.zstd")
    packed.write_bytes(zstandard.compress(path.read_bytes()))
    metadata = yaml.safe_load((path.parent / "metadata.yaml").read_text(encoding="utf-8"))
    about = metadata["rosbag2_bagfile_information"]
    about |= {"compression_format": "zstd", "compression_mode": "FILE"}
    about["relative_file_paths"] = [packed.name]
    (path.parent / "metadata.yaml").write_text(yaml.safe_dump(metadata), encoding="utf-8")
    path.unlink()
    return packed


def _folder_name(path: Path) -> str:
    return path.parent.name


def _set_name(path: Path) -> str:
    return path.parent.parent.name


FORMATS: Mapping[str, Format] = {
    "hand": Format(_copy(ROOT / "examples/three_finger_gripper/gripper.yaml"), load_hand),
    "strategy": Format(_copy(STRATEGIES / "surface_constrained.yaml"), load_strategy),
    "object": Format(_text(OBJECT), lambda path: load_object(path, load_friction())),
    "scene": Format(_text(SCENE), lambda path: load_scene(path, load_friction())),
    "friction": Format(_copy(FRICTION), load_friction),
    "model": Format(_text(MODEL), load_model),
    "experiment": Format(
        _measurements, lambda path: load_measurements(path.parent), named=_folder_name
    ),
    "calibration": Format(_copy(SHIPPED_CALIBRATION), _calibration),
    "hardware": Format(_copy(ROOT / "src/pneumaticbox_driver/config/hardware.yaml"), read_hardware),
    "plant": Format(_copy(data_file("pneumatics.yaml")), load_pneumatics),
    "CSV": Format(_table, lambda path: load_measurements(path.parent), damaged_csv),
    "MCAP": Format(lambda folder: _bag_set(folder, StoragePlugin.MCAP), _mcap, None, _set_name),
    "sqlite3": Format(
        lambda folder: _bag_set(folder, StoragePlugin.SQLITE3), _database, None, _set_name
    ),
    "packed bag": Format(_packed, _database, None, _set_name),
    "bag metadata": Format(_metadata, _database, damaged_yaml, _set_name),
    "sweep results": Format(_swept, _report, damaged_json),
    "search results": Format(_searched, _evaluations, damaged_json),
    "grasp patterns": Format(_copy(PATTERNS), load_patterns),
    "diagnosis": Format(_json(DIAGNOSIS), read_diagnosis, damaged_json),
    "seal": Format(_seal, lambda path: open_seal(path.parent), _damaged_truth),
    "STL": Format(_mesh(".stl"), _object_of_mesh, None, lambda path: "own.yaml"),
    "OBJ": Format(_mesh(".obj"), _object_of_mesh, None, lambda path: "own.yaml"),
}
