"""Messages with every kind of wrong value on every input topic of the four nodes."""

import random

from bench.robust.messages import attack
from bench.robust.rig import launched
from softhand_bringup.processes import suite

COUNT = 2_000


def test_hostile_messages_end_no_node_and_fill_no_log():
    options = suite.SuiteOptions()
    with launched([*suite.three_nodes(options), suite.monitor(options)]) as rig:
        rig.await_suite()
        sent, topics = attack(rig, random.Random(1), COUNT)
        rig.spin(2.0)
        assert rig.alive() == list(rig.nodes)
        assert sent >= COUNT and topics >= 13
        assert rig.longest_line() <= 500
        rig.begin_anew()
