"""The whole hand against a MuJoCo model of it: same hand, object, strategy and judge, in turn.

A step of either engine counts with all that belongs to it, air and springs too. MuJoCo is measured
with several settings, and compared by the fastest of those with which it holds the object in every
turn; CPU times of one thread.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mujoco

from bench.row import at_least, stated
from bench.sim.timing import StepTimes, timed_steps
from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import MUJOCO as MUJOCO_ENGINE
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.engines.mujoco.world import IMPEDANCE_RATIO
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_trials.trials import draw_placement

STRATEGY = "surface_constrained"
STEPS = (0.001, 0.002, 0.005, 0.010, 0.020, 0.050)
COMPARED, TARGET = 0.001, 0.4  # step [s], and our factor over MuJoCo's [-]
ROUNDS = 3
OURS = "ours"


@dataclass(frozen=True)
class Settings:
    """Integrator, friction cone, and ratio of frictional to normal impedance; by default those of
    the simulator's engine.
    """

    integrator: str = "discrete"
    cone: str = "elliptic"
    impedance_ratio: float = IMPEDANCE_RATIO


MUJOCO = {
    "MuJoCo, discrete, elliptic": Settings("discrete", "elliptic", IMPEDANCE_RATIO),
    "MuJoCo, discrete, pyramidal": Settings("discrete", "pyramidal", 100.0),
    "MuJoCo, implicitfast, elliptic": Settings("implicitfast", "elliptic", IMPEDANCE_RATIO),
}


@dataclass(frozen=True)
class Grasp:
    """One grasp: times of its steps, contact points at most, outcome."""

    times: StepTimes
    points: int
    result: GraspResult


def grasp(engine: str, seed: int, step: float, segments: int = 5) -> Grasp:
    """The grasp of a seed by an engine: `ours` or one of `MUJOCO`."""
    config = replace(configuration(seed, step), segments=segments)
    if engine == OURS:
        bullet = (pybullet, "stepSimulation")
        config = replace(config, engine=PYBULLET)
        return _run(lambda: Simulation(config), Simulation, bullet, _bullet_points)
    settings, stepped = MUJOCO[engine], (mujoco, "mj_step")
    return _run(lambda: in_mujoco(config, settings), Simulation, stepped, _points)


def in_mujoco(config: SimulationConfig, settings: Settings | None = None) -> Simulation:
    """The simulation with engine mujoco and these settings of it."""
    simulation, chosen = Simulation(replace(config, engine=MUJOCO_ENGINE)), settings or Settings()
    option = simulation.engine.model.opt
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{chosen.integrator.upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{chosen.cone.upper()}")
    option.impratio = chosen.impedance_ratio
    return simulation


def configuration(seed: int, step: float) -> SimulationConfig:
    """The scene of a seed."""
    offset, scale = draw_placement(seed)
    return SimulationConfig(
        hand=load_strategy(STRATEGY).hand,
        step=step,
        object_offset=offset,
        object_mass_scale=scale,
    )


def _run(
    build: Callable[[], Any], simulator: type, engine: tuple[Any, str], count: Callable[[Any], int]
) -> Grasp:
    points: list[int] = []
    simulation = build()
    try:
        with timed_steps(lambda now: points.append(count(now)), simulator, engine) as times:
            result = Sequencer(InProcessScene(simulation), load_strategy(STRATEGY)).run()
    finally:
        simulation.close()
    return Grasp(times, max(points), result)


def _bullet_points(simulation: Simulation) -> int:
    return len(pybullet.getContactPoints(physicsClientId=simulation.engine.world.client))


def _points(simulation: Simulation) -> int:
    return int(simulation.engine.data.ncon)


def rows(small: bool) -> list[dict[str, Any]]:
    """Ratio of the real-time factors, what each engine does at each step, largest steps."""
    for engine in (OURS, *MUJOCO):
        grasp(engine, 0, 0.01)  # compile
    runs = {step: _in_rounds(step, 1 if small else ROUNDS) for step in STEPS}
    print(outcomes(runs), flush=True)
    found = []
    for step, grasps in runs.items():
        found += _compared(grasps, step) + _described(grasps, step)
    for engine in (OURS, *MUJOCO):
        holding = [step for step in STEPS if _hold(runs[step][engine])]
        largest = 1e3 * max(holding, default=0.0)
        found.append(stated(f"whole hand, {engine}: largest step that holds", largest, "ms"))
    return found


def _in_rounds(step: float, rounds: int) -> dict[str, list[Grasp]]:
    """Grasps of a step by engine, a seed a round."""
    runs: dict[str, list[Grasp]] = {engine: [] for engine in (OURS, *MUJOCO)}
    for seed in range(rounds):
        for engine, grasps in runs.items():
            grasps.append(grasp(engine, seed, step))
    return runs


def outcomes(runs: dict[float, dict[str, list[Grasp]]]) -> str:
    """Table in Markdown: median real-time factor and worst slip [mm] where an engine holds the
    object in every round, else in how many it does.
    """
    head = "".join(f" {1e3 * step:g} ms |" for step in runs)
    lines = [f"| real-time factor (slip [mm]) |{head}", "|---" * (len(runs) + 1) + "|"]
    for engine in (OURS, *MUJOCO):
        cells = "".join(f" {_cell(runs[step][engine], step)} |" for step in runs)
        lines.append(f"| {engine} |{cells}")
    return "\n".join(lines)


def _cell(grasps: list[Grasp], step: float) -> str:
    if not _hold(grasps):
        return f"{sum(run.result.gripped for run in grasps)} of {len(grasps)}"
    return f"{_factor(grasps, step):.1f} ({1e3 * _slip(grasps):.1f})"


def _factor(grasps: list[Grasp], step: float) -> float:
    return statistics.median(run.times.factor(step) for run in grasps)


def _slip(grasps: list[Grasp]) -> float:
    return max(run.result.slip for run in grasps)


def _hold(grasps: list[Grasp]) -> bool:
    return all(run.result.gripped for run in grasps)


def _compared(runs: dict[str, list[Grasp]], step: float) -> list[dict[str, Any]]:
    """Our real-time factor over the best of MuJoCo's, where both hold the object."""
    best = [
        statistics.median(
            ours.times.factor(step) / theirs.times.factor(step)
            for ours, theirs in zip(runs[OURS], runs[engine], strict=True)
        )
        for engine in MUJOCO
        if _hold(runs[engine])
    ]
    if not best or not _hold(runs[OURS]):
        return []
    name = f"whole hand, {1e3 * step:g} ms: real-time factor over MuJoCo's"
    if step == COMPARED:
        return [at_least(name, min(best), "", TARGET)]
    return [stated(name, min(best), "")]


def _described(runs: dict[str, list[Grasp]], step: float) -> list[dict[str, Any]]:
    """What each engine did at a step."""
    found = []
    for engine, grasps in runs.items():
        name = f"whole hand, {1e3 * step:g} ms, {engine}"
        gripped = sum(run.result.gripped for run in grasps)
        found.append(stated(f"{name}: gripped", gripped, f"of {len(grasps)}"))
        if gripped < len(grasps):
            continue
        found.append(stated(f"{name}: real-time factor", _factor(grasps, step), ""))
        found.append(stated(f"{name}: slip, worst", 1e3 * _slip(grasps), "mm"))
        if step == COMPARED:
            found += _closer(name, grasps)
    return found


def _closer(name: str, grasps: list[Grasp]) -> list[dict[str, Any]]:
    """Where the time goes, and how the grasp went."""
    share = statistics.median(run.times.share() for run in grasps)
    lift = statistics.mean(run.result.lift_height for run in grasps)
    return [
        stated(f"{name}: share of the engine's step", 100 * share, "%"),
        stated(f"{name}: contact points, most", max(run.points for run in grasps), ""),
        stated(f"{name}: lift, mean", 1e3 * lift, "mm"),
    ]
