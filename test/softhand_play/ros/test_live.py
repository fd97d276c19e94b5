"""Running nodes on the page: simulator and driver as processes."""

from functools import partial

import numpy as np
import pytest
from forked_nodes import ForkingLauncher
from play_page import wait_until
from ros_domain import held_domain
from sensor_msgs.msg import JointState

from softhand_bringup.processes import suite
from softhand_ros.client_link import ClientLink

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]


@pytest.fixture
def reports():
    return []


@pytest.fixture
def live(tmp_path, monkeypatch, reports):
    """A page's source of a single finger whose nodes run."""
    pytest.importorskip("viser")
    from softhand_play.ros.live import LivePlayer

    options = suite.SuiteOptions(hand="single_finger", scene="stand", real_time_factor=1.0)
    with held_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        with ForkingLauncher(tmp_path, suite.node_environment(tmp_path, domain)) as launcher:
            for command in (suite.simulator(options), suite.driver(options)):
                launcher.start(command)
            live = LivePlayer(
                "single_finger", "cylinder", "stand", lambda said, look=None: reports.append(said)
            )
            yield live
            live.close()


def test_sliders_command_running_nodes_and_their_hand_is_seen(live, reports):
    wait_until(lambda: live.frames and reports[-1] == "", "a hand and a driver")
    straight = live.frames[-1].state.joints
    live.command_pressures(np.array([15e3]))
    wait_until(lambda: live.frames[-1].pressures[0] > 13e3, "the pressure")
    assert np.abs(live.frames[-1].state.joints - straight).max() > 0.02
    held = live.frames[-1].time
    wait_until(lambda: live.frames[-1].time > held + 6.0, "more than the driver's command_timeout")
    assert live.frames[-1].pressures[0] > 13e3
    live.command_masses(np.array([0.0]))
    wait_until(lambda: live.frames[-1].pressures[0] < 3e3, "the air let out")
    live.paused = True
    wait_until(lambda: stands_still(live), "a simulator that stands still")


def test_what_was_asked_for_before_the_driver_was_found_is_dropped(live):
    live.command_pressures(np.array([15e3]))
    wait_until(lambda: hasattr(live, "_box") and live._jobs.empty(), "a driver")
    live.command_pressures(np.array([np.nan]))  # nothing, but after what was before
    wait_until(live._jobs.empty, "an answer")
    assert not live._box._held


def test_the_box_is_vented_and_reset_from_the_page(live, reports):
    fill(live, reports)
    live.vent_box()
    wait_until(lambda: live.frames[-1].pressures[0] < 3e3, "the air let out")
    wait_until(lambda: reports[-1].startswith("all outlets open"), "the driver's answer")
    live.reset_box()
    wait_until(lambda: reports[-1].startswith("valves are closed"), "the driver's answer")
    fill(live, reports)


def test_without_a_browser_the_driver_lets_the_air_out_after_its_command_timeout(live, reports):
    fill(live, reports)
    live.is_watched = lambda: False
    wait_until(lambda: live.frames[-1].pressures[0] < 3e3, "the air let out")


def fill(live, reports):
    wait_until(lambda: live.frames and hasattr(live, "_box"), "a hand and a driver")
    wait_until(lambda: bends(live), "the pressure")


def test_messages_that_do_not_fit_the_hand_are_told_and_the_page_goes_on(live, reports):
    wait_until(lambda: live.frames and reports[-1] == "", "a hand and a driver")
    with ClientLink("stranger") as link:
        wrong = {
            "hand/joint_states": JointState(name=["other"], position=[0.0]),
            "pneumaticbox/state": JointState(name=list(live._hand.channels), position=[0.0]),
        }
        for topic, message in wrong.items():
            publisher = link.node.create_publisher(JointState, topic, 10)
            wait_until(partial(send, publisher, message, reports, topic), f"a word on {topic}")
    before = live.frames[-1].time
    wait_until(lambda: live.frames[-1].time > before + 0.5, "a hand that is seen still")
    wait_until(lambda: bends(live), "the pressure")


def bends(live):
    live.command_pressures(np.array([15e3]))  # again: the first one tells of the wrong state
    return live.frames[-1].pressures[0] > 13e3


def send(publisher, message, reports, topic):
    publisher.publish(message)
    return any(sentence.startswith(f"{topic}: ") and "expected" in sentence for sentence in reports)


def stands_still(live):
    before = live.frames[-1].time
    live._closing.wait(1.0)
    return live.frames[-1].time == before


def test_the_page_of_running_nodes_has_buttons_for_the_box(monkeypatch, tmp_path):
    pytest.importorskip("viser")
    from softhand_play.page import Page
    from softhand_play.ros.live import LivePlayer

    with held_domain() as domain:
        for name, value in suite.node_environment(tmp_path, domain).items():
            monkeypatch.setenv(name, value)
        page = Page(
            "127.0.0.1", 0, partial(LivePlayer, "single_finger", "cylinder", "stand"), live=True
        )
        handles = page.server.gui._gui_input_handle_from_uuid.values()
        labels = {handle.label for handle in handles}
        watched = page.player.is_watched()
        page.close()
    assert {"vent the box", "reset the box"} <= labels
    assert not watched
