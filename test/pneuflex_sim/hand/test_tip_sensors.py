"""Tip angles as their sensors show them, under the output effects of a model file."""

import numpy as np
import pytest

from pneuflex_sim.hand.kinematics import TipSensors
from softhand_model.model_file import Model, load_model

LAGGING = """
format: softhand-model/1
base: pneuflex
effects:
  - {name: angle_offset, parameters: {offset: 0.1}}
  - {name: angle_sensor_lag, parameters: {time_constant: 0.2}}
"""


@pytest.fixture
def lagging(tmp_path):
    path = tmp_path / "lagging.yaml"
    path.write_text(LAGGING, encoding="utf-8")
    return path


def test_sensor_follows_a_ramp_late_and_reads_its_offset(lagging):
    """rate*(t - tau*(1 - exp(-t/tau))) + offset."""
    sensors = TipSensors(load_model(lagging))
    assert sensors.readings({"finger": 0.0}) == {"finger": pytest.approx(0.1)}
    for step in range(1, 501):
        sensors.step(1e-3, {"finger": 2.0 * step * 1e-3})
    exact = 2.0 * (0.5 - 0.2 * (1 - np.exp(-0.5 / 0.2))) + 0.1
    assert sensors.readings({"finger": 1.0}) == {"finger": pytest.approx(exact)}
    sensors.reset()
    assert sensors.readings({"finger": 0.0}) == {"finger": pytest.approx(0.1)}


def test_without_effects_the_readings_are_the_true_angles():
    sensors = TipSensors(Model())
    assert not sensors.active
    assert sensors.readings({"finger": 0.7}) == {"finger": 0.7}


def test_simulated_finger_is_read_through_its_sensor(simulate, hold_pressure, lagging):
    simulation = simulate(hand="single_finger", scene="stand", step=0.002, model=lagging)
    true = []
    original = simulation.tip_sensors.step

    def noted(dt, angles):
        true.append(angles["finger"])
        original(dt, angles)

    simulation.tip_sensors.step = noted
    hold_pressure(simulation, [10e3], 0.6)
    saved = simulation.save()
    follows = 0.0
    for before, angle in zip([0.0, *true], true, strict=False):
        left = np.exp(-0.01)
        rate = (angle - before) / 0.01
        follows = angle - rate * (1 - left) + left * (follows - before)
    assert simulation.read_tip_angles()["finger"] == pytest.approx(follows + 0.1, rel=1e-9)
    assert simulation.tip_angles()["finger"] == true[-1]
    before = simulation.read_tip_angles()
    hold_pressure(simulation, [20e3], 0.1)
    assert simulation.read_tip_angles() != before
    simulation.restore(saved)
    assert simulation.read_tip_angles() == before
