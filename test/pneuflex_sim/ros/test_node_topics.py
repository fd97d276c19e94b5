"""What the simulator computes for its topics: what somebody hears, at the topic's rate."""

import pytest
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseArray
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain
from ros_peer import Peer, seconds
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from pneuflex_sim.ros.node import HandSim
from pneuflex_sim.simulation import Simulation

pytestmark = pytest.mark.system
STEPS = 100  # of 2 ms


@pytest.fixture
def arguments():
    """Parameters of the simulator on its command line."""
    return ["-p", "lockstep:=false"]


@pytest.fixture
def peer(tmp_path, arguments):
    with held_domain() as domain:
        peer = Peer(domain, tmp_path)
        words = ["--ros-args", *arguments]
        rclpy.init(args=words, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
        yield peer
        peer.close()
        rclpy.try_shutdown()


def test_poses_of_the_tips_are_computed_when_somebody_hears_them(peer, monkeypatch):
    computed = []

    def fingertips(simulation):
        computed.append(simulation.time)
        return compute(simulation)

    compute = Simulation.fingertips
    monkeypatch.setattr(Simulation, "fingertips", fingertips)
    node = HandSim()
    for _ in range(STEPS):
        node.advance()
    assert not computed
    heard = peer.listen(PoseArray, "hand/fingertips")
    peer.wait(lambda: node.count_subscribers("hand/fingertips"), "discovery")
    peer.spin(0.5)
    for _ in range(STEPS):
        node.advance()
        peer.spin(0.0)
    assert len(computed) == 10
    assert computed == pytest.approx([0.22 + 0.02 * k for k in range(10)])
    peer.wait(lambda: len(heard) == 10, "all of them")
    assert all(len(message.poses) == 5 for message in heard)
    del computed[:]
    node.set_parameters([rclpy.Parameter("joint_rate", value=0.0)])
    for _ in range(STEPS):
        node.advance()
    assert len(computed) == STEPS
    node.close()


@pytest.mark.parametrize("arguments", [[]])
def test_while_it_waits_for_a_commander_its_clock_repeats_the_last_tick(peer):
    node = HandSim()
    heard = peer.listen(Clock, "/clock")
    until = Header(frame_id="late", stamp=Time(nanosec=15_000_000))
    peer.publish(Header, "sim/commanded_until", until)
    peer.spin(0.2)
    for _ in range(20):
        if node.stands:
            break
        node.advance()
    assert node.stands
    assert node.simulation.time == pytest.approx(0.016)  # the first sample that is commanded later
    for _ in range(3):
        node.stand()
    peer.wait(lambda: len(heard) >= 3, "ticks while it stands")
    assert {round(seconds(tick.clock), 9) for tick in heard} == {0.01}
    node.close()
