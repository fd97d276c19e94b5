"""RViz for a running simulator: `ros2 launch softhand_bringup view.launch.py`.

`hand`, `segments` and `namespace` must be those of the simulator.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import Command, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {
    "hand": ("rbo_hand_2", "hand, by name or by the path of its YAML file"),
    "segments": ("5", "segments of each actuator"),
    "namespace": ("", "of the nodes and of the frames; empty: the root"),
}


def robot_state_publisher(context):
    """Publishes the links of the URDF as frames, from the simulator's joint states."""
    namespace = LaunchConfiguration("namespace").perform(context).strip("/")
    hand, segments = LaunchConfiguration("hand"), LaunchConfiguration("segments")
    urdf = Command(["ros2 run pneuflex_sim hand urdf ", hand, " --segments ", segments])
    publisher = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        name="robot_state_publisher",
        namespace=namespace,
        parameters=[
            {"robot_description": ParameterValue(urdf, value_type=str), "use_sim_time": True},
            *([{"frame_prefix": f"{namespace}/"}] if namespace else []),
        ],
        remappings=[("joint_states", "hand/joint_states")],
    )
    return [publisher]


def rviz():
    """RViz with the displays of the suite."""
    share = FindPackageShare("softhand_bringup")
    return Node(
        package="rviz2",
        executable="rviz2",
        name="rviz2",
        namespace=LaunchConfiguration("namespace"),
        arguments=["-d", PathJoinSubstitution([share, "config", "softhand.rviz"])],
        parameters=[{"use_sim_time": True}],
    )


def generate_launch_description():
    """What `ros2 launch` runs."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=robot_state_publisher), rviz()])
