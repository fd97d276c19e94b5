"""Every node ends with code 0 on SIGINT and SIGTERM, while all of them are busy."""

import signal

import pytest

from softhand_bringup.processes import suite

NODES = ("hand_sim", "driver", "sequencer", "recorder")
SIGNALS = {
    "SIGINT": [signal.SIGINT],
    "SIGTERM": [signal.SIGTERM],
    "twice SIGINT": [signal.SIGINT, signal.SIGINT],
}
ABORT_MESSAGES = ("terminate called", "Traceback", "core dumped", "Segmentation", "rcl_shutdown")


@pytest.mark.parametrize("signals", SIGNALS.values(), ids=SIGNALS)
def test_each_node_ends_in_order(nodes, launcher, peer, tmp_path, signals):
    nodes["recorder"] = launcher.start(suite.recorder(tmp_path / "bag"))
    peer.wait_for_driver()
    peer.wait(lambda: (tmp_path / "bag" / "bag_0.mcap").exists(), 10.0, "the bag")
    for name in NODES:
        for number in signals:
            nodes[name].send(number)
        assert nodes[name].wait(10.0) == 0, f"{name}: {nodes[name].output()}"
        for text in ABORT_MESSAGES:
            assert text not in nodes[name].output(), name


def test_a_simulator_alone_on_its_domain_ends_too(launcher, peer, options):
    process = launcher.start(suite.simulator(options))
    peer.wait(lambda: any(peer.node.get_node_names()), 20.0, "the node")
    peer.wait(lambda: len(peer.node.get_node_names()) > 1, 60.0, "the node")
    process.send(signal.SIGTERM)
    assert process.wait(10.0) == 0, process.output()
