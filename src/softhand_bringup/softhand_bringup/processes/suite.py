"""The commands of the suite's nodes, and their environment variables."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from softhand_bringup.processes.launcher import NodeCommand, ParameterValue
from softhand_model.usual_step import USUAL_STEP

RECORDER = "recorder"  # the node's name, too
HAND_WITH_BOX = "hand_with_box"
SIM_TIME = "use_sim_time"
COMPOSED, TOPIC = DRIVERS = ("composed", "topic")  # where the driver runs


def node_environment(log_folder: Path, domain: int | None = None) -> dict[str, str]:
    """Environment variables for a node; those that the user has set are kept.

    Args:
        log_folder: folder for the log files of ROS.
        domain: ROS_DOMAIN_ID; None: that of the user.

    >>> node_environment(Path("log"), domain=7)["ROS_DOMAIN_ID"]
    '7'
    """
    environment = dict(os.environ)
    environment.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    environment["ROS_LOG_DIR"] = str(log_folder)
    environment["PYTHONUNBUFFERED"] = "1"
    # several processes share the cores: numpy must not start a thread per core in each of them
    environment.setdefault("OMP_NUM_THREADS", "1")
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    if domain is not None:
        environment["ROS_DOMAIN_ID"] = str(domain)
    return environment


@dataclass(frozen=True)
class SuiteOptions:
    """Options of the simulation.

    Args:
        hand, object, scene: names of shipped descriptions, or paths of files.
        strategy: strategy of the service `grasp/surface_constrained`, by name or by the path of its
            file.
        model: model file of the physics; empty: the simulator's default.
        allow_effect_files: whether the Python files that the model names are run.
        friction: file with pairs of materials in addition to the shipped table; empty: no file.
        wall_inclination: inclination of the wall [deg]; None: that of the scene.
        object_offset: shift of the object from its place, x and y [m].
        object_upright: whether the object stands upright, its axes parallel to those of the world.
        object_mass_scale: factor on the object's mass [-].
        seed: seed of the sensors' noise and of the scatter of the valves' delays.
        step: physics step [s].
        segments: number of segments per actuator.
        finger_contact: whether contacts between fingers are simulated.
        engine: physics engine; empty: the simulator's default.
        real_time_factor: upper bound of simulated over wall time; 0: as fast as possible.
        gui: whether PyBullet's window is opened.
        publish_clock: whether the simulator publishes /clock; otherwise it follows another clock.
        namespace: namespace of the nodes; empty: the root.
        await_commander: whether the simulation waits at its start until a strategy runs, which
            makes runs reproducible.
        enclave: ROS enclave of the nodes, by which the run recognizes them; empty: none.
        state_rate: rate of the driver's states [Hz]; 0: every sample, for a bag.
        driver: `composed`: in the simulator's process; `topic`: in a process of its own.
    """

    hand: str = "rbo_hand_2"
    object: str = "cylinder"
    scene: str = "table"
    strategy: str = "surface_constrained"
    model: str = ""
    allow_effect_files: bool = False
    friction: str = ""
    wall_inclination: float | None = None
    object_offset: Sequence[float] = field(default=(0.0, 0.0))
    object_upright: bool = False
    object_mass_scale: float = 1.0
    seed: int = 0
    step: float = USUAL_STEP
    segments: int = 5
    finger_contact: bool = False
    engine: str = ""
    real_time_factor: float = 0.0
    gui: bool = False
    publish_clock: bool = True
    namespace: str = ""
    await_commander: bool = False
    enclave: str = ""
    state_rate: float = 100.0
    driver: str = COMPOSED


def simulator(options: SuiteOptions) -> NodeCommand:
    """Command of the node `hand_sim`."""
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
        "engine": options.engine,
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
    return NodeCommand("hand_sim", "pneuflex_sim.ros.node", parameters, enclave=options.enclave)


def driver(options: SuiteOptions, command_timeout: float | None = None) -> NodeCommand:
    """Command of the node `pneumaticbox` with the simulated plant; `command_timeout` [s]; 0: no
    time-out, None: the node's default.
    """
    parameters: dict[str, ParameterValue] = {
        "hand": options.hand,
        "state_rate": float(options.state_rate),
        SIM_TIME: True,
    }
    if command_timeout is not None:
        parameters["command_timeout"] = command_timeout
    return NodeCommand(
        "driver", "pneumaticbox_driver.ros.node", parameters, enclave=options.enclave
    )


def sequencer(options: SuiteOptions) -> NodeCommand:
    """Command of the node `grasp_sequencer`."""
    parameters: dict[str, ParameterValue] = {
        "hand": options.hand,
        "strategy.surface_constrained": options.strategy,
        SIM_TIME: True,
    }
    return NodeCommand(
        "sequencer", "grasp_strategies.ros.node", parameters, enclave=options.enclave
    )


def monitor(
    options: SuiteOptions, further: Mapping[str, ParameterValue] | None = None
) -> NodeCommand:
    """Command of the node `monitor` with the model of the options, which may differ from the
    simulator's, and with `further` parameters.
    """
    parameters: dict[str, ParameterValue] = {"hand": options.hand, SIM_TIME: True}
    parameters.update(further or {})
    if options.model:
        parameters["model_file"] = options.model
        parameters["allow_effect_files"] = options.allow_effect_files
    return NodeCommand("monitor", "model_lab.ros.monitor", parameters, enclave=options.enclave)


def recorder(folder: Path, topics: Sequence[str] = ()) -> NodeCommand:
    """Command of the recorder, which writes all topics, or only `topics` if there are any, to a bag
    folder that must not exist yet.
    """
    chosen = ("--topics", *topics) if topics else ()
    return NodeCommand(RECORDER, "softhand_bringup.ros.recorder", arguments=(str(folder), *chosen))


def figures(options: SuiteOptions, bag: Path, folder: Path) -> NodeCommand:
    """Command that draws the pictures of a bag into a folder; a process of its own, as PyBullet
    prints to the terminal.
    """
    names = ["--hand", options.hand, "--object", options.object, "--scene", options.scene]
    if options.wall_inclination is not None:
        names += ["--wall-inclination", str(options.wall_inclination)]
    return NodeCommand(
        "figures", "softhand_bringup.figures", arguments=(str(bag), str(folder), *names)
    )


def hand_with_box(options: SuiteOptions, command_timeout: float | None = None) -> list[NodeCommand]:
    """Commands of the nodes `hand_sim` and `pneumaticbox`, in one process or in two, as
    `options.driver` says; `command_timeout` as in `driver`.

    Raises:
        ValueError: `options.driver` is none of DRIVERS.
    """
    if options.driver not in DRIVERS:
        raise ValueError(f"driver: expected one of {', '.join(DRIVERS)}, got {options.driver}")
    hand, box = simulator(options), driver(options, command_timeout)
    if options.driver == TOPIC:
        return [hand, box]
    # the clock of the node `pneumaticbox` alone, which follows it unless told otherwise
    own = {name: value for name, value in box.parameters.items() if name != SIM_TIME}
    module = "softhand_bringup.ros.hand_with_box.node"
    return [replace(hand, name=HAND_WITH_BOX, module=module, parameters={**hand.parameters, **own})]


def suite_nodes(options: SuiteOptions) -> list[NodeCommand]:
    """Commands of simulator, driver and sequencer in the order of their start; simulator and driver
    run in one process or in two, as `options.driver` says. Names of the processes begin with the
    namespace, if there is one.
    """
    return _in_namespace([*hand_with_box(options), sequencer(options)], options)


def three_nodes(options: SuiteOptions) -> list[NodeCommand]:
    """As `suite_nodes`, in three processes whatever `options.driver` says."""
    return suite_nodes(replace(options, driver=TOPIC))


def _in_namespace(commands: list[NodeCommand], options: SuiteOptions) -> list[NodeCommand]:
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
