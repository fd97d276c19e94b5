"""Two hands in two namespaces, by the clock of one simulator: both grasp at once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from std_srvs.srv import Trigger

from bench.robust.rig import START_LIMIT, launched
from bench.row import at_least, at_most
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions

HANDS = ("left", "right")
GRASP_LIMIT = 300.0  # of wall time for both [s]


def run() -> list[dict[str, Any]]:
    """Rows on the grasps and on the publishers of the clock."""
    common = SuiteOptions(step=0.004)
    options = [replace(common, namespace=h, publish_clock=h == HANDS[0]) for h in HANDS]
    with launched([command for o in options for command in suite.three_nodes(o)]) as rig:
        clients = [rig.client(Trigger, f"{hand}/grasp/surface_constrained") for hand in HANDS]
        for client in clients:
            rig.need(client.service_is_ready, START_LIMIT, client.srv_name)
        calls = [client.call_async(Trigger.Request()) for client in clients]
        rig.need(lambda: all(call.done() for call in calls), GRASP_LIMIT, "two answers")
        answers = [call.result() for call in calls]
        for hand, answer in zip(HANDS, answers, strict=True):
            print(f"  {hand}: {answer.message}", flush=True)
        clocks = rig.node.count_publishers("/clock")
        return [
            at_least("hands in two namespaces that grasp", sum(a.success for a in answers), "", 2),
            at_most("publishers of their clock", clocks, "", 1),
        ]
