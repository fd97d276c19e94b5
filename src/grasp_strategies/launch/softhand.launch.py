"""All three nodes on one machine: `ros2 launch grasp_strategies softhand.launch.py`.

With `backend:=topic` (the default) the simulator owns valves, tubes and hand, and the driver runs
in its process; with `driver:=topic` in one of its own. With `embedded` or `hardware` the driver has
its own plant, and the simulator is not started. An argument that is given wins over `params_file`;
what neither of them says is the node's own default.

With `strategy:=feix/03` the simulator has what that stored grasp of the Feix taxonomy needs, its
object first of all; `ros2 service call /grasp/surface_constrained std_srvs/srv/Trigger` runs it.

Two hands: launch twice, with `namespace:=left`, and with `namespace:=right publish_clock:=false`.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from grasp_strategies.strategy import load_strategy
from grasp_strategies.strategy.fitting import simulator_parameters

ARGUMENTS = {
    "namespace": ("", "of all nodes; empty: the root"),
    "params_file": ("", "YAML file of parameters for all nodes; empty: none"),
    "record": ("", "new folder for a bag of all topics; empty: nothing is recorded"),
    "hand": ("", "hand, by name or by the path of its YAML file; empty: rbo_hand_2"),
    "scene": ("", "scene, by name or path; empty: table"),
    "object": ("", "object, by name or path; empty: cylinder"),
    "strategy": ("", "what grasp/surface_constrained runs; empty: the strategy of that name"),
    "model": ("", "model file, format softhand-model/1; empty: actuators with their weight"),
    "allow_effect_files": ("", "run the Python files that the model names; empty: false"),
    "engine": ("", "physics engine, pybullet or mujoco; empty: PyBullet if installed"),
    "step": ("", "physics step [s]; empty: 0.002"),
    "segments": ("", "segments an actuator; empty: 5"),
    "finger_contact": ("", "neighbouring fingers touch each other; empty: false"),
    "real_time_factor": ("", "upper bound of simulated over wall time, 0: none; empty: 1"),
    "publish_clock": ("", "the simulator publishes /clock, or follows another's; empty: true"),
    "gui": ("", "open PyBullet's window; empty: false"),
    "use_sim_time": ("", "driver and sequencer follow /clock; empty: true"),
    "driver": (
        "composed",
        "where it runs: composed, in the simulator's process, or topic, beside it",
    ),
    "backend": ("topic", "plant of the driver: topic (the simulator), embedded or hardware"),
    "command_timeout": (
        "",
        "silence of commands after which the driver lets go [s], 0: never, to command by hand; "
        "empty: 5",
    ),
    "hardware_file": ("", "wiring of the box, format pneumaticbox-hardware/1; with hardware"),
}
DRIVERS = ("composed", "topic")
SWITCHES = ("publish_clock", "gui", "use_sim_time", "allow_effect_files", "finger_contact")
TYPES = dict.fromkeys(SWITCHES, bool) | {"segments": int}
TYPES |= dict.fromkeys(("step", "real_time_factor", "command_timeout"), float)  # others are text
# arguments that a node takes, by the name of its parameter
SIMULATOR = {
    "hand": "hand",
    "scene": "scene",
    "object": "object",
    "model_file": "model",
    "allow_effect_files": "allow_effect_files",
    "engine": "engine",
    "step": "step",
    "segments": "segments",
    "finger_contact": "finger_contact",
    "real_time_factor": "real_time_factor",
    "publish_clock": "publish_clock",
    "gui": "gui",
}
DRIVER = {
    "hand": "hand",
    "backend": "backend",
    "hardware_file": "hardware_file",
    "command_timeout": "command_timeout",
    "use_sim_time": "use_sim_time",
}
SEQUENCER = {
    "hand": "hand",
    "strategy.surface_constrained": "strategy",
    "use_sim_time": "use_sim_time",
}


def parameters(given, taken):
    """The parameter file and the arguments for a node that takes the parameters `taken`; the later
    wins.
    """
    values = {
        parameter: ParameterValue(
            LaunchConfiguration(argument), value_type=TYPES.get(argument, str)
        )
        for parameter, argument in taken.items()
        if given[argument]
    }
    file = [given["params_file"]] if given["params_file"] else []
    return [*file, *([values] if values else [])]


def needed(given):
    """Parameters that the simulator needs for a strategy that holds its object out."""
    return [simulator_parameters(load_strategy(given["strategy"]))] if given["strategy"] else []


def nodes(context):
    """The nodes, once the arguments are known."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    common = {"namespace": given["namespace"], "output": "screen"}

    def node(package, executable, name, taken, *first):
        """A node, or without a name several of one process, with the parameters that it takes of
        what was given.
        """
        return Node(
            package=package,
            executable=executable,
            name=name,
            parameters=[*first, *parameters(given, taken)],
            **common,
        )

    # a bag gets the driver's state at every sample
    rates = [{"state_rate": 0.0}] if given["record"] else []
    started = [node("grasp_strategies", "sequencer", "grasp_sequencer", SEQUENCER)]
    simulated = given["backend"] == "topic"
    if given["driver"] not in DRIVERS:
        raise ValueError(f"driver: expected one of {DRIVERS}, got {given['driver']}")
    if simulated and given["driver"] == "composed":
        both = SIMULATOR | DRIVER
        started.append(
            node("softhand_bringup", "hand_with_box", None, both, *rates, *needed(given))
        )
    else:
        started.append(node("pneumaticbox_driver", "driver", "pneumaticbox", DRIVER, *rates))
        if simulated:
            started.append(node("pneuflex_sim", "hand_sim", "hand_sim", SIMULATOR, *needed(given)))
    if given["record"]:
        recorder = {"package": "softhand_bringup", "executable": "recorder", "name": "recorder"}
        started.append(Node(**recorder, arguments=[given["record"]], **common))
    return started


def generate_launch_description():
    """What `ros2 launch` runs."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes)])
