"""What the simulator computes for its topics: what somebody hears, at the topic's rate."""

import pytest
import rclpy
from geometry_msgs.msg import PoseArray
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain
from ros_peer import Peer

from pneuflex_sim.ros.node import HandSim
from pneuflex_sim.simulation import Simulation

pytestmark = pytest.mark.system
STEPS = 100  # of 2 ms


@pytest.fixture
def peer(tmp_path):
    with held_domain() as domain:
        peer = Peer(domain, tmp_path)
        arguments = ["--ros-args", "-p", "lockstep:=false"]
        rclpy.init(args=arguments, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
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
    peer.wait(lambda: node.count_subscribers("hand/fingertips"), 10.0, "discovery")
    peer.spin(0.5)
    for _ in range(STEPS):
        node.advance()
        peer.spin(0.0)
    assert len(computed) == 10
    assert computed == pytest.approx([0.22 + 0.02 * k for k in range(10)])
    peer.wait(lambda: len(heard) == 10, 5.0, "all of them")
    assert all(len(message.poses) == 5 for message in heard)
    node.close()
