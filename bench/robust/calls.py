"""Service calls beside each other and in wrong order: each answered, the state right afterwards."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass
from typing import Any

from rclpy.task import Future

from bench.robust.rig import GRASP, Rig, started
from bench.row import at_least, at_most

COUNT = 2_000
BESIDE = 8  # calls that are under way at once
QUICK = 5.0  # for an answer of what does not wait for a motion [s]
SLOW = 60.0  # for one that does [s]
TRIGGERS = (
    "pneumaticbox/vent",
    "pneumaticbox/tare",
    "pneumaticbox/calibrate",
    "pneumaticbox/calibrate_next",
    "pneumaticbox/reset",
    "sim/reset",
    "sim/step",
    "grasp/push",
    "grasp/edge",
    "grasp/slide_to_wall",
    "grasp/abort",
    GRASP,
)
SWITCHES = ("pneumaticbox/enable", "sim/pause")
WAITING = (GRASP, "grasp/abort")  # an abort waits for the strategy's end


@dataclass
class Call:
    """A call under way: what was called, since when [s], and its answer to come."""

    service: str
    begun: float
    answer: Future

    @property
    def limit(self) -> float:
        """Within which an answer is due [s]."""
        return SLOW if self.service in WAITING else QUICK


def run(seed: int = 0, count: int = COUNT) -> list[dict[str, Any]]:
    """Rows on the answers, on the state afterwards, and on calls in the midst of a grasp."""
    with started() as rig:
        rows = in_mid_grasp(rig)
        latest, unanswered = call_all(rig, random.Random(seed), count)
        rig.begin_anew()
        answer = rig.grasp()
        print(f"  the grasp afterwards: {answer.message}", flush=True)
        return [
            *rows,
            at_least("calls at random, eight at a time", count, "", count),
            at_most("calls without an answer in time", unanswered, "", 0),
            at_most("slowest answer of what waits for no motion", latest, "s", QUICK),
            at_most("nodes that ended", len(rig.nodes) - len(rig.alive()), "", 0),
            at_least("grasp afterwards succeeds", answer.success, "", 1),
        ]


def in_mid_grasp(rig: Rig) -> list[dict[str, Any]]:
    """A grasp within a grasp is refused, a tare with open valves too; the grasp succeeds."""
    future = rig.begin_grasp()
    second, tare = rig.call(GRASP), rig.call("pneumaticbox/tare")
    calibrate = rig.call("pneumaticbox/calibrate")
    print(f"  second grasp: {second.message}; tare: {tare.message}", flush=True)
    rig.need(future.done, SLOW, "an answer of the grasp")
    refused = not second.success and "is running" in second.message and not calibrate.success
    return [
        at_least("grasp and calibration within a grasp refused", refused, "", 1),
        at_least("tare in mid-grasp answered", bool(tare.message), "", 1),
        at_least("grasp that they disturbed succeeds", future.result().success, "", 1),
    ]


def call_all(rig: Rig, rng: random.Random, count: int) -> tuple[float, int]:
    """Slowest quick answer [s] and number of calls that were not answered in time."""
    under_way: list[Call] = []
    slowest, unanswered = 0.0, 0
    for number in range(count):
        under_way.append(call(rig, rng))
        rest = BESIDE if number < count - 1 else 0
        if not rest:  # a grasp that runs, or waits for a paused simulation, is ended
            under_way += [ask(rig, "sim/pause", False), ask(rig, "grasp/abort")]
        while len(under_way) > rest:
            rig.spin(0.002)
            now = time.monotonic()
            done = [c for c in under_way if c.answer.done()]
            slowest = max([slowest, *(now - c.begun for c in done if c.limit == QUICK)])
            late = [c for c in under_way if c not in done and now - c.begun > c.limit]
            for lost in late:
                print(f"  no answer of {lost.service} within {lost.limit:g} s", flush=True)
            unanswered += len(late)
            under_way = [c for c in under_way if c not in done and c not in late]
            if len(under_way) > rest and all(c.service == GRASP for c in under_way):
                under_way.append(ask(rig, "grasp/abort"))
    return slowest, unanswered


def call(rig: Rig, rng: random.Random) -> Call:
    """Call something at random."""
    service = rng.choice((*TRIGGERS, *SWITCHES))
    return ask(rig, service, rng.random() < 0.5 if service in SWITCHES else None)


def ask(rig: Rig, service: str, data: bool | None = None) -> Call:
    """Begin a call."""
    return Call(service, time.monotonic(), rig.request(service, data))
