"""Everything that can break, on real nodes: the plant's truth judges, not the driver's word.

One launch takes the faults in turn, each repaired and reset before the next.
"""

import signal

import numpy as np
import pytest
from faulty_plant_peer import FaultyPlantPeer, plant_command, plant_path
from forked_nodes import ForkingLauncher
from ros_peer import PATIENCE, seconds
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment
from softhand_model.pneumatics import load_pneumatics

CHANNELS = ["a", "b"]
VOLUME = 30e-6
LIMIT = 80e3
MG = 1e-6
FULL = np.array([15 * MG, 12 * MG])
GREEDY = 100 * MG  # more than a channel holds at its limit
BOX = {"channels": CHANNELS, "rest_volumes": [VOLUME] * 2, "pressure_limits": [LIMIT] * 2}
RELIEF = load_pneumatics().relief
# with a spool stuck inflating only the relief valve holds: to where it is wide open
HELD = {"stick_valve a 1": RELIEF.margin * (1 + RELIEF.accumulation) * LIMIT}
FAULTS = {
    "stick_valve a 0": "channel a: pulses do not move its pressure",
    "stick_valve a 1": "channel a: pressure does not fall",
    "stick_valve a -1": "channel a: has lost its pressure",
    "burst a": "channel a: has lost its pressure",
    "stick_sensor 0": "sensor a: its reading is constant",
    "lose_sensor 1": "sensor b: not a number",
    "lose_supply": "supply lost",
    "clock 5.0": "no sensor sample for 250 ms",
    "clock -2.0": "the clock was set back",
}
OUTLETS_STUCK = ("stick_valve a 0", "stick_valve a 1")


@pytest.fixture(scope="module")
def nodes(domain, tmp_path_factory):
    """The plant and the driver as processes, by name."""
    folder = tmp_path_factory.mktemp("log")
    environment = node_environment(folder, domain) | plant_path()
    with ForkingLauncher(folder, environment) as launcher:
        plant = launcher.start(plant_command(volumes=[VOLUME] * 2, limits=[LIMIT] * 2))
        command = NodeCommand("driver", "pneumaticbox_driver.ros.node", BOX)
        yield {"plant": plant, "driver": launcher.start(command), "launcher": launcher}


@pytest.fixture(scope="module")
def bench(nodes, domain, tmp_path_factory):
    """The test's own node, once the driver answers the plant."""
    peer = FaultyPlantPeer(domain, tmp_path_factory.mktemp("peer"), CHANNELS)
    peer.connect()
    yield peer
    peer.close()


@pytest.fixture
def filled(bench):
    """The bench with air in its channels, repaired and reset afterwards."""
    fill(bench)
    yield bench
    bench.order("clear")
    bench.trigger("reset")


def fill(bench):
    bench.command(*FULL)
    bench.wait(
        lambda: np.allclose(bench.truth.position, FULL, atol=2 * MG), "channels to be filled"
    )
    bench.pass_time(0.4)  # until the valves have closed


def gauge(bench):
    return np.array(bench.truth.effort)


def wait_until_vented(bench, channels=(0, 1), limit=PATIENCE):
    bench.wait(lambda: (gauge(bench)[list(channels)] < 500.0).all(), "the air to be out", limit)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_and_vents_below_the_limit_until_reset(filled, fault):
    bench = filled
    bench.order(fault)
    if fault == "stick_valve a 0":
        bench.command(FULL[0] + 15 * MG, FULL[1])
    bench.diagnosis("safety", "vented until pneumaticbox/reset", FAULTS[fault])
    if fault in OUTLETS_STUCK:
        bench.diagnosis("safety", "channel a", "shut off the supply")
        wait_until_vented(bench, [1])
        assert gauge(bench)[0] > 20e3
    else:
        wait_until_vented(bench)
    assert max(bench.truth.velocity) < HELD.get(fault, 1.05 * LIMIT)
    # repaired, it stays vented, and takes no command
    bench.order("clear")
    wait_until_vented(bench)
    bench.pass_time(0.5)  # until its pressure is constant, and with it the air mass known
    bench.command(*FULL)
    bench.diagnosis("commands", "vented until reset")
    assert (gauge(bench) < 500.0).all()
    assert bench.trigger("reset").success
    # what the box thinks is left in a channel that broke is forgotten at ambient pressure
    fill(bench)


def test_ten_thousand_commands_at_once_are_warned_of_and_the_last_one_wins(filled):
    bench = filled
    drawn = np.random.default_rng(1).uniform(0, GREEDY, (10_000, 2))
    bench.order("clear")  # the highest pressure is noted from here
    for masses in drawn.tolist():
        bench.command(*masses)
    bench.command(*(0.5 * FULL))
    bench.diagnosis("commands", "command storm")
    bench.wait(
        lambda: np.allclose(bench.truth.position, 0.5 * FULL, atol=3 * MG), "the last command"
    )
    assert max(bench.truth.velocity) < 1.2 * LIMIT


def test_two_commanders_are_warned_of_and_the_limit_holds(filled, nodes):
    bench = filled
    other = bench.node.create_publisher(JointTrajectory, "pneumaticbox/command", 10)
    greedy = JointTrajectory(
        joint_names=CHANNELS, points=[JointTrajectoryPoint(positions=[GREEDY, GREEDY])]
    )
    bench.order("clear")
    for _ in range(30):
        other.publish(greedy)
        bench.spin(0.03)
        bench.command(*FULL)
        bench.spin(0.03)
    bench.diagnosis("commands", "two nodes command the box")
    bench.node.destroy_publisher(other)
    fill(bench)
    assert max(bench.truth.velocity) < 1.2 * LIMIT


def test_killed_with_an_inlet_open_it_leaves_a_plant_that_vents_and_starts_anew(filled, nodes):
    bench = filled
    bench.command(0.0, 0.0)
    wait_until_vented(bench)
    bench.order("clear")  # the highest pressure is noted from here
    bench.command(GREEDY, 0.0)  # the inlet stays open
    bench.wait(lambda: gauge(bench)[0] > 10e3, "the channel to fill")
    nodes["driver"].send(signal.SIGKILL)
    assert nodes["driver"].wait(5.0) == -signal.SIGKILL
    # the plant waits for the answer to each sample until it gives the driver up: 6 s of wall time
    wait_until_vented(bench)
    vented_from = max(bench.truths, key=lambda truth: truth.effort[0])
    assert bench.time() - seconds(vented_from.header.stamp) < 3.0
    # a quarter of a second of inflow more than when it was killed
    assert max(bench.truth.velocity) < 1.2 * LIMIT
    nodes["launcher"].start(NodeCommand("driver", "pneumaticbox_driver.ros.node", BOX))
    bench.diagnosis("safety", "in operation")
    bench.pass_time(1.0)
    fill(bench)
