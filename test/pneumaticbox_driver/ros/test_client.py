"""The client: what it does to a driver, and what it says when the box refuses."""

import time

import numpy as np
import pytest
from plant_peer import BOX, MG, MODULE

from pneumaticbox_driver.ros.client import (
    Complaints,
    Diagnosis,
    PneumaticboxClient,
    PneumaticboxError,
)
from softhand_bringup.processes.launcher import NodeCommand

# a busy machine must not starve a driver that follows the wall clock
EMBEDDED = {"backend": "embedded", "embedded_rate": 100.0, "real_time_priority": 20}

pytestmark = pytest.mark.system


def test_a_vent_that_was_not_asked_for_is_complained_of():
    complaints = Complaints()
    vented = {"safety": Diagnosis(2, "vented until pneumaticbox/reset: burst", {})}
    assert complaints.of({"safety": Diagnosis(0, "in operation", {})}) == ""
    assert complaints.of(vented) == "vented until pneumaticbox/reset: burst"
    complaints.vent_wanted = True
    assert complaints.of(vented) == ""


def test_only_messages_refused_since_the_beginning_are_complained_of():
    complaints = Complaints()

    def commands(count):
        return {"commands": Diagnosis(1, "refused x", {"refused messages": str(count)})}

    assert complaints.of(commands(3)) == ""
    assert complaints.of(commands(3)) == ""
    assert complaints.of(commands(4)) == "refused x"
    assert complaints.of(commands(4)) == ""


@pytest.fixture
def box(request, domain, launcher, peer):
    """A client of a driver with two bottles, in the namespace that the test asks for; `peer` has
    set the environment.
    """
    namespace = getattr(request, "param", "")
    remappings = {"__ns": f"/{namespace}"} if namespace else {}
    launcher.start(NodeCommand("driver", MODULE, {**BOX, **EMBEDDED}, remappings=remappings))
    topic = f"/{namespace}/pneumaticbox/state".replace("//", "/")
    peer.wait(lambda: peer.node.count_publishers(topic), "the driver")
    with PneumaticboxClient(domain=domain, namespace=namespace) as box:
        box.reset()  # on a busy machine its start may take so long that it misses samples and vents
        yield box


def filled(box, masses, times, tries=3):
    """States of 2 s in which the box is filled; again where the whole machine stood still so long
    that the driver rightly vented.
    """
    box.run(masses, times=times)
    try:
        return list(box.monitor(2.0))
    except PneumaticboxError as error:
        if "no sensor sample" not in str(error) or tries == 1:
            raise
    box.reset()
    return filled(box, masses, times, tries - 1)


def test_it_brings_the_box_to_masses_and_watches_it(box):
    assert box.channels == ("a", "b")
    assert box.modes == {"a": "mass", "b": "mass"}
    states = filled(box, {"a": [10 * MG, 25 * MG], "b": [5 * MG, 5 * MG]}, [0.5, 1.0])
    assert states[-1].mass["a"] == pytest.approx(25 * MG, abs=2.5 * MG)
    assert states[-1].mass["b"] == pytest.approx(5 * MG, abs=2.5 * MG)
    steps = np.diff([state.time for state in states])
    assert np.median(steps) == pytest.approx(0.01, abs=0.005)
    assert states[-1].time - states[0].time == pytest.approx(2.0, abs=0.3)
    assert "disabled" in box.stop()
    box.run({"a": 0.0})
    with pytest.raises(PneumaticboxError, match="disabled: no command is taken"):
        list(box.monitor(3.0))
    assert "commands are taken" in box.start()


def test_air_is_held_while_the_client_listens_and_let_out_when_it_does_not(box):
    box.run({"a": 25 * MG})
    assert list(box.monitor(7.0))[-1].mass["a"] == pytest.approx(25 * MG, abs=2.5 * MG)
    time.sleep(6.0)  # longer than the driver's command_timeout
    with pytest.raises(PneumaticboxError, match=r"no command for 5.0 s"):
        list(box.monitor(2.0))


@pytest.mark.parametrize("box", ["left"], indirect=True)
def test_what_the_box_refuses_is_raised_with_its_sentence(box):
    with pytest.raises(PneumaticboxError, match="got 'force'"):
        box.configure(control_mode="force")
    with pytest.raises(PneumaticboxError, match="channels"):
        box.configure(channels=["x", "y"])  # read-only
    with pytest.raises(ValueError, match="got \\['z'\\]"):
        box.run({"z": 1 * MG})
    with pytest.raises(ValueError, match="times must have 1 entries, got 2"):
        box.run({"a": 1 * MG}, times=[1.0, 2.0])
    with pytest.raises(PneumaticboxError, match="calibration_volume must be above 0"):
        box.calibrate()
    assert box.modes == {"a": "mass", "b": "mass"}


def test_a_vent_ends_the_watching_unless_it_was_wanted(box, peer):
    from std_srvs.srv import Trigger

    assert "until pneumaticbox/reset" in box.vent()
    assert len(list(box.monitor(1.5))) > 10
    box.reset()
    assert len(list(box.monitor(1.5))) > 10
    peer.call(Trigger, "pneumaticbox/vent")
    with pytest.raises(PneumaticboxError, match="vented until pneumaticbox/reset: vent was"):
        list(box.monitor(5.0))


def test_without_a_driver_it_says_so(domain, peer):
    with pytest.raises(PneumaticboxError, match="no driver publishes pneumaticbox/state"):
        PneumaticboxClient(patience=0.5, domain=domain)


def test_there_is_no_state_before_the_first_one(domain, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(PneumaticboxClient, "_connect", lambda client: None)
    with PneumaticboxClient(domain=domain) as client:
        with pytest.raises(PneumaticboxError, match="no driver publishes pneumaticbox/state"):
            _ = client.state
        with pytest.raises(PneumaticboxError, match="no driver publishes pneumaticbox/state"):
            client.run({"a": 0.0})
