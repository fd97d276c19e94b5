"""Grasp trials in process: one trial from a seed, a batch, and the command that runs it.

Each seed draws where the object lies and how heavy it is; the same seed gives the same trial.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field, fields, replace
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.judging.adaptability import Adaptability
from grasp_strategies.judging.early_end import EarlyEnd, EmptyHandPath, looks_at_object
from grasp_strategies.judging.failure import STAGE_HOLD, GraspWatch
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import Strategy, load_strategy
from grasp_strategies.strategy.variants import varied
from pneuflex_sim.bullet import NotInstalled
from pneuflex_sim.engines import ENGINES, check_engines, default_engine
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import solver_settings
from softhand_common.documents.output_file import UnwritableFile, check_new, write_new
from softhand_model.model_file import ALLOW_EFFECT_FILES, ALLOW_HELP
from softhand_model.usual_step import USUAL_STEP
from softhand_trials.agreement import Agreement, add_engines

OFFSET = 0.010  # largest shift of the object in x and in y [m]
MASS_SPREAD = 0.20  # largest change of the object's mass, as a share of it
OUT_OF_THE_WAY = (0.0, 3.0)  # of any hand [m]
LARGEST_OFFSET = 1.0  # that the command takes [m]
BY_SEED, BY_PLAN = {"set_by": "seed"}, {"set_by": "plan"}  # metadata of settings: what sets them
ADDED = {"added": True}  # metadata of settings that results of earlier versions do not have


@dataclass(frozen=True)
class Placement:
    """Differences of one trial from the start of its scene: shift of the object (x, y) [m],
    rotation about the vertical `yaw` [rad], factors [-] on its mass and on the friction of all
    pairs.
    """

    offset: tuple[float, float] = (0.0, 0.0)
    mass_scale: float = 1.0
    yaw: float = 0.0
    friction_scale: float = 1.0


def draw_placement(
    seed: int, offset: float = OFFSET, mass_spread: float = MASS_SPREAD
) -> tuple[tuple[float, float], float]:
    """Shift of the object (x, y) [m] and factor on its mass [-], drawn uniformly with a seed.

    Different seeds give independent draws, and a draw does not depend on the number of trials.

    Args:
        seed: seed of the trial.
        offset: largest shift in x and in y [m].
        mass_spread: largest change of the mass, as a share of it [-].

    >>> (x, y), mass_scale = draw_placement(3)
    >>> abs(x) <= 0.010 and abs(y) <= 0.010 and 0.8 <= mass_scale <= 1.2
    True
    """
    draw = np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    x, y = (offset * draw[:2]).tolist()
    return (x, y), float(1.0 + mass_spread * draw[2])


@dataclass(frozen=True)
class TrialSettings:
    """The settings that all trials of a batch share.

    Args:
        strategy: name or file of the strategy.
        object, scene, model: names or files; model None: the base model.
        step: physics step [s].
        segments: number of segments per actuator.
        offset: largest shift of the object in x and in y [m], drawn by the seed of a trial.
        mass_spread: largest change of the object's mass, as a share [-], drawn by the seed.
        options: the strategy's options that are switched on.
        solver: name of the solver's settings.
        friction: file with pairs of materials in addition to the shipped table.
        wall_inclination: inclination of the wall [deg]; None: that of the scene.
        allow_effect_files: whether the Python files that the model names are run.
        hand: name or file of the hand; None: that of the strategy.
        object_rpy: how the object rests: roll, pitch, yaw [rad]; None: as it is described.
        modulus_scale: factor on the shear modulus of the hand's rubber [-].
        without, air_scale [-], displacement [m]: changes of the strategy, see `varied`.
        early_end: whether a trial ends as soon as its result is certain, see `EarlyEnd`.
        finger_contact: whether neighbouring fingers touch each other.
        rubber_friction_scale: factor on the friction of the hand's rubber with anything else [-].
        engine: physics engine, `pybullet` or `mujoco`.
    """

    strategy: str = "surface_constrained"
    object: str = field(default="cylinder", metadata=BY_PLAN)
    scene: str = "table"
    model: str | None = None
    step: float = USUAL_STEP
    segments: int = 5
    offset: float = field(default=OFFSET, metadata=BY_SEED)
    mass_spread: float = field(default=MASS_SPREAD, metadata=BY_SEED)
    options: tuple[str, ...] = ()
    solver: str = "default"
    friction: str | None = None
    wall_inclination: float | None = None
    allow_effect_files: bool = False
    hand: str | None = None
    object_rpy: tuple[float, float, float] | None = None
    modulus_scale: float = field(default=1.0, metadata=BY_PLAN)
    without: tuple[str, ...] = ()
    air_scale: float = 1.0
    displacement: tuple[float, float, float] = (0.0, 0.0, 0.0)
    early_end: bool = False
    finger_contact: bool = field(default=False, metadata=ADDED)
    rubber_friction_scale: float = field(default=1.0, metadata=ADDED)
    engine: str = field(default_factory=default_engine, metadata=ADDED)

    def __post_init__(self) -> None:
        for name in ("options", "object_rpy", "without", "displacement"):
            value = getattr(self, name)
            if isinstance(value, list):  # as JSON has them
                object.__setattr__(self, name, tuple(value))

    def simulation(self, hand: str) -> SimulationConfig:
        """Configuration of the simulation; `hand`, a name or file, is used if the settings name
        none.

        Raises ValueError for settings that cannot be simulated.
        """
        return SimulationConfig(
            hand=self.hand or hand,
            object=self.object,
            scene=self.scene,
            model=self.model,
            step=self.step,
            segments=self.segments,
            object_rpy=self.object_rpy,
            modulus_scale=self.modulus_scale,
            solver=solver_settings(self.solver),
            wall_inclination=self.wall_inclination,
            friction=self.friction,
            finger_contact=self.finger_contact,
            rubber_friction_scale=self.rubber_friction_scale,
            allow_effect_files=self.allow_effect_files,
            engine=self.engine,
        )


@dataclass(frozen=True)
class Trial:
    """One trial: seed, shift of the object [m], factor on its mass, result, and ratio of simulated
    to wall time.
    """

    seed: int
    offset: tuple[float, float]
    mass_scale: float
    result: GraspResult
    real_time_factor: float

    def record(self) -> dict[str, Any]:
        """The trial as plain data for JSON, SI units; numbers that were not observed are null."""
        record = asdict(self)
        record |= record.pop("result")
        unseen = [key for key, value in record.items() if _is_nan(value)]
        return record | dict.fromkeys(unseen)


def _is_nan(value: object) -> bool:
    return isinstance(value, float) and math.isnan(value)


class StartedScene:
    """A scene built from settings, and a snapshot of its start, from which every trial begins."""

    def __init__(self, settings: TrialSettings) -> None:
        self.settings = settings
        self.strategy = varied(
            load_strategy(settings.strategy),
            without=settings.without,
            air_scale=settings.air_scale,
            displacement=settings.displacement,
        )
        self._build()

    def _build(self) -> None:
        self.scene = InProcessScene(Simulation(self.settings.simulation(self.strategy.hand)))
        self._start = self.scene.save()

    def place(self, placement: Placement) -> InProcessScene:
        """The scene at its start, with the object placed as `placement` says."""
        if self.scene.simulation.engine.broken:  # by a trial that diverged
            self.scene.close()
            self._build()
        self.scene.restart(self._start, **vars(placement))
        return self.scene

    def run(self, placement: Placement, **watched: Any) -> GraspResult:
        """One trial from the start to the end of the strategy; `watched` as in `run_in_process`."""
        early = self.settings.early_end
        course = self.empty_course if early else None
        scene = self.place(placement)
        boxes = scene.simulation.object_box, scene.simulation.hand_boxes
        decided = EarlyEnd(self.strategy, course, *boxes) if early else None
        return run_in_process(scene, self.strategy, self.settings.options, decided, **watched)

    @property
    def empty_course(self) -> EmptyHandPath | None:
        """Path of the hand when no object is in its way; None for a strategy that reacts to the
        object, and for scenes with a wall, from which an object can roll back to the hand.
        """
        if self.scene.simulation.scene.wall is not None or looks_at_object(self.strategy.phases):
            return None
        usual = TrialSettings()
        return _empty_course(replace(self.settings, object=usual.object, object_rpy=None))

    def __del__(self) -> None:
        if hasattr(self, "scene"):
            self.scene.close()


@lru_cache(maxsize=4)
def _empty_course(settings: TrialSettings) -> EmptyHandPath:
    """Where the hand moves with its object far away, which serves trials of all objects."""
    course, started = EmptyHandPath(), StartedScene(settings)
    scene = started.place(Placement(OUT_OF_THE_WAY))

    def keep(watch: GraspWatch) -> str:
        """Store the position of the hand; returns a reason to end once the hold begins."""
        course.keep(watch.phase, scene.simulation.hand_boxes)
        return "the hold begins" if watch.stage == STAGE_HOLD else ""

    run_in_process(scene, started.strategy, settings.options, keep)
    return course


@lru_cache(maxsize=1)
def started_scene(settings: TrialSettings) -> StartedScene:
    """The started scene of these settings. Each process keeps the latest one, so that a hand is
    built once for many trials.
    """
    return StartedScene(settings)


def run_trial(seed: int, settings: TrialSettings | None = None) -> Trial:
    """Run one trial to the end of its strategy; raises ValueError for names that do not exist."""
    settings = settings or TrialSettings()
    offset, mass_scale = draw_placement(seed, settings.offset, settings.mass_spread)
    started = started_scene(settings)
    begin = time.perf_counter()
    result = started.run(Placement(offset, mass_scale))
    wall = time.perf_counter() - begin
    return Trial(seed, offset, mass_scale, result, started.scene.time / wall)


def run_in_process(
    scene: InProcessScene,
    strategy: Strategy,
    options: tuple[str, ...],
    decided: Callable[[GraspWatch], str] | None = None,
    **watched: Any,
) -> GraspResult:
    """Run a strategy with some of its options to its end, or until `decided` returns a reason; the
    result's reason names channels at their limits. `watched`: the arguments `on_phase` and `abort`
    of `Sequencer`.
    """
    on_phase, phase = watched.pop("on_phase", None), ""
    held: Adaptability | None = None

    def follow(name: str) -> None:
        """Look at the contacts when the hold is over."""
        nonlocal phase, held
        if phase == strategy.success.hold_phase and scene.observe().touching:
            held = scene.adaptability()
        phase = name
        if on_phase is not None:
            on_phase(name)

    run = Sequencer(scene, strategy, options=options, decided=decided, on_phase=follow, **watched)
    result = run.run()
    result = replace(result, contacts=held if result.gripped else None)
    if not scene.limited:
        return result
    limited = f"relieved at the pressure limit: channel {', '.join(scene.limited)}"
    return replace(result, reason=f"{result.reason}; {limited}")


def run_batch(
    seeds: Iterable[int], settings: TrialSettings | None = None, jobs: int = 1
) -> Iterator[Trial]:
    """Trials of several seeds, each as soon as it and those before it are done.

    With `jobs` above 1 they run in that many processes, which are spawned, as PyBullet does not
    work after a fork.
    """
    settings = settings or TrialSettings()
    seeds = list(seeds)
    if jobs == 1:
        yield from (run_trial(seed, settings) for seed in seeds)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        yield from pool.map(run_trial, seeds, [settings] * len(seeds))


def summarise(trials: list[Trial], settings: TrialSettings) -> dict[str, Any]:
    """A batch as plain data for JSON: settings, number of successes, every trial."""
    successes = sum(trial.result.gripped for trial in trials)
    return {
        "settings": asdict(settings),
        "trials": [trial.record() for trial in trials],
        "gripped": successes,
        "count": len(trials),
    }


def compare_engines(trials: Mapping[str, list[Trial]], name: str) -> Agreement:
    """Verdicts of the same seeds in several engines, from the trials by engine; `name` is what they
    share, such as the object.
    """
    verdicts = {
        f"seed {same[0].seed}": tuple(trial.result.gripped for trial in same)
        for same in zip(*trials.values(), strict=True)
    }
    return Agreement(name, tuple(trials), verdicts)


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Add the options of a command line for the settings of trials, which `read_settings` reads."""
    usual = TrialSettings()
    add = parser.add_argument
    add("--strategy", default=usual.strategy, help="name or .yaml file (%(default)s)")
    add("--object", default=usual.object, help="object to grasp (%(default)s)")
    rests = "roll, pitch, yaw [rad] of the object, 0 0 0 for a cylinder that stands (as it lies)"
    add("--object-rpy", nargs=3, type=float, metavar=("R", "P", "Y"), help=rests)
    add("--scene", default=usual.scene, help="surroundings, such as table or wall (%(default)s)")
    base = "the base model with the weight of the actuators"
    add("--model", default=usual.model, help=f"softhand-model file ({base})")
    add(ALLOW_EFFECT_FILES, action="store_true", help=ALLOW_HELP)
    engine = "physics engine: %(choices)s (%(default)s)"
    add("--engine", choices=ENGINES, default=usual.engine, help=engine)
    add("--step", type=float, default=usual.step, help="time step of the physics [s] (%(default)s)")
    add("--segments", type=int, default=usual.segments, help="segments per actuator (%(default)s)")
    add("--options", nargs="*", default=(), help="optional phases to run, by name")
    add("--solver", default=usual.solver, help="PyBullet's: fast, default or stable (%(default)s)")
    add("--friction", help="file with pairs of materials on top of the shipped table")
    friction = "factor on the friction of the rubber with anything else (%(default)s)"
    add("--rubber-friction-scale", type=float, default=usual.rubber_friction_scale, help=friction)
    add("--wall-inclination", type=float, help="inclination of the wall [deg] (that of the scene)")


def read_settings(options: argparse.Namespace) -> TrialSettings:
    """The settings that are among the options, without those from which a seed draws."""
    given = vars(options)
    names = [setting.name for setting in fields(TrialSettings) if setting.metadata != BY_SEED]
    return TrialSettings(**{name: given[name] for name in names if name in given})


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="softhand trials",
        description="Grasp trials in process, without ROS: seeded offset and mass.",
    )
    add_settings(parser)
    add_engines(parser)
    add = parser.add_argument
    add("--offset", type=_offset, default=OFFSET, help="largest shift in x, y [m] (%(default)s)")
    spread = "largest change of the mass, as a share of it (%(default)s)"
    add("--mass-spread", type=_share, default=MASS_SPREAD, help=spread)
    add("--seeds", type=int, default=10, help="number of trials (%(default)s)")
    add("--first-seed", type=int, default=0, help="seed of the first trial (%(default)s)")
    add("--jobs", type=int, default=1, help="processes at a time (%(default)s)")
    add("--out", type=Path, help="JSON file to write; without it JSON goes to standard output")
    add("--force", action="store_true", help="overwrite the JSON file")
    return parser


def _offset(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= LARGEST_OFFSET:
        raise argparse.ArgumentTypeError(f"expected 0 to {LARGEST_OFFSET:g} m, got {text}")
    return value


def _share(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(f"expected 0 or more and less than 1, got {text}")
    return value


def _run(options: argparse.Namespace) -> int:
    if options.seeds < 1 or options.jobs < 1:
        raise ValueError(f"seeds and jobs: expected 1 or more, got {options.seeds}, {options.jobs}")
    if options.out is not None:
        check_new(options.out, options.force)
    settings = read_settings(options)
    settings = replace(settings, offset=options.offset, mass_spread=options.mass_spread)
    engines = options.engines or (settings.engine,)
    check_engines(engines)
    runs = {name: replace(settings, engine=name) for name in engines}
    trials = {
        name: _batch(options, run, name if options.engines else "") for name, run in runs.items()
    }
    summaries = {name: summarise(trials[name], runs[name]) for name in engines}
    compared = compare_engines(trials, settings.object)
    summary = {"engines": summaries, "agreement": compared.record()}
    if not options.engines:
        summary = summaries[settings.engine]
    text = json.dumps(summary, indent=2)
    if options.out is None:
        print(text)
    else:
        try:
            write_new(options.out, text + "\n", force=True)
        except UnwritableFile:
            print(text)  # so that the trials need not run again
            raise
    told = (
        f"{compared.name}: {compared.text}"
        if options.engines
        else f"gripped {summary['gripped']} of {summary['count']}"
    )
    print(told, file=sys.stderr)
    return 0


def _batch(options: argparse.Namespace, settings: TrialSettings, engine: str) -> list[Trial]:
    """All trials, each told as soon as it is done."""
    trials = []
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    for trial in run_batch(seeds, settings, options.jobs):
        trials.append(trial)
        which = f"{engine} seed {trial.seed}".lstrip()
        count, result = f"[{len(trials)}/{options.seeds}]", trial.result
        print(f"{count} {which}: {result.outcome}, {result.reason}", file=sys.stderr)
    return trials


def main(arguments: list[str] | None = None) -> int:
    """Run a batch from the command line; returns 0, or 2 when the options cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError, NotInstalled) as error:
        print(f"softhand trials: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
