"""Calibration over ROS: begun, asked for another supply, saved, in use at once."""

import numpy as np
import pytest
from plant_peer import CHANNELS, MG
from std_srvs.srv import Trigger

from pneumaticbox_driver.calibration.file import load_box_note, load_calibration

pytestmark = pytest.mark.system

BOTTLE = 0.5e-3  # [m3]
PERIOD = 0.01  # of the samples [s]
BOTTLES = {"rest_volumes": [BOTTLE] * 2, "pressure_limits": [2e5] * 2}
SHORT = {
    "calibration_volume": BOTTLE,
    "calibration_points": 24,
    "calibration_leak_test": 0.0,
    "box": "of the test",
}


def values_of(status):
    return {pair.key: pair.value for pair in status.values}


def run_until(peer, state, limit=60.0):
    """Let the plant run until the calibration is in a state, or ended: the newest report."""
    end = peer.plant.time + limit
    while peer.plant.time < end:
        peer.run(0.5, PERIOD)
        for message in reversed(peer.told):
            for status in message.status:
                if status.name == "pneumaticbox: calibration":
                    if values_of(status).get("state", "") == state:
                        return status
                    break
            else:
                continue
            break
    pytest.fail(f"the calibration is not {state!r} within {limit} s")


def test_it_asks_for_a_second_supply_saves_what_it_finds_and_uses_it(start, peer, tmp_path):
    file = tmp_path / "found.yaml"
    start(**BOTTLES, **SHORT, calibration_output=str(file))
    peer.put(BOTTLE)
    peer.plant.set_supply(260e3)
    peer.connect()
    begun = peer.call(Trigger, "pneumaticbox/calibrate")
    assert begun.success and "has begun" in begun.message
    assert values_of(run_until(peer, "running"))["progress"].endswith("%")
    again = peer.call(Trigger, "pneumaticbox/calibrate")
    assert not again.success and "under way" in again.message
    peer.command(10 * MG, 10 * MG)
    peer.diagnosis("commands", "a calibration is under way")

    asked = run_until(peer, "waiting")
    assert "call pneumaticbox/calibrate_next" in asked.message
    same = peer.call(Trigger, "pneumaticbox/calibrate_next")
    assert not same.success and "turn it by 10 kPa" in same.message
    peer.plant.set_supply(320e3)
    peer.run(2.0, PERIOD)
    assert peer.call(Trigger, "pneumaticbox/calibrate_next").success

    report = run_until(peer, "")
    assert (report.message, values_of(report)["file"]) == ("OK", str(file))
    assert load_box_note(file).box == "of the test"
    found = load_calibration(file, len(CHANNELS))
    shipped = load_calibration(None, len(CHANNELS))
    for new, old in zip(found, shipped, strict=True):
        assert new.points == 24
        assert new.inflate.injector == pytest.approx(old.inflate.injector, rel=0.2)
    peer.run(2.0, PERIOD)
    held = peer.mass()
    peer.command(*(held + 20 * MG))
    peer.run(3.0, PERIOD)
    np.testing.assert_allclose(peer.mass(), held + 20 * MG, atol=3 * MG)


def test_without_bottles_or_a_new_file_it_does_not_begin(start, peer, tmp_path):
    start(**BOTTLES)
    peer.put(BOTTLE)
    peer.connect()

    def refusal():
        answer = peer.call(Trigger, "pneumaticbox/calibrate")
        assert not answer.success
        return answer.message

    assert "calibration_volume must be above 0" in refusal()
    assert peer.change("calibration_volume", BOTTLE) == ""
    assert "calibration_output must be the path of a new file" in refusal()
    present = tmp_path / "present.yaml"
    present.touch()
    peer.change("calibration_output", str(present))
    assert "which exists" in refusal()
    peer.change("calibration_output", str(tmp_path / "none" / "x.yaml"))
    assert "which is missing" in refusal()
    peer.change("calibration_output", str(tmp_path / "x.yaml"))
    peer.change("calibration_points", 13)
    assert "points must be at least 24 for 2 supply pressures" in refusal()
    answer = peer.call(Trigger, "pneumaticbox/calibrate_next")
    assert not answer.success and "call pneumaticbox/calibrate first" in answer.message


def test_on_the_simulated_box_the_supply_is_a_parameter_and_a_vent_ends_it(start, peer, tmp_path):
    output = tmp_path / "x.yaml"
    embedded = {"backend": "embedded", "embedded_rate": 100.0}
    start(**BOTTLES, **SHORT, **embedded, calibration_output=str(output))
    peer.wait(lambda: peer.states, "a state")
    assert peer.change("embedded_supply", 200e3) == ""
    peer.spin(3.0)
    supply = values_of(peer.diagnosis("sensors", keep_going=False))
    assert float(supply["supply pressure, absolute [Pa]"]) == pytest.approx(301e3, abs=20e3)
    assert "embedded_supply must be above 0" in peer.change("embedded_supply", 0.0)
    assert peer.call(Trigger, "pneumaticbox/calibrate").success
    peer.diagnosis("calibration", "venting the channels", keep_going=False)
    assert peer.call(Trigger, "pneumaticbox/vent").success
    peer.diagnosis("calibration", "calibration failed: vent was requested", keep_going=False)
    assert not output.exists()


def test_shared_coefficients_another_box_and_another_supply_are_told(start, peer):
    start(outlets=[1, 1], box="another")
    peer.plant.set_supply(200e3)
    peer.connect()
    peer.run(3.0, PERIOD)
    told = peer.diagnosis("calibration", "channels a and b share one calibration").message
    assert "calibration is of the box" in told and "not of 'another'" in told
    assert "channel a: supply of" in told and "kPa calibrated" in told
