"""Messages for RViz and Foxglove: what is in them, frames and names, and when there are any."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from grasp_strategies.ros.messages import read_touching
from pneuflex_sim.pictures.surfaces import METRES_PER_NEWTON, SceneSurfaces, contact_line
from pneuflex_sim.ros.markers import ContactMarkers, SceneMarkers, SerialisedMessage, SurfaceMarkers
from pneuflex_sim.scene.contacts import Contact, by_pair

STAMP = Time(sec=3, nanosec=20_000_000)


class Publisher:
    """Keeps what is published."""

    def __init__(self, subscribers):
        self.subscribers, self.sent = subscribers, []

    def get_subscription_count(self):
        return self.subscribers

    def publish(self, message):
        if isinstance(message, bytes):
            message = deserialize_message(message, MarkerArray)
        self.sent.append(message)


class Node:
    """Makes publishers with so many subscribers."""

    def __init__(self, subscribers=1):
        self.subscribers, self.publishers = subscribers, {}

    def create_publisher(self, _, topic, __):
        self.publishers[topic] = Publisher(self.subscribers)
        return self.publishers[topic]


@pytest.fixture
def gripping(simulate, mass_for_pressure):
    """A hand that closes around a cylinder."""
    simulation = simulate(step=0.005)
    simulation.command_wrist(np.array([-0.04, 0.0, 0.11]), np.array([0.0, 0.83, 0.0, 0.56]))
    masses = mass_for_pressure(simulation, [30e3, 15e3, 30e3, 20e3])
    for k in range(260):
        simulation.set_air_masses(masses * np.clip((k - 160) / 80, 0, 1))
        simulation.step()
    assert len(by_pair(simulation.contacts())) > 2
    return simulation


def array(points):
    return np.array([[p.x, p.y, p.z] for p in points])


def test_contacts_come_as_lines_after_all_earlier_ones_are_deleted(gripping):
    node = Node()
    SceneMarkers(node, gripping, None).publish_contacts(STAMP)
    (message,) = node.publishers["hand/contacts"].sent
    assert message.markers[0].action == Marker.DELETEALL
    pairs = by_pair(gripping.contacts())
    shown = message.markers[1:]
    assert [(m.ns, m.id, m.type) for m in shown] == [(pair, 0, Marker.LINE_LIST) for pair in pairs]
    for marker in shown:
        contacts = pairs[marker.ns]
        points = array(marker.points)
        np.testing.assert_allclose(points[::2], [contact.position for contact in contacts])
        drawn = (points[1::2] - points[::2]) / METRES_PER_NEWTON
        for force, contact in zip(drawn, contacts, strict=True):
            assert force @ contact.normal == pytest.approx(contact.force, abs=1e-6)
            rubbing = force - contact.force * np.array(contact.normal)
            np.testing.assert_allclose(rubbing, contact.friction, atol=1e-6)
        pressing = sum(contact.force for contact in contacts)
        assert float(marker.text) == pytest.approx(pressing, abs=1e-4)
    assert any(contact.friction != (0.0, 0.0, 0.0) for contact in gripping.contacts())


def test_the_sequencer_reads_from_the_markers_what_touches_the_object(gripping):
    node = Node()
    SceneMarkers(node, gripping, None).publish_contacts(STAMP)
    (message,) = node.publishers["hand/contacts"].sent
    touching = {contact.first for contact in gripping.object_contacts()}
    assert read_touching(message) == touching
    assert touching


def test_surfaces_have_a_name_of_their_own_and_the_stamp_and_place_of_now(gripping):
    surfaces = SceneSurfaces(gripping)
    markers = SurfaceMarkers(surfaces)
    gripping.reset()  # the hand goes somewhere else, and loses its air
    message = deserialize_message(markers.message(STAMP), MarkerArray)
    expected = surfaces.now()
    assert [marker.ns for marker in message.markers] == list(expected)
    for marker in message.markers:
        corners, color = expected[marker.ns]
        assert (marker.type, marker.action, marker.id) == (Marker.TRIANGLE_LIST, Marker.ADD, 0)
        assert (marker.header.stamp, marker.header.frame_id) == (STAMP, "world")
        assert marker.pose.orientation.w == marker.scale.x == 1.0
        np.testing.assert_array_equal(array(marker.points), corners)
        shown = marker.color
        np.testing.assert_allclose((shown.r, shown.g, shown.b, shown.a), color, atol=1e-6)


@pytest.fixture
def viewed(gripping):
    """Contact points and arrows of a publication, as often as it is called."""
    node = Node()
    seen = SceneMarkers(node, gripping, None)

    def publish():
        seen.publish_markers(STAMP)
        found = node.publishers["hand/markers"].sent[-1].markers
        (points,) = (marker for marker in found if marker.ns == "contacts")
        return points, [marker for marker in found if marker is not points]

    return publish


def test_each_pair_has_one_arrow_that_is_deleted_when_it_parts(gripping, viewed):
    pairs = {f"force/{pair}" for pair in by_pair(gripping.contacts())}
    _, arrows = viewed()
    assert {(m.ns, m.type, m.action, m.id) for m in arrows} == {
        (pair, Marker.ARROW, Marker.ADD, 0) for pair in pairs
    }
    assert all(len(marker.points) == 2 and marker.header.frame_id == "world" for marker in arrows)
    assert all(0 < marker.scale.x < marker.scale.y <= 0.02 for marker in arrows)
    gripping.reset()
    gripping.step()
    still = {f"force/{pair}" for pair in by_pair(gripping.contacts())}
    gone = {marker.ns for marker in viewed()[1] if marker.action == Marker.DELETE}
    assert gone == pairs - still != set()
    assert {marker.ns for marker in viewed()[1]} == still


def test_a_ball_lies_at_each_contact_and_goes_with_the_last(gripping, viewed, monkeypatch):
    balls, _ = viewed()
    assert (balls.type, balls.action) == (Marker.SPHERE_LIST, Marker.ADD)
    places = [contact.position for contact in gripping.contacts()]
    np.testing.assert_allclose(array(balls.points), places)
    monkeypatch.setattr(gripping, "contacts", list)
    assert viewed()[0].action == Marker.DELETE


def test_nothing_is_made_for_nobody(gripping, monkeypatch):
    node = Node(subscribers=0)
    seen = SceneMarkers(node, gripping, None)
    monkeypatch.setattr(gripping, "contacts", None)  # calling it would fail
    monkeypatch.setattr(gripping, "pressures", None)
    seen.publish_contacts(STAMP)
    seen.publish_markers(STAMP)
    assert not any(publisher.sent for publisher in node.publishers.values())


def test_numbers_that_are_in_a_message_twice_are_not_guessed_at():
    message = SerialisedMessage(np.array([1.0, 2.0, 1.0]).tobytes())
    with pytest.raises(
        ValueError, match="expected these numbers once in the serialized message, got 2"
    ):
        message.view(np.array([1.0]))


def pressed(pair, count, force):
    """So many contacts of a pair, that press with `force` [N] each."""
    first, second = pair.split("/")
    normal = (0.0, 0.6, 0.8)
    return [Contact(first, "j", second, (0.1 * k, 0.2, 0.3), normal, force) for k in range(count)]


@pytest.mark.parametrize("force", [0.0, 0.25, 123.4, 5.6e7, 1e308])
def test_markers_of_contacts_put_together_from_bytes_are_read_as_they_were_made(force):
    names = ["a/object", "ab/object", "abc/table", "abcdefgh/object"]
    pairs = {name: pressed(name, 1 + k % 3, force) for k, name in enumerate(names)}
    markers = ContactMarkers()
    for stamp in (STAMP, Time(sec=7, nanosec=1)):
        data = markers.message(stamp, pairs)
        deleting, *lines = deserialize_message(data, MarkerArray).markers
        assert len(data) == len(serialize_message(MarkerArray(markers=[deleting, *lines]))) + 3
        assert deleting.action == Marker.DELETEALL
        assert [marker.ns for marker in lines] == names
        assert all(marker.header.stamp == stamp for marker in [deleting, *lines])
        assert all(marker.type == Marker.LINE_LIST and marker.color.a == 1.0 for marker in lines)
        for marker, contacts in zip(lines, pairs.values(), strict=True):
            ends = np.reshape([contact_line(contact) for contact in contacts], (-1, 3))
            assert array(marker.points) == pytest.approx(ends)
        assert [float(marker.text) for marker in lines] == pytest.approx(
            [force * len(contacts) for contacts in pairs.values()], rel=1e-3
        )


def test_without_contacts_earlier_ones_are_deleted_alone():
    read = deserialize_message(ContactMarkers().message(STAMP, {}), MarkerArray)
    assert [marker.action for marker in read.markers] == [Marker.DELETEALL]
