"""Running nodes on the page: simulator and driver as processes."""

import numpy as np
import pytest
from play_page import wait_until
from ros_domain import held_domain

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]


@pytest.fixture
def told():
    return []


@pytest.fixture
def live(tmp_path, monkeypatch, told):
    """A page's source of a single finger whose nodes run."""
    pytest.importorskip("viser")
    from softhand_play.ros.live import LivePlayer

    options = suite.SuiteOptions(hand="single_finger", scene="stand", real_time_factor=1.0)
    with held_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        with Launcher(tmp_path, suite.node_environment(tmp_path, domain)) as launcher:
            for command in (suite.simulator(options), suite.driver(options)):
                launcher.start(command)
            live = LivePlayer("single_finger", "cylinder", "stand", told.append)
            yield live
            live.close()


def test_sliders_command_running_nodes_and_their_hand_is_seen(live, told):
    wait_until(lambda: live.shots and told[-1] == "", "a hand and a driver")
    straight = live.shots[-1].state.joints
    live.command_pressures(np.array([15e3]))
    wait_until(lambda: live.shots[-1].pressures[0] > 13e3, "the pressure")
    assert np.abs(live.shots[-1].state.joints - straight).max() > 0.02
    live.command_masses(np.array([0.0]))
    wait_until(lambda: live.shots[-1].pressures[0] < 3e3, "the air let out")
    live.paused = True
    wait_until(lambda: stands_still(live), "a simulator that stands still")


def stands_still(live):
    before = live.shots[-1].time
    live._closing.wait(1.0)
    return live.shots[-1].time == before
