"""All three nodes on one machine: `ros2 launch grasp_strategies softhand.launch.py`.

With `backend:=topic` (the default) the simulator owns valves, tubes and hand. With `embedded` or
`hardware` the driver has its own plant, and the simulator is not started.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = {
    "hand": ("rbo_hand_2", "hand, by name or by the path of its YAML file"),
    "scene": ("table", "scene, by name or path"),
    "object": ("cylinder", "object, by name or path"),
    "strategy": ("surface_constrained", "what grasp/surface_constrained runs, by name or path"),
    "model": ("", "model file, format softhand-model/1; empty: actuators with their weight"),
    "gui": ("false", "open PyBullet's window"),
    "use_sim_time": ("true", "driver and sequencer follow /clock"),
    "backend": ("topic", "plant of the driver: topic (the simulator), embedded or hardware"),
    "command_timeout": (
        "5.0",
        "silence of commands after which the driver lets go [s]; 0: never, to command by hand",
    ),
    "hardware_file": ("", "wiring of the box, format pneumaticbox-hardware/1; with hardware"),
}


def text(name):
    """Value of an argument as a string, also when it looks like a number."""
    return ParameterValue(LaunchConfiguration(name), value_type=str)


def number(name):
    """Value of an argument as a number with a point."""
    return ParameterValue(LaunchConfiguration(name), value_type=float)


def switch(name):
    """Value of an argument as a boolean."""
    return ParameterValue(LaunchConfiguration(name), value_type=bool)


def simulator():
    """The node hand_sim; it makes the time that the others follow, so it has no use_sim_time."""
    return Node(
        package="pneuflex_sim",
        executable="hand_sim",
        name="hand_sim",
        output="screen",
        condition=IfCondition(EqualsSubstitution(LaunchConfiguration("backend"), "topic")),
        parameters=[
            {
                "hand": text("hand"),
                "scene": text("scene"),
                "object": text("object"),
                "model_file": text("model"),
                "gui": switch("gui"),
            }
        ],
    )


def driver():
    """The node pneumaticbox."""
    return Node(
        package="pneumaticbox_driver",
        executable="driver",
        name="pneumaticbox",
        output="screen",
        parameters=[
            {
                "hand": text("hand"),
                "backend": text("backend"),
                "hardware_file": text("hardware_file"),
                "command_timeout": number("command_timeout"),
                "use_sim_time": switch("use_sim_time"),
            }
        ],
    )


def sequencer():
    """The node grasp_sequencer."""
    return Node(
        package="grasp_strategies",
        executable="sequencer",
        name="grasp_sequencer",
        output="screen",
        parameters=[
            {
                "hand": text("hand"),
                "strategy.surface_constrained": text("strategy"),
                "use_sim_time": switch("use_sim_time"),
            }
        ],
    )


def generate_launch_description():
    """What `ros2 launch` runs."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, simulator(), driver(), sequencer()])
