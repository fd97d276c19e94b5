"""All strategies over ROS, by the services, beside the same placements in process.

Over ROS there are the valves, the tubes and the noisy sensors of the plant too. The cells of the
table of a strategy are the seeds, each with a place, a mass and a pneumatic box of its own. Every
finished grasp is kept under the state of the code: stopped, the row goes on where it was.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

from bench.kept import Unfinished, append, read, revision_of
from bench.robust.rig import START_LIMIT, RigError, launched
from bench.row import at_least, stated
from grasp_strategies.judging.judge import NOT_BEGUN, OUTCOME_GRIPPED
from grasp_strategies.strategy import load_strategy
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.ros.demo import USUAL_OBJECT, object_place
from softhand_ros.topics import latched
from softhand_trials.trials import Placement, TrialSettings, draw_placement, started_scene

TAKES = "an hour"
STRATEGIES = {
    "surface_constrained": "surface_constrained",
    "rbo_hand_1_from_above": "surface_constrained",
    "rbo_hand_1_push": "push",
    "rbo_hand_1_surface": "surface_constrained",
    "rbo_hand_1_edge": "edge",
    "rbo_hand_2_slide_to_wall": "slide_to_wall",
}
SEEDS, MANY, USUAL = 5, 40, "surface_constrained"  # seeds a strategy, and of one of them
AGREE = 95.0  # share of verdicts that are as in process [%]
STEP = 0.002
GRASP_LIMIT = 400.0  # wall time of a grasp beside other work [s]
OF_THE_OTHERS = ("sim/reset", "pneumaticbox/reset")  # services of nodes that must have started
LINES = Path("out/bench/over_ros.jsonl")
SOURCES = tuple(
    f"src/{name}/{name}"
    for name in (
        "softhand_model",
        "softhand_ros",
        "pneuflex_sim",
        "pneumaticbox_driver",
        "grasp_strategies",
    )
)

Record = dict[str, Any]


@dataclass(frozen=True)
class Grasp:
    """One grasp of the row: `way` is its name in `WAYS`."""

    way: str
    strategy: str
    seed: int

    def key(self, revision: str) -> str:
        """Its name among those that are kept."""
        return f"{self.strategy}|{self.seed}|{self.way}|{revision}"


def run(
    seed: int,
    minutes: float = 120.0,
    seeds: int = SEEDS,
    many: int = MANY,
    names: tuple[str, ...] = tuple(STRATEGIES),
) -> list[dict[str, Any]]:
    """Successes of each strategy both ways, and how many verdicts agree.

    Raises:
        Unfinished: after so many minutes.
    """
    places = {name: range(seed, seed + seeds) for name in names}
    further = range(seed, seed + many) if USUAL in names else range(0)
    grasps = [Grasp(way, name, k) for way in WAYS for name in names for k in places[name]]
    grasps += [Grasp(way, USUAL, k) for way in WAYS for k in further if k not in places[USUAL]]
    found = held_of(sorted(grasps, key=lambda grasp: list(WAYS).index(grasp.way)), minutes)
    rows = []
    for name in names:
        for way in WAYS:
            held = sum(found[Grasp(way, name, k)] for k in places[name])
            rows.append(stated(f"{name}, {seeds} seeds: lifted {way}", held, ""))
    pairs = [(name, k) for name in names for k in places[name]]
    rows.append(_agreement(f"{len(names)} strategies, {seeds} seeds each", found, pairs))
    if further:
        rows.append(_agreement(f"{USUAL}, {many} seeds", found, [(USUAL, k) for k in further]))
    return rows


def _agreement(what: str, found: dict[Grasp, bool], pairs: list[tuple[str, int]]) -> dict[str, Any]:
    own, others = ([found[Grasp(way, *pair)] for pair in pairs] for way in WAYS)
    agreed = sum(a == b for a, b in zip(own, others, strict=True))
    name = f"{what}: verdicts over ROS that are as in process"
    return at_least(name, 100.0 * agreed / len(pairs), "%", AGREE)


def held_of(grasps: list[Grasp], minutes: float) -> dict[Grasp, bool]:
    """Whether each grasp lifts its object; those that are not kept are made.

    Raises:
        Unfinished: after so many minutes.
    """
    revision, end = revision_of(SOURCES, (".py", ".yaml")), time.monotonic() + 60 * minutes
    kept = read(LINES)
    left = [grasp for grasp in grasps if grasp.key(revision) not in kept]
    for number, grasp in enumerate(left):
        if time.monotonic() > end:
            raise Unfinished(f"{len(left) - number} of {len(grasps)} grasps are left")
        record = WAYS[grasp.way](grasp.strategy, options_of(grasp.strategy, grasp.seed))
        print(f"  {grasp.strategy}, seed {grasp.seed}, {grasp.way}: {record['reason']}", flush=True)
        kept[grasp.key(revision)] = record | {"key": grasp.key(revision)}
        append(kept[grasp.key(revision)], LINES)
    return {grasp: kept[grasp.key(revision)]["outcome"] == OUTCOME_GRIPPED for grasp in grasps}


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


def in_process(name: str, options: SuiteOptions) -> Record:
    """The result of a grasp in process."""
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
    return started_scene(settings).run(Placement((x, y), options.object_mass_scale)).summary()


def over_ros(name: str, options: SuiteOptions) -> Record:
    """The same over ROS, as `grasp/result` tells it.

    Raises:
        RigError: a node did not come up, the service did not answer, or the grasp did not begin.
    """
    service = f"grasp/{STRATEGIES[name]}"
    with launched(suite.three_nodes(options)) as rig:
        told: list[DiagnosticArray] = []
        rig.node.create_subscription(DiagnosticArray, "grasp/result", told.append, latched(1))
        for started in (service, *OF_THE_OTHERS):
            rig.need(rig.client(Trigger, started).service_is_ready, START_LIMIT, started)
        call = rig.client(Trigger, service).call_async(Trigger.Request())
        rig.need(call.done, GRASP_LIMIT, f"an answer of {service}")
        rig.need(lambda: told, START_LIMIT, f"the result of {call.result().message}")
        result = {value.key: value.value for value in told[-1].status[0].values}
        if result["cause"] == NOT_BEGUN:
            raise RigError(result["reason"])
        return result


WAYS: dict[str, Callable[[str, SuiteOptions], Record]] = {
    "in process": in_process,
    "over ROS": over_ros,
}
