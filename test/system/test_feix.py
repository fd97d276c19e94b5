"""A stored grasp of the Feix taxonomy over ROS: one call replays it with its object, and it is
recorded; what cannot be replayed is refused with the reason.
"""

import signal

import pytest
from made_up_grasps import write_made_up_strategies
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from softhand_bringup.bags.reading import Bag
from softhand_bringup.processes import suite

TYPE, OTHER_OBJECT = 3, 2


@pytest.fixture
def options():
    return suite.SuiteOptions(
        object="cylinder_45",
        scene="held",
        step=0.005,
        segments=4,
        finger_contact=True,
    )


@pytest.fixture
def recorder(launcher, tmp_path):
    return launcher.start(suite.recorder(tmp_path / "bag"))


def choose(peer, strategy):
    chosen = Parameter("strategy.feix", value=str(strategy)).to_parameter_msg()
    answer = peer.call(SetParameters, "grasp_sequencer/set_parameters", parameters=[chosen])
    assert answer.results[0].successful, answer.results[0].reason


@pytest.mark.timeout(240)
def test_a_call_replays_the_stored_grasp_of_a_type_with_its_object(recorder, nodes, peer, tmp_path):
    peer.wait_for_driver()
    peer.phases()  # heard from now on
    choose(peer, "feix/34")
    answer = peer.trigger("grasp/feix")
    assert not answer.success
    assert "feix/01 to feix/33 or the path of a .yaml file, got 'feix/34'" in answer.message
    stored = write_made_up_strategies(tmp_path)
    choose(peer, stored[OTHER_OBJECT])
    answer = peer.trigger("grasp/feix")
    assert not answer.success
    assert (
        "expected a simulator with the object cylinder_25, got one with cylinder_45"
        in answer.message
    )
    choose(peer, stored[TYPE])
    grasp = peer.request(Trigger, "grasp/feix")
    peer.wait(grasp.done, "the end of the grasp", 150.0)
    assert grasp.result().success, grasp.result().message
    assert "by the hand alone" in grasp.result().message
    assert {"hold_out", "grasp", "release", "roll", "hold"} <= set(peer.phases())
    recorder.send(signal.SIGINT)
    assert recorder.wait(10.0) == 0
    with Bag(tmp_path / "bag") as bag:
        held = [message for _, message in bag.messages("/scene/hold_object")]
    assert [len(message.points[0].transforms) for message in held] == [1, 1, 0, 1]
