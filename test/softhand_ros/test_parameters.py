"""Node parameters: one table for the declaration, the help and the documentation."""

import pytest
import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.context import Context
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from grasp_strategies.ros.parameters import PARAMETERS as OF_THE_SEQUENCER
from model_lab.ros.interface import PARAMETERS as OF_THE_MONITOR
from pneuflex_sim.ros.parameters import PARAMETERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros.parameters import PARAMETERS as OF_THE_DRIVER
from softhand_ros.parameters import (
    Offer,
    Parameter,
    declare,
    follow_simulated_time,
    given_to_all,
    markdown,
    parameter_lines,
    usage,
)

TABLES = {
    "hand_sim": OF_THE_SIMULATOR,
    "driver": OF_THE_DRIVER,
    "sequencer": OF_THE_SEQUENCER,
    "monitor": OF_THE_MONITOR,
}
TABLE = (
    Parameter("length", 0.1, "of the finger; 0: the hand's", "m", (0.0, 1.0)),
    Parameter("count", 3, "of segments", bounds=(1, 5)),
    Parameter("modes", ["mass"], "a channel", choices=("mass", "time"), read_only=False),
)


@pytest.fixture
def node(domain):
    """Makes a node with parameters as on the command line."""
    context = Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    made = []

    def make(**given):
        words = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
        made.append(
            Node(
                "declaring",
                context=context,
                cli_args=["--ros-args", *words] if words else None,
                enable_rosout=False,
            )
        )
        return made[-1]

    yield make
    for one in made:
        one.destroy_node()
    rclpy.try_shutdown(context=context)


@pytest.mark.system
def test_the_values_are_the_defaults_unless_others_are_given(node):
    assert declare(node(count=4), TABLE) == {"length": 0.1, "count": 4, "modes": ["mass"]}


@pytest.mark.system
def test_a_parameter_that_is_not_there_is_refused_with_the_nearest_name(node):
    with pytest.raises(ValueError, match=r"no parameter lenght, did you mean length\?"):
        declare(node(lenght=0.2), TABLE)
    with pytest.raises(ValueError, match=r"no parameter speed \(--help"):
        declare(node(speed=0.2), TABLE)


@pytest.mark.system
def test_parameters_of_ros_itself_are_taken(node):
    given = {"use_sim_time": "true", "start_type_description_service": "false"}
    given["qos_overrides./clock.subscription.depth"] = 3
    assert declare(node(**given), TABLE)["length"] == 0.1


@pytest.mark.system
def test_whole_numbers_are_taken_for_fractions(node):
    table = (*TABLE, Parameter("shift", [0.0, 0.0], "of it", "m"))
    values = declare(node(length=1, shift=[1, 2]), table)
    assert (values["length"], list(values["shift"])) == (1.0, [1.0, 2.0])
    with pytest.raises(ParameterException):
        declare(node(length="long"), table)


FILE = """
/**:
  ros__parameters: {lenght: 0.2, strategy: {push: x}}
/left:
  declaring:
    ros__parameters: {own: 1}
declaring:
  ros__parameters: {count: 4, modse: [time]}
"""


@pytest.mark.system
def test_what_a_file_gives_to_all_nodes_ends_none_that_lacks_it(node, tmp_path, monkeypatch, capfd):
    path = tmp_path / "all.yaml"
    path.write_text(FILE)
    line = ["node", "--ros-args", "--params-file", str(path)]
    assert given_to_all(line) == {"lenght", "strategy.push"}
    monkeypatch.setattr("sys.argv", line)
    shared = node(lenght=0.2)
    assert declare(shared, TABLE)["length"] == 0.1
    assert "no parameter lenght, did you mean length? (given to all nodes" in capfd.readouterr().err
    with pytest.raises(ValueError, match=r"no parameter modse, did you mean modes\?"):
        declare(node(modse="[time]"), TABLE)


@pytest.mark.system
def test_descriptors_tell_unit_range_choices_and_what_may_change(node):
    declaring = node()
    declare(declaring, TABLE)
    length, count, modes = (declaring.describe_parameter(row.name) for row in TABLE)
    assert length.description == "of the finger [m]; 0: the hand's"
    assert (length.read_only, modes.read_only) == (True, False)
    assert length.floating_point_range[0].to_value == 1.0
    assert (count.integer_range[0].from_value, count.integer_range[0].to_value) == (1, 5)
    assert modes.additional_constraints == "mass, time"


@pytest.mark.system
def test_a_start_with_a_value_that_is_no_choice_names_it(node):
    with pytest.raises(ValueError, match="modes: expected one of mass, time, got 'force'"):
        declare(node(modes="[mass, force]"), TABLE)


@pytest.mark.system
def test_a_start_beyond_the_range_is_refused(node):
    with pytest.raises(ParameterException, match="count"):
        declare(node(count=6), TABLE)


@pytest.mark.system
def test_a_change_to_what_is_no_choice_is_refused_and_the_value_stands(node):
    declaring = node()
    declare(declaring, TABLE)
    (result,) = declaring.set_parameters([rclpy.Parameter("modes", value=["force"])])
    assert result == SetParametersResult(
        successful=False, reason="modes: expected one of mass, time, got 'force'"
    )
    assert declaring.get_parameter("modes").value == ["mass"]


@pytest.mark.system
@pytest.mark.parametrize(("given", "followed"), [({}, True), ({"use_sim_time": "false"}, False)])
def test_simulated_time_is_followed_unless_the_user_says_otherwise(node, given, followed):
    follower = node(**given)
    follow_simulated_time(follower)
    assert follower.get_parameter("use_sim_time").value is followed


@pytest.mark.parametrize("name", TABLES)
def test_the_help_names_every_parameter_and_which_may_change(name):
    table = TABLES[name]
    lines = {line[2:].split(" ")[0]: line for line in parameter_lines(table)[2:]}
    assert set(lines) == {parameter.name for parameter in table}
    for parameter in table:
        assert parameter.text in lines[parameter.name]
        assert lines[parameter.name].startswith("*") != parameter.read_only


def test_the_help_tells_of_topics_and_services_behind_the_parameters():
    offers = (
        Offer("pub", "hand/state", "sensor_msgs/JointState", "angles [rad]"),
        Offer("srv", "grasp", "std_srvs/Trigger", "closes the hand"),
    )
    *_, first, second = usage("node", "Node.", TABLE, offers).splitlines()
    assert first.split() == ["pub", "hand/state", "sensor_msgs/JointState", "angles", "[rad]"]
    assert second.split() == ["srv", "grasp", "std_srvs/Trigger", "closes", "the", "hand"]


@pytest.mark.parametrize("name", TABLES)
def test_every_default_is_one_of_the_values_that_can_be(name):
    for parameter in TABLES[name]:
        assert not parameter.refusal(parameter.default)
        if parameter.bounds:
            assert parameter.bounds[0] <= parameter.default <= parameter.bounds[1]


def test_the_documented_table_has_a_row_for_each_parameter():
    head, _, *rows = markdown(TABLE).splitlines()
    assert [row.split("|")[1].strip() for row in rows] == ["`length`", "`count`", "`modes`*"]
    assert {row.count("|") for row in [head, *rows]} == {4}
    assert '| `["mass"]` |' in rows[-1]
    assert "(mass, time)" in rows[-1]
