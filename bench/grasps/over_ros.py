"""All strategies over ROS, by the services, beside the same placements in process.

Over ROS there are the valves, the tubes and the noisy sensors of the plant too. The cells of the
table of a strategy are the seeds, each with a place, a mass and a pneumatic box of its own.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from std_srvs.srv import Trigger

from bench.robust.rig import GRASP_LIMIT, START_LIMIT, RigError, launched
from bench.row import at_least, stated
from grasp_strategies.strategy import load_strategy
from grasp_strategies.trials import Placement, TrialSettings, draw_placement, started_scene
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import USUAL_OBJECT, object_place

STRATEGIES = {
    "surface_constrained": "surface_constrained",
    "rbo_hand_1_from_above": "surface_constrained",
    "rbo_hand_1_push": "push",
    "rbo_hand_1_surface": "surface_constrained",
    "rbo_hand_1_edge": "edge",
    "rbo_hand_2_slide_to_wall": "slide_to_wall",
}
SEEDS, AGREE = 5, 95.0  # seeds a strategy; share of verdicts that are as in process [%]
STEP = 0.002


def run(
    seed: int, seeds: int = SEEDS, names: tuple[str, ...] = tuple(STRATEGIES)
) -> list[dict[str, Any]]:
    """Successes of each strategy both ways, and how many verdicts agree."""
    rows, agreed = [], 0
    for name in names:
        options = [options_of(name, seed + k) for k in range(seeds)]
        ours = [in_process(name, given) for given in options]
        theirs = [over_ros(name, given) for given in options]
        agreed += sum(a == b for a, b in zip(ours, theirs, strict=True))
        rows.append(stated(f"{name}, {seeds} seeds: lifted in process", sum(ours), ""))
        rows.append(stated(f"{name}, {seeds} seeds: lifted over ROS", sum(theirs), ""))
    share = 100.0 * agreed / (seeds * len(names))
    return [*rows, at_least("verdicts over ROS that are as in process", share, "%", AGREE)]


def options_of(name: str, seed: int) -> SuiteOptions:
    """The world in which a strategy was tried, with what the seed draws."""
    strategy = load_strategy(name)
    tried, thing = strategy.tried_with, next(iter(strategy.objects), USUAL_OBJECT)
    (dx, dy), mass_scale = draw_placement(seed)
    x, y = object_place(tried, thing)
    return SuiteOptions(
        hand=strategy.hand,
        strategy=name,
        object=thing,
        scene=tried.scene,
        model=tried.model,
        segments=tried.segments,
        wall_inclination=tried.wall_inclination,
        object_offset=(x + dx, y + dy),
        object_upright=thing in tried.upright,
        object_mass_scale=mass_scale,
        seed=seed,
        step=STEP,
        await_commander=True,
    )


def in_process(name: str, options: SuiteOptions) -> bool:
    """Whether the object is lifted in process."""
    settings = TrialSettings(
        name,
        options.object,
        options.scene,
        options.model or None,
        STEP,
        options.segments,
        wall_inclination=options.wall_inclination,
    )
    if options.object_upright:
        settings = replace(settings, object_rpy=(0.0, 0.0, 0.0))
    x, y = options.object_offset
    placement = Placement((x, y), options.object_mass_scale)
    result = started_scene(settings).run(placement)
    print(f"  {name}, seed {options.seed}, in process: {result.reason}", flush=True)
    return result.gripped


def over_ros(name: str, options: SuiteOptions) -> bool:
    """Whether the object is lifted over ROS."""
    service = f"grasp/{STRATEGIES[name]}"
    with launched(suite.three_nodes(options)) as rig:
        client = rig.client(Trigger, service)
        try:
            rig.need(client.service_is_ready, START_LIMIT, service)
            call = client.call_async(Trigger.Request())
            rig.need(call.done, GRASP_LIMIT, f"an answer of {service}")
        except RigError as error:
            print(f"  {name}, seed {options.seed}, over ROS: {error}", flush=True)
            return False
        answer = call.result()
        print(f"  {name}, seed {options.seed}, over ROS: {answer.message}", flush=True)
        return bool(answer.success)
