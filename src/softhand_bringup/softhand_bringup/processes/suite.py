"""The nodes of the suite as commands, and the environment in which they run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from softhand_bringup.processes.launcher import NodeCommand, ParameterValue

RECORDER = "recorder"  # the node's name, too
COMMAND_TIMEOUT = 5.0  # [s] after which the driver lets go what the sequencer commands no more


def node_environment(log_folder: Path, domain: int | None = None) -> dict[str, str]:
    """Environment variables for a node; what the user has set stands.

    Args:
        log_folder: where ROS writes its log files.
        domain: ROS_DOMAIN_ID; None keeps the user's.

    >>> node_environment(Path("log"), domain=7)["ROS_DOMAIN_ID"]
    '7'
    """
    environment = dict(os.environ)
    environment.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    environment["ROS_LOG_DIR"] = str(log_folder)
    environment["PYTHONUNBUFFERED"] = "1"
    # several processes share the cores: numpy must not start one thread per core in each
    environment.setdefault("OMP_NUM_THREADS", "1")
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    if domain is not None:
        environment["ROS_DOMAIN_ID"] = str(domain)
    return environment


@dataclass(frozen=True)
class SuiteOptions:
    """What is simulated.

    Args:
        hand, object, scene: names of shipped descriptions, or paths of files.
        strategy: what `grasp/surface_constrained` runs, by name or by the path of its file.
        grasp_type: of the Feix taxonomy, which `grasp/feix` replays.
        grasp_patterns: file of stored grasps; empty: the shipped one.
        model: model file of the physics; empty takes the one that the simulator ships with.
        allow_effect_files: whether the Python files that the model names are run.
        friction: file with pairs of materials on top of the shipped table; empty for none.
        wall_inclination: of the scene's wall [deg]; None: as the scene has it.
        object_offset: shift of the object from its place, x and y [m].
        object_upright: whether the object stands, its axes along those of the world.
        object_mass_scale: factor on the object's mass [-].
        seed: of the sensors' noise and the valves' delays.
        step: physics step [s].
        segments: an actuator.
        finger_contact: whether fingers touch each other.
        real_time_factor: upper bound of simulated over wall time; 0: as fast as it goes.
        gui: open PyBullet's window.
        publish_clock: the simulator publishes /clock; False: it follows another's.
        namespace: of the nodes; empty: the root.
        await_commander: the simulation stands at its start until a strategy runs, so that a run is
            the same each time.
    """

    hand: str = "rbo_hand_2"
    object: str = "cylinder"
    scene: str = "table"
    strategy: str = "surface_constrained"
    grasp_type: int = 1
    grasp_patterns: str = ""
    model: str = ""
    allow_effect_files: bool = False
    friction: str = ""
    wall_inclination: float | None = None
    object_offset: Sequence[float] = field(default=(0.0, 0.0))
    object_upright: bool = False
    object_mass_scale: float = 1.0
    seed: int = 0
    step: float = 0.002
    segments: int = 5
    finger_contact: bool = False
    real_time_factor: float = 0.0
    gui: bool = False
    publish_clock: bool = True
    namespace: str = ""
    await_commander: bool = False


def simulator(options: SuiteOptions) -> NodeCommand:
    """The node `hand_sim`."""
    parameters: dict[str, ParameterValue] = {
        "hand": options.hand,
        "object": options.object,
        "scene": options.scene,
        "object_offset": [float(x) for x in options.object_offset],
        "object_upright": options.object_upright,
        "object_mass_scale": float(options.object_mass_scale),
        "seed": options.seed,
        "step": float(options.step),
        "segments": options.segments,
        "finger_contact": options.finger_contact,
        "real_time_factor": float(options.real_time_factor),
        "gui": options.gui,
        "publish_clock": options.publish_clock,
        "await_commander": options.await_commander,
    }
    if options.model:
        parameters["model_file"] = options.model
        parameters["allow_effect_files"] = options.allow_effect_files
    if options.friction:
        parameters["friction_file"] = options.friction
    if options.wall_inclination is not None:
        parameters["wall_inclination"] = float(options.wall_inclination)
    return NodeCommand("hand_sim", "pneuflex_sim.ros.node", parameters)


def driver(options: SuiteOptions, command_timeout: float = 0.0) -> NodeCommand:
    """The node `pneumaticbox`, on the simulator's plant; `command_timeout` [s], 0 for none."""
    parameters: dict[str, ParameterValue] = {"hand": options.hand, "use_sim_time": True}
    if command_timeout:
        parameters["command_timeout"] = command_timeout
    return NodeCommand("driver", "pneumaticbox_driver.ros.node", parameters)


def sequencer(options: SuiteOptions) -> NodeCommand:
    """The node `grasp_sequencer`."""
    parameters: dict[str, ParameterValue] = {
        "hand": options.hand,
        "strategy.surface_constrained": options.strategy,
        "grasp_type": options.grasp_type,
        "grasp_patterns": options.grasp_patterns,
        "use_sim_time": True,
    }
    return NodeCommand("sequencer", "grasp_strategies.ros.node", parameters)


def monitor(
    options: SuiteOptions, further: Mapping[str, ParameterValue] | None = None
) -> NodeCommand:
    """The node `monitor`, with the model of the options, whatever the simulator has, and further
    parameters of its own.
    """
    parameters: dict[str, ParameterValue] = {"hand": options.hand, "use_sim_time": True}
    parameters.update(further or {})
    if options.model:
        parameters["model_file"] = options.model
        parameters["allow_effect_files"] = options.allow_effect_files
    return NodeCommand("monitor", "model_lab.ros.monitor", parameters)


def recorder(folder: Path, topics: Sequence[str] = ()) -> NodeCommand:
    """The recorder, writing to a bag folder that does not exist yet; all topics, or these alone."""
    chosen = ("--topics", *topics) if topics else ()
    return NodeCommand(RECORDER, "softhand_bringup.ros.recorder", arguments=(str(folder), *chosen))


def figures(options: SuiteOptions, bag: Path, folder: Path) -> NodeCommand:
    """The pictures of a bag; a process of its own, as PyBullet talks to the terminal."""
    names = ["--hand", options.hand, "--object", options.object, "--scene", options.scene]
    if options.wall_inclination is not None:
        names += ["--wall-inclination", str(options.wall_inclination)]
    return NodeCommand(
        "figures", "softhand_bringup.figures", arguments=(str(bag), str(folder), *names)
    )


def three_nodes(options: SuiteOptions) -> list[NodeCommand]:
    """Simulator, driver and sequencer, in the order in which they are started; in a namespace, the
    names of their processes begin with it.
    """
    commands = [simulator(options), driver(options, COMMAND_TIMEOUT), sequencer(options)]
    space = options.namespace.strip("/")
    if not space:
        return commands
    return [
        replace(
            command,
            name=f"{space.replace('/', '_')}_{command.name}",
            remappings={**command.remappings, "__ns": f"/{space}"},
        )
        for command in commands
    ]
