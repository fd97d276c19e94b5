"""Mutated files of every format: each is read as it should be, or refused with file and place.

`python -m bench.robust.files --per-format 1000 --seed 0` prints what was taken or refused badly.
Every case is read in a worker process with a limit on its memory; one that hangs is ended.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing as mp
import random
import resource
import shutil
import sys
import tempfile
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bench.robust.mutations import damaged, damaged_csv, damaged_yaml, is_refusal
from bench.robust.samples import BAG_SET, MODEL, OBJECT, SCENE
from bench.row import at_most, stated
from grasp_strategies.strategy import DATA as STRATEGIES
from grasp_strategies.strategy import load_strategy
from model_lab.measurements.load import load_measurements
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from pneumaticbox_driver.backends.hardware.hardware_file import read_hardware
from pneumaticbox_driver.calibration.file import SHIPPED, load_box_note, load_calibration
from softhand_bringup.bags.reading import Bag
from softhand_bringup.bags.repair import repair
from softhand_model.documents.yaml_document import data_file
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_model.pneumatics.parameters import load_pneumatics

ROOT = Path(__file__).resolve().parents[2]
SET = ROOT / "examples" / "measurements" / "finger"
FRICTION = ROOT / "src" / "pneuflex_sim" / "pneuflex_sim" / "data" / "friction.yaml"
LONGEST = 5.0  # [s] of calculation that a file may take
HANGS = 60.0  # [s] of the wall after which it is ended; other work may slow the machine down
MOST_MEMORY = 2**30  # [bytes] beyond what the process has before
LARGEST = 1e15  # of any number that is taken
NOT_NEGATIVE = frozenset(
    (
        *("length", "width", "height", "wall", "side_wall", "thickness", "diameter", "size"),
        *("mass", "modulus", "shear_modulus", "density", "volume", "tank_volume", "full_scale"),
        *("speed", "duration", "noise", "std", "delivery", "inclination"),
    )
)
KINDS = ("traceback", "over 5 s", "over 1 GB", "refused without file and place", "taken, senseless")


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
    "calibration": Format(_copy(SHIPPED), _calibration),
    "hardware": Format(_copy(ROOT / "src/pneumaticbox_driver/config/hardware.yaml"), read_hardware),
    "plant": Format(_copy(data_file("pneumatics.yaml")), load_pneumatics),
    "CSV": Format(_table, lambda path: load_measurements(path.parent), damaged_csv),
    "MCAP": Format(lambda folder: _bag_set(folder, StoragePlugin.MCAP), _mcap, None, _set_name),
    "sqlite3": Format(
        lambda folder: _bag_set(folder, StoragePlugin.SQLITE3), _database, None, _set_name
    ),
}


@dataclass(frozen=True)
class Case:
    """What became of one mutated file; `bad` is empty for one that was treated well."""

    seed: int
    taken: bool
    bad: str
    message: str


def try_case(form: Format, name: str, seed: int) -> Case:
    """Write, mutate and read one file; the same seed gives the same file."""
    chance = random.Random(f"{name} {seed}")
    with tempfile.TemporaryDirectory(prefix="softhand-files-") as folder:
        path = form.write(Path(folder))
        mutate = damaged if form.mutate is None or chance.random() < 0.4 else form.mutate
        path.write_bytes(mutate(path.read_bytes(), chance))
        begun = time.process_time()
        taken, bad, message = _outcome(form, path)
        if time.process_time() - begun > LONGEST:
            bad = bad or "over 5 s"
    return Case(seed, taken, bad, message)


def _outcome(form: Format, path: Path) -> tuple[bool, str, str]:
    try:
        found = form.read(path)
    except MemoryError as reason:
        return False, "over 1 GB", repr(reason)
    except ValueError as reason:
        named = is_refusal(str(reason), form.named(path))
        return False, "" if named else "refused without file and place", str(reason)
    except BaseException as reason:  # noqa: BLE001 (whatever it is, it is counted)
        return False, "traceback", repr(reason)
    senseless = next(_senseless(found, ""), "")
    return True, "taken, senseless" if senseless else "", senseless


def _senseless(value: Any, name: str) -> Iterator[str]:
    """Numbers that no quantity can have, with their names."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        if value.size and not np.abs(value).max() <= LARGEST:
            yield f"{name}: {value}"
    elif isinstance(value, bool | str | Path) or value is None:
        return
    elif isinstance(value, int | float):
        if (
            not math.isfinite(value)
            or (abs(value) > LARGEST and name != "box_seed")
            or (value < 0 and name in NOT_NEGATIVE)
        ):
            yield f"{name}: {value}"
    else:
        for inner, part in _parts(value, name):
            yield from _senseless(part, inner)


def _parts(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    if is_dataclass(value):
        yield from ((field.name, getattr(value, field.name)) for field in fields(value))
    elif isinstance(value, Mapping):
        yield from ((str(key), part) for key, part in value.items())
    elif isinstance(value, list | tuple):
        yield from ((name, part) for part in value)


# ---------------------------------------------------------------------- workers
def run_format(name: str, count: int, seed: int) -> list[Case]:
    """All cases of a format, in a process that is replaced where it hangs or dies."""
    cases: list[Case] = []
    while len(cases) < count:
        begin = seed + len(cases)
        ours, theirs = mp.Pipe(duplex=False)
        worker = mp.get_context("fork").Process(
            target=_work, args=(name, begin, seed + count, theirs), daemon=True
        )
        worker.start()
        theirs.close()
        cases += _collect(ours, seed + len(cases), seed + count)
        worker.kill()
        worker.join()
    return cases


def _collect(pipe: Connection, begin: int, end: int) -> list[Case]:
    cases: list[Case] = []
    while begin + len(cases) < end:
        here = begin + len(cases)
        if not pipe.poll(HANGS):
            return [*cases, Case(here, False, "over 5 s", f"no end within {HANGS:g} s")]
        try:
            cases.append(pipe.recv())
        except EOFError:
            return [*cases, Case(here, False, "traceback", "the process died")]
    return cases


def _work(name: str, begin: int, end: int, pipe: Connection) -> None:
    _warm(name)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MOST_MEMORY, size + MOST_MEMORY))
    for seed in range(begin, end):
        pipe.send(try_case(FORMATS[name], name, seed))


def _warm(name: str) -> None:
    """Read a sound file, so that what is loaded once does not count."""
    with tempfile.TemporaryDirectory(prefix="softhand-files-") as folder:
        FORMATS[name].read(FORMATS[name].write(Path(folder)))


def rows_of(found: Mapping[str, list[Case]]) -> list[dict[str, Any]]:
    """Rows: badly treated files a format, and of all formats by kind."""
    kinds = Counter(case.bad for cases in found.values() for case in cases)
    rows = [at_most(f"mutated files: {kind}", kinds[kind], "files", 0) for kind in KINDS]
    for name, cases in found.items():
        bad = sum(bool(case.bad) for case in cases)
        rows.append(at_most(f"mutated {name} files badly treated", bad, f"of {len(cases)}", 0))
        rows.append(stated(f"mutated {name} files taken", sum(c.taken for c in cases), "files"))
    return rows


def run(per_format: int = 1000, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of all formats."""
    return rows_of({name: run_format(name, per_format, seed) for name in FORMATS})


def main(arguments: list[str] | None = None) -> int:
    """Print what was treated badly, and the rows; 1 where there is any."""
    parser = argparse.ArgumentParser(prog="python -m bench.robust.files", description=__doc__)
    parser.add_argument("--per-format", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="of the first file; they go up by one")
    parser.add_argument("--formats", nargs="+", choices=list(FORMATS), default=list(FORMATS))
    options = parser.parse_args(arguments)
    found = {}
    for name in options.formats:
        found[name] = run_format(name, options.per_format, options.seed)
        for case in found[name]:
            if case.bad:
                print(f"{name} {case.seed}: {case.bad}: {case.message[:300]}", flush=True)
    rows = rows_of(found)
    for row in rows:
        print(f"{row['name']}: {row['value']:g} {row['unit']} {row['target'] or ''}")
    return int(any(row["met"] is False for row in rows))


if __name__ == "__main__":
    sys.exit(main())
