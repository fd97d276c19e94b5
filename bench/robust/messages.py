"""Hostile messages on every input topic of every node, and a grasp afterwards."""

from __future__ import annotations

import array
import importlib
import random
import re
import time
from collections.abc import Iterator
from typing import Any

from bench.robust.rig import START_LIMIT, Rig, growth, started
from bench.row import at_least, at_most, stated
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions

COUNT = 112_000
SHORT_COUNT = 2_000  # a topic and round, before others have their turn
LONG_NAME = 10_000_000  # characters
OWN = {"/parameter_events", "/rosout"}  # of ROS itself
NODES = ("hand_sim", "pneumaticbox", "grasp_sequencer", "monitor")
NUMBERS = (float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e-308, 0.0, -0.0, 1.0, -1.0)
TEXTS = ("", "a", "b", "supply", "world", "object", "index/object", "\0", "x" * 300, "ä" * 50)
LENGTHS = (0, 1, 3, 4, 5, 100)
PAUSE_EVERY, PAUSE = 20, 0.001  # messages, wall time [s]: so that most are heard, not overwritten


def run(seed: int = 0, count: int = COUNT) -> list[dict[str, Any]]:
    """Rows on the nodes that ended, the longest line, memory and the grasp afterwards."""
    options = SuiteOptions()
    with started(options, [suite.monitor(options)]) as rig:
        rig.grasp()  # what is loaded late is there then
        rig.begin_anew()
        before = rig.usage()
        sent, topics = attack(rig, random.Random(seed), count)
        rig.spin(2.0)
        alive = rig.alive()
        ended = len(rig.nodes) - len(alive)
        rows = [
            at_least(f"hostile messages on {topics} topics", sent, "", count),
            at_most("nodes that they ended", ended, "", 0),
            at_most("longest line in a log", rig.longest_line(), "characters", 500),
        ]
        if ended:
            rig.tell_ended()
            return rows
        rig.begin_anew()
        answer = rig.grasp()
        print(f"  the grasp afterwards: {answer.message}", flush=True)
        after = rig.usage()
        memory = [
            stated(f"{name}: {before[name].memory:.1f} MB, afterwards", after[name].memory, "MB")
            for name in before
        ]
        return [
            *rows,
            at_least("grasp afterwards succeeds", answer.success, "", 1),
            at_most("memory of a node afterwards", growth(before, after, "memory"), "% more", 5),
            *memory,
        ]


def attack(rig: Rig, rng: random.Random, count: int) -> tuple[int, int]:
    """Send so many messages in all, round by round; how many were sent, and on how many topics."""
    topics = input_topics(rig)
    publishers = {topic: rig.node.create_publisher(kind, topic, 10) for topic, kind in topics}
    rig.spin(1.0)
    for topic, kind in topics:
        if text := long_named(kind):
            publishers[topic].publish(text)
            rig.spin(0.2)
    share = min(SHORT_COUNT, -(-count // len(topics)))
    sent = 0
    while sent < count:
        for topic, kind in topics:
            send(publishers[topic].publish, messages(kind, rng, share))
            sent += share
            rig.drain()
    for publisher in publishers.values():
        rig.node.destroy_publisher(publisher)
    return sent, len(topics)


def send(publish: Any, stream: Iterator[Any]) -> None:
    """Send messages about as fast as a node takes them."""
    for number, message in enumerate(stream):
        publish(message)
        if number % PAUSE_EVERY == 0:
            time.sleep(PAUSE)


def input_topics(rig: Rig) -> list[tuple[str, type]]:
    """Every topic that one of the nodes hears, with its type, as the graph tells.

    Raises:
        RigError: a node is not found.
    """
    found: dict[str, type] = {}
    rig.need(lambda: set(NODES) <= set(rig.node.get_node_names()), START_LIMIT, "all nodes")
    for node in NODES:
        heard = rig.node.get_subscriber_names_and_types_by_node(node, "/")
        found |= {topic: message_type(kinds[0]) for topic, kinds in heard if topic not in OWN}
    return sorted(found.items())


def message_type(name: str) -> type:
    """Class of a message such as `sensor_msgs/msg/JointState`."""
    package, _, kind = name.split("/")
    found: type = getattr(importlib.import_module(f"{package}.msg"), kind)
    return found


def messages(kind: Any, rng: random.Random, count: int) -> Iterator[Any]:
    """Messages with fields of every kind of wrong value."""
    for _ in range(count):
        yield hostile(kind, rng)


def hostile(kind: Any, rng: random.Random, depth: int = 0) -> Any:
    """A message with a value drawn for each of its fields."""
    message = kind()
    for name, type_name in kind.get_fields_and_field_types().items():
        if rng.random() < 0.9:
            setattr(message, name, _value(type_name, getattr(message, name), rng, depth))
    return message


def _value(type_name: str, default: Any, rng: random.Random, depth: int) -> Any:
    if listed := re.fullmatch(r"sequence<(.*?)(, \d+)?>", type_name):
        length = rng.choice(LENGTHS if depth == 0 else LENGTHS[:3])
        entries = [_value(listed[1], None, rng, depth + 1) for _ in range(length)]
        return (
            array.array(default.typecode, entries) if isinstance(default, array.array) else entries
        )
    if type_name.startswith("string"):
        return rng.choice(TEXTS)
    if type_name in ("double", "float"):
        large = 1e38 if type_name == "float" else 1e308
        number = rng.choice((*NUMBERS, rng.uniform(-1, 1), rng.uniform(0, 5e5)))
        return min(max(number, -large), large) if abs(number) < float("inf") else number
    if type_name == "boolean":
        return rng.random() < 0.5
    if type_name == "octet":
        return bytes([rng.randrange(256)])
    if whole := re.fullmatch(r"(u?)int(\d+)", type_name):
        return _integer(bool(whole[1]), int(whole[2]), rng)
    if "/" in type_name and "[" not in type_name:
        package, kind = type_name.split("/")
        return hostile(message_type(f"{package}/msg/{kind}"), rng, depth + 1)
    return default  # arrays of a fixed length keep their zeros


def _integer(unsigned: bool, bits: int, rng: random.Random) -> int:
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return rng.choice((low, high, 0, 1, rng.randint(low, high)))


def long_named(kind: Any) -> Any:
    """A message with a name of ten million characters; None where a message has no names."""
    message, types = kind(), kind.get_fields_and_field_types()
    lists = [name for name, type_name in types.items() if type_name == "sequence<string>"]
    if lists:
        setattr(message, lists[0], ["x" * LONG_NAME])
    elif "header" in types:
        message.header.frame_id = "x" * LONG_NAME
    return message if lists or "header" in types else None
