"""Co-design in MuJoCo: the best hand with its motion against the shipped pair, on cylinders,
in the world of the first run: without turn of the object.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.design.co_design import night_results
from bench.row import at_least, stated
from bench.sim.mujoco_hand import MUJOCO, OURS, in_mujoco
from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.simulation import Simulation, SimulationConfig
from thesis.co_design.findings import BEST, SHIPPED_PAIR
from thesis.co_design.plan import NIGHT
from thesis.co_design.trials import HAND, SHIPPED, STRATEGY, design_of, write_design
from thesis.co_design.worlds import trials_of

TAKES = "some minutes"
CYLINDERS = {"training": ("cylinder", "tube", "thin_cylinder"), "held out": ("rod", "marker")}
HEAVY = "water_bottle"  # held out as well
STEP = 0.002  # [s]
ENGINE = "MuJoCo, discrete, elliptic"


def run(count: int, seed: int) -> list[dict[str, Any]]:
    """Grasps of both pairs in both engines, `count` in each; raises Unfinished without a run."""
    results = night_results()
    best = results["searches"][results[BEST]]["winner"]
    return list(rows({BEST: best, SHIPPED_PAIR: SHIPPED}, count, seed))


def rows(designs: dict[str, dict[str, float]], count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Successes, and whether both engines order the pairs alike."""
    configs = list(scenes(count, seed))
    gains = []
    for engine in (OURS, ENGINE):
        held = {
            name: sum(gripped(engine, values, config) for config in configs)
            for name, values in designs.items()
        }
        for name, successes in held.items():
            yield stated(f"co-design, {engine}: {name} pair holds", successes, f"of {len(configs)}")
        gains.append(held[BEST] - held[SHIPPED_PAIR])
    what = "co-design: both engines order the pairs alike"
    if gains[0] * gains[1] == 0:
        yield stated(f"{what}: one has no order", 0, "")
    else:
        yield at_least(what, gains[0] * gains[1] > 0, "", 1)


def scenes(count: int, seed: int) -> Iterator[SimulationConfig]:
    """Cylinders in turns, placed and weighed as in the training world, without turn."""
    names = [*CYLINDERS["training"], *CYLINDERS["held out"], HEAVY]
    lines = trials_of("mujoco", design_of({}), NIGHT.training, seed, range(count))
    for number, line in enumerate(lines):
        yield SimulationConfig(
            object=names[number % len(names)],
            object_offset=line.placement.offset,
            object_mass_scale=line.placement.mass_scale,
            step=STEP,
        )


def gripped(engine: str, values: dict[str, float], config: SimulationConfig) -> bool:
    """Whether a design grips in an engine; one that diverges does not."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_design(SHIPPED | values, folder)
        config = SimulationConfig(**{**vars(config), "hand": str(folder / HAND)})
        strategy = load_strategy(folder / STRATEGY)
        if engine == OURS:
            simulation = Simulation(replace(config, engine=PYBULLET))
        else:
            simulation = in_mujoco(config, MUJOCO[engine])
    try:
        return Sequencer(InProcessScene(simulation), strategy).run().gripped
    finally:
        simulation.close()
