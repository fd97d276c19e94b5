"""The layouts for Foxglove and PlotJuggler: what they show is published, by the viewers' names.

Neither viewer is run. Foxglove names a number `topic.field[index]`, and PlotJuggler
`topic/field`, or `topic/channel/field` where the message names channels.
"""

import json
import re
import xml.etree.ElementTree as ET
from importlib import import_module
from pathlib import Path

import pytest

from grasp_strategies.ros.interface import OFFERS as OF_THE_SEQUENCER
from pneuflex_sim.ros.interface import OFFERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros.interface import OFFERS as OF_THE_DRIVER
from softhand_model.hand.hand import load_hand

FOLDER = Path(__file__).parents[2] / "src" / "softhand_bringup" / "config"
PUBLISHED = {
    "/" + offer.name.strip("/"): offer.kind
    for offer in (*OF_THE_SEQUENCER, *OF_THE_SIMULATOR, *OF_THE_DRIVER)
    if offer.way.startswith("pub")
}
CHANNELS = load_hand("rbo_hand_2").channels
NAMING = "sensor_msgs/JointState"


@pytest.fixture(scope="module")
def foxglove():
    return json.loads((FOLDER / "foxglove.json").read_text())


def follow(kind, fields):
    """The type at the end of a path of fields; a KeyError where there is none."""
    for field in fields:
        package, name = kind.split("/")
        kind = getattr(import_module(f"{package}.msg"), name).get_fields_and_field_types()[field]
    return kind


def leaves(layout):
    if isinstance(layout, str):
        return [layout]
    return leaves(layout["first"]) + leaves(layout["second"])


def test_foxglove_places_each_panel_once(foxglove):
    assert sorted(leaves(foxglove["layout"])) == sorted(foxglove["configById"])


def test_what_foxglove_plots_is_in_messages_that_are_published(foxglove):
    panels = foxglove["configById"].values()
    paths = [path["value"] for panel in panels for path in panel.get("paths", ())]
    assert len(paths) > 12
    for path in paths:
        topic, *fields = path.split(".")
        names = [re.sub(r"\[\d\]", "", field) for field in fields]
        indices = [int(index) for index in re.findall(r"\[(\d)\]", path)]
        assert follow(PUBLISHED[topic], names) in {"double", "string", "sequence<double>"}, path
        assert all(index < len(CHANNELS) for index in indices)


def test_foxglove_shows_topics_that_are_published(foxglove):
    scene = foxglove["configById"]["3D!hand"]
    topics = [*scene["topics"], scene["layers"]["urdf"]["topic"]]
    topics.append(foxglove["configById"]["DiagnosticSummary!health"]["topicToRender"])
    assert set(topics) <= {*PUBLISHED, "/diagnostics"}


def test_what_plotjuggler_plots_is_in_messages_that_are_published():
    curves = [c.get("name") for c in ET.parse(FOLDER / "plotjuggler.xml").iter("curve")]
    assert len(curves) > 12
    for curve in curves:
        topic = next(topic for topic in PUBLISHED if curve.startswith(f"{topic}/"))
        names = curve[len(topic) + 1 :].split("/")
        if PUBLISHED[topic] == NAMING:
            assert names.pop(0) in CHANNELS
        assert follow(PUBLISHED[topic], names) in {"double", "sequence<double>"}, curve
