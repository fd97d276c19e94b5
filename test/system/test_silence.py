"""What happens when a node falls silent, comes late, or is there twice."""

import signal

from suite_peer import AMBIENT

from softhand_bringup.processes import suite


def test_when_the_driver_is_killed_with_valves_open_the_plant_vents(nodes, peer):
    peer.wait_for_driver()
    peer.wait(lambda: peer.valves() and peer.sensors(), 10.0, "valves and sensors")
    peer.command([8e-5, 0.0, 0.0, 0.0])  # about as much as the channel may hold
    peer.wait(
        lambda: peer.valves()[0] == 1.0 and peer.sensors()[0] > AMBIENT + 20e3,
        30.0,
        "channel a under pressure with its valve open",
    )
    nodes["driver"].send(signal.SIGKILL)
    assert nodes["driver"].wait(5.0) == -signal.SIGKILL
    peer.pass_time(3.0)
    # a stuck valve would go on to fill; sensors have an offset of a few percent of their range
    assert peer.sensors()[0] < AMBIENT + 8e3
    assert nodes["hand_sim"].exit_code is None
    peer.diagnosis("hand_sim", "outlets are open")


def test_a_driver_that_is_held_up_is_told_by_the_simulator(nodes, peer):
    peer.wait_for_driver()
    peer.diagnosis("pneumaticbox: safety", "in operation")
    nodes["driver"].send(signal.SIGSTOP)  # until it is told, however busy the machine is
    told = peer.diagnosis("the driver answers late")
    nodes["driver"].send(signal.SIGCONT)
    assert "samples waited for it in vain" in told
    assert peer.diagnosis("pneumaticbox: safety", "in operation")


def test_a_simulator_that_is_started_last_is_found_by_all(launcher, peer, options):
    launcher.start(suite.sequencer(options))
    launcher.start(suite.driver(options))
    peer.spin(2.0)
    assert peer.state() is None
    launcher.start(suite.simulator(options))
    peer.wait_for_driver()
    peer.grasp()
    peer.wait(lambda: len(set(peer.phases()) - {"idle"}) >= 1, 30.0, "the first phase of the grasp")
    launcher.check()


def test_a_second_simulator_on_the_domain_is_warned_of(launcher, peer, options):
    launcher.start(suite.simulator(options))
    peer.wait(peer.time, 60.0, "a tick of /clock")
    command = suite.simulator(options)
    twin = launcher.start(type(command)("second_simulator", command.module, command.parameters))
    peer.diagnosis("second simulator", limit=30.0)
    peer.wait(lambda: "second simulator" in twin.output(), 10.0, "a warning in the second's log")
