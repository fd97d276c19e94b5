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
from made_up_grasps import write_made_up_strategies

from grasp_strategies.ros.parameters import PARAMETERS as OF_THE_SEQUENCER
from pneuflex_sim.ros.parameters import PARAMETERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros.parameters import PARAMETERS as OF_THE_DRIVER
from softhand_bringup.ros.hand_with_box.interface import PARAMETERS as OF_BOTH

TABLES = {
    "hand_with_box": OF_BOTH,
    "hand_sim": OF_THE_SIMULATOR,
    "driver": OF_THE_DRIVER,
    "sequencer": OF_THE_SEQUENCER,
}
SOURCES = Path(__file__).parents[2] / "src"
ARGUMENTS = {
    "namespace", "params_file", "record", "hand", "scene", "object", "strategy", "model", "step",
    "real_time_factor", "publish_clock", "gui", "use_sim_time", "backend", "hardware_file",
    "allow_effect_files", "command_timeout", "segments", "finger_contact", "driver",
    "engine",
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


def _configuration(name):
    return SimpleNamespace(
        kind="configuration", name=name, perform=lambda context: context.get(name, "")
    )


STAND_IN = {
    "launch": {"LaunchDescription": lambda entities: SimpleNamespace(entities=list(entities))},
    "launch.actions": {
        "DeclareLaunchArgument": _argument,
        "OpaqueFunction": lambda function: SimpleNamespace(kind="function", call=function),
    },
    "launch.substitutions": {
        "LaunchConfiguration": _configuration,
        "Command": lambda parts: SimpleNamespace(name="".join(map(_text, parts))),
        "PathJoinSubstitution": lambda parts: "/".join(map(_text, parts)),
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


def nodes(entities, **given):
    """Nodes by executable, with these arguments on the command line."""
    context = {e.name: e.default for e in entities if e.kind == "argument"} | given
    made = [e for e in entities if e.kind == "node"]
    for entity in entities:
        if entity.kind == "function":
            made += entity.call(context)
    return {node.executable: node for node in made}


def test_with_a_stand_in_for_launch_the_file_declares_the_arguments_of_the_documentation(entities):
    arguments = {e.name: e for e in entities if e.kind == "argument"}
    assert set(arguments) == ARGUMENTS
    assert arguments["backend"].default == "topic"
    assert all(isinstance(a.default, str) and a.text for a in arguments.values())
    page = (SOURCES.parent / "docs/start/ros-machine.md").read_text()
    assert all(f"| `{name}` |" in page for name in arguments)


def test_with_a_stand_in_for_launch_simulator_and_driver_start_in_one_process(entities):
    found = nodes(entities)
    assert {(n.package, n.executable, n.name) for n in found.values()} == {
        ("softhand_bringup", "hand_with_box", None),  # a name would be that of both nodes
        ("grasp_strategies", "sequencer", "grasp_sequencer"),
    }


def test_with_a_stand_in_for_launch_they_start_in_three_processes_when_asked(entities):
    found = nodes(entities, driver="topic")
    assert {(n.package, n.executable, n.name) for n in found.values()} == {
        ("pneuflex_sim", "hand_sim", "hand_sim"),
        ("pneumaticbox_driver", "driver", "pneumaticbox"),
        ("grasp_strategies", "sequencer", "grasp_sequencer"),
    }
    assert {node.namespace for node in found.values()} == {""}


def test_with_a_stand_in_for_launch_the_simulator_starts_only_with_the_topic_backend(entities):
    assert set(nodes(entities, backend="embedded")) == {"driver", "sequencer"}


def test_with_a_stand_in_for_launch_what_is_not_given_is_left_to_the_nodes(entities):
    for where, others in (("composed", ["hand_with_box"]), ("topic", ["driver", "hand_sim"])):
        given = {n: node.parameters for n, node in nodes(entities, driver=where).items()}
        (of_the_driver,) = given.pop(others[0])
        assert set(of_the_driver) == {"backend"}
        assert given == {name: [] for name in (*others[1:], "sequencer")}


@pytest.mark.parametrize("where", ["composed", "topic"])
def test_with_a_stand_in_for_launch_every_argument_reaches_a_node_with_its_type(entities, where):
    given = dict.fromkeys(ARGUMENTS - {"backend"}, "given")
    found = nodes(entities, **{**given, "strategy": "feix/03", "driver": where})
    del found["recorder"]
    taken = {}
    for name, node in found.items():
        *_, file, values = node.parameters  # the later wins
        assert (file, node.namespace) == ("given", "given")
        for parameter, value in values.items():
            declared = {row.name: row.default for row in TABLES[name]}
            assert parameter == "use_sim_time" or type(declared[parameter]) is value.type
            taken[value.name] = value.type
    rest = {"namespace", "params_file", "record", "driver"}
    typed = {"allow_effect_files": bool, "gui": bool, "use_sim_time": bool, "publish_clock": bool}
    typed |= {"finger_contact": bool, "segments": int}
    typed |= {"step": float, "real_time_factor": float, "command_timeout": float}
    assert taken == dict.fromkeys(ARGUMENTS - rest, str) | typed


def test_with_a_stand_in_for_launch_a_stored_grasp_brings_what_it_needs(entities, tmp_path):
    stored = str(write_made_up_strategies(tmp_path)[2])
    simulator = nodes(entities, strategy=stored, driver="topic")["hand_sim"]
    (settings,) = simulator.parameters
    assert settings == {
        "hand": "rbo_hand_2",
        "object": "cylinder_25",
        "scene": "held",
        "step": 0.005,
        "segments": 8,
        "finger_contact": True,
    }
    both = nodes(entities, strategy=stored)["hand_with_box"]
    assert both.parameters[0] == settings
    plain = nodes(entities, strategy="rbo_hand_2_ball", driver="topic")
    assert plain["hand_sim"].parameters == [{}]


def test_with_a_stand_in_for_launch_a_recorder_writes_to_the_folder_that_is_given(entities):
    recorder = nodes(entities, record="out/bag", namespace="left")["recorder"]
    assert (recorder.package, recorder.arguments) == ("softhand_bringup", ["out/bag"])
    assert recorder.namespace == "left"


def test_with_a_stand_in_for_launch_the_viewer_gets_the_urdf_of_its_hand_and_joint_states(stand_in):
    found = described("softhand_bringup/launch/view.launch.py")
    assert {e.name for e in found if e.kind == "argument"} == {"hand", "segments", "namespace"}
    publisher = nodes(found)["robot_state_publisher"]
    (values,) = publisher.parameters
    urdf = values["robot_description"]
    assert urdf.name == "ros2 run pneuflex_sim hand urdf $hand --segments $segments"
    assert publisher.remappings == [("joint_states", "hand/joint_states")]


def test_with_a_stand_in_for_launch_the_links_of_a_namespace_hang_on_its_wrist(stand_in):
    found = described("softhand_bringup/launch/view.launch.py")
    publisher = nodes(found, namespace="left")["robot_state_publisher"]
    assert publisher.namespace == "left"
    assert publisher.parameters[1] == {"frame_prefix": "left/"}


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
