"""Simulated grasps of a measured set: each run once for every model, by several processes."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import entry_points
from multiprocessing import current_process, get_context
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.hands import OBJECT_POSE, WRIST_POSE, mass_columns
from model_lab.measurements.measurement_set import MeasurementSet, Run
from model_lab.rules import RULES
from softhand_model.effects import Effect
from softhand_model.effects.hand import HandEffect
from softhand_model.model_file import Model

REPLAY_GROUP = "model_lab.grasps"  # of entry points: what replays a grasp
START_ROUNDING = 4  # digits of the object's start [m] that distinguish two simulations

Tried = tuple[Sequence[Effect], float]
"""Effects, and a factor on the modulus [-]."""

Asked = tuple[int, Sequence[Effect], float]
"""Index of a run, effects, and a factor on the modulus [-]."""


@dataclass(frozen=True)
class Engine:
    """How a grasp is simulated: number of segments per actuator, physics step [s], and name of the
    engine.
    """

    segments: int = 5
    step: float = 0.002
    name: str = "pybullet"


USUAL_ENGINE = Engine()
FINER_ENGINES = (Engine(segments=7), Engine(step=0.001))
OTHER_ENGINE = Engine(name="mujoco")


_KEPT: dict[Hashable, Array] = {}
_processes = 1
_tasks: list[tuple[Any, ...]] = []  # inherited by forked processes


def use_processes(jobs: int) -> None:
    """Set the number of processes in which grasps are simulated from now on."""
    global _processes
    _processes = jobs


def rollouts_done() -> int:
    """Number of grasps that were simulated for this process."""
    return len(_KEPT)


@lru_cache(maxsize=1)
def _replay() -> Any:
    """What replays a grasp; raises ValueError where nothing does."""
    found = list(entry_points(group=REPLAY_GROUP))
    if not found:
        raise ValueError(
            f"grasp: expected an installed simulator (entry point {REPLAY_GROUP}), got none; "
            "install the package pneuflex_sim"
        )
    return found[0].load()


def rollouts(data: MeasurementSet, asked: Sequence[Asked], engine: Engine) -> list[Array]:
    """Simulated outputs (samples, outputs) of each run that is asked for. Results are kept, so that
    nothing is simulated twice.
    """
    keys = [_key(data, *one, engine) for one in asked]
    missing = {
        key: (data, *one, engine) for key, one in zip(keys, asked, strict=True) if key not in _KEPT
    }
    _KEPT.update(zip(missing, _simulated([*missing.values()]), strict=True))
    return [_KEPT[key] for key in keys]


def _simulated(tasks: list[tuple[Any, ...]]) -> list[Array]:
    """Results of tasks, by processes where there are several and this is none of them."""
    global _tasks
    if _processes < 2 or len(tasks) < 2 or current_process().daemon:
        return [_roll(*task) for task in tasks]
    _replay()  # before the fork, so that no process loads it anew
    _tasks = tasks
    with get_context("fork").Pool(min(_processes, len(tasks))) as pool:
        return pool.map(_work, range(len(tasks)), chunksize=1)


def _work(number: int) -> Array:
    return _roll(*_tasks[number])


def _roll(
    data: MeasurementSet, run: int, effects: Sequence[Effect], scale: float, engine: Engine
) -> Array:
    """What is seen (samples, outputs) in a run."""
    one, what = data.runs[run], data.grasped
    if what is None:
        raise ValueError("object: expected the grasped object in the measurement set, got none")
    acting = tuple(effect for effect in effects if not of_gauge(effect))
    return np.asarray(
        _replay()(
            one.columns["time"],
            columns_of(one, WRIST_POSE),
            columns_of(one, mass_columns(data.hand)),
            _start(one),
            what.scene,
            hand=data.hand,
            object=what.object,
            model=Model(effects=acting),
            modulus_scale=scale,
            segments=data.hand_segments or engine.segments,
            step=engine.step,
            engine=engine.name,
        )
    )[:, :-4]


def _key(
    data: MeasurementSet, run: int, effects: Sequence[Effect], scale: float, engine: Engine
) -> Hashable:
    """What distinguishes a rollout."""
    one = data.runs[run]
    driving = [one.columns[name].tobytes() for name in ("time", *WRIST_POSE)]
    driving += [one.columns[name].tobytes() for name in mass_columns(data.hand)]
    start = _start(one).round(START_ROUNDING).tobytes()
    acting = sorted((e.name, *map(float, e.values.values())) for e in effects if not of_gauge(e))
    told = data.specimens[one.specimen].hand
    where = (told and told.told, data.folder, data.grasped)
    return sha256(b"".join([*driving, start])).digest(), tuple(acting), scale, engine, where


def of_gauge(effect: Effect) -> bool:
    """Whether an effect changes how the hand was measured, and not the hand itself."""
    return isinstance(effect, HandEffect) and effect.of_measurement


def columns_of(run: Run, names: Sequence[str]) -> Array:
    """Columns of a run with these names, as one array (samples, names)."""
    return np.stack([run.columns[name] for name in names], axis=1)


def _start(run: Run) -> Array:
    """Pose (7,) of the object before the hand is there, where it rests."""
    time = run.columns["time"]
    resting = columns_of(run, OBJECT_POSE)[time <= time[0] + RULES.object_rest]
    return np.append(resting[:, :3].mean(axis=0), resting[0, 3:])
