"""The launch files, evaluated with a stand-in for the launch API (launch_ros is not on PyPI).

The stand-in keeps what the file says and checks the keyword arguments against those of Jazzy's
classes; it cannot show that the real `ros2 launch` accepts the file.
"""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
import yaml

SOURCES = Path(__file__).parents[2] / "src"
ARGUMENTS = {
    "hand", "scene", "object", "strategy", "model", "gui", "use_sim_time", "backend",
    "hardware_file",
}  # fmt: skip
NODE_KEYWORDS = {
    "package", "executable", "name", "namespace", "parameters", "remappings", "arguments",
    "output", "condition", "emulate_tty", "respawn", "sigterm_timeout", "exec_name",
}  # fmt: skip


def _node(**keywords):
    unknown = set(keywords) - NODE_KEYWORDS
    if unknown:
        raise TypeError(f"Node has no keyword {unknown}")
    return SimpleNamespace(kind="node", **keywords)


def _argument(name, *, default_value=None, description=None, choices=None):
    return SimpleNamespace(kind="argument", name=name, default=default_value, text=description)


def _value(value, *, value_type=None, description=None):
    return SimpleNamespace(kind="parameter", name=value.name, type=value_type)


def _text(part):
    """A part of a text: as it is, or the name of the argument that stands for it."""
    return part if isinstance(part, str) else f"${part.name}"


STAND_IN = {
    "launch": {"LaunchDescription": lambda entities: SimpleNamespace(entities=list(entities))},
    "launch.actions": {"DeclareLaunchArgument": _argument},
    "launch.conditions": {"IfCondition": lambda predicate: predicate},
    "launch.substitutions": {
        "LaunchConfiguration": lambda name: SimpleNamespace(kind="configuration", name=name),
        "Command": lambda parts: SimpleNamespace(name="".join(map(_text, parts))),
        "PathJoinSubstitution": lambda parts: "/".join(map(_text, parts)),
        "EqualsSubstitution": lambda left, right: ("equals", left.name, right),
    },
    "launch_ros": {},
    "launch_ros.actions": {"Node": _node},
    "launch_ros.parameter_descriptions": {"ParameterValue": _value},
    "launch_ros.substitutions": {"FindPackageShare": lambda name: f"<{name}>"},
}


@pytest.fixture
def stand_in(monkeypatch):
    """The stand-in in place of the launch API."""
    for name, content in STAND_IN.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)


def described(path):
    """What a launch file describes."""
    return runpy.run_path(str(SOURCES / path))["generate_launch_description"]().entities


@pytest.fixture
def entities(stand_in):
    """What the launch file of the suite describes."""
    return described("grasp_strategies/launch/softhand.launch.py")


def nodes(entities):
    return {e.executable: e for e in entities if e.kind == "node"}


def test_with_a_stand_in_for_launch_the_file_declares_the_arguments_of_the_documentation(entities):
    arguments = {e.name: e for e in entities if e.kind == "argument"}
    assert set(arguments) == ARGUMENTS
    assert arguments["backend"].default == "topic"
    assert all(isinstance(a.default, str) and a.text for a in arguments.values())


def test_with_a_stand_in_for_launch_the_three_nodes_are_started(entities):
    assert {(n.package, n.executable) for n in nodes(entities).values()} == {
        ("pneuflex_sim", "hand_sim"),
        ("pneumaticbox_driver", "driver"),
        ("grasp_strategies", "sequencer"),
    }


def test_with_a_stand_in_for_launch_the_simulator_starts_only_with_the_topic_backend(entities):
    assert nodes(entities)["hand_sim"].condition == ("equals", "backend", "topic")


def test_with_a_stand_in_for_launch_every_argument_reaches_a_node_with_its_type(entities):
    given = {}
    for node in nodes(entities).values():
        for value in node.parameters[0].values():
            given[value.name] = value.type
    assert given == dict.fromkeys(ARGUMENTS, str) | {"gui": bool, "use_sim_time": bool}


def test_with_a_stand_in_for_launch_the_viewer_gets_the_urdf_of_its_hand_and_joint_states(stand_in):
    found = described("softhand_bringup/launch/view.launch.py")
    assert {e.name for e in found if e.kind == "argument"} == {"hand", "segments"}
    publisher = nodes(found)["robot_state_publisher"]
    urdf = publisher.parameters[0]["robot_description"]
    assert urdf.name == "ros2 run pneuflex_sim hand urdf $hand --segments $segments"
    assert publisher.remappings == [("joint_states", "hand/joint_states")]


def test_with_a_stand_in_for_launch_rviz_opens_the_shipped_displays_of_published_topics(stand_in):
    viewer = nodes(described("softhand_bringup/launch/view.launch.py"))["rviz2"]
    option, path = viewer.arguments
    assert (option, path) == ("-d", "<softhand_bringup>/config/softhand.rviz")
    shown = yaml.safe_load((SOURCES / "softhand_bringup/config/softhand.rviz").read_text())
    manager = shown["Visualization Manager"]
    topics = {
        value["Value"]
        for display in manager["Displays"]
        for value in display.values()
        if isinstance(value, dict) and "Value" in value
    }
    assert topics == {"hand/markers", "hand/contacts", "robot_description"}
    assert manager["Global Options"]["Fixed Frame"] == "world"
