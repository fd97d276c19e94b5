"""One model file in the simulator and in the monitor: the same physics, for every effect."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from model_lab.live.prediction import LivePrediction
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_bringup.lab_story.measuring import enclosed_air
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

HAND, FINGER = "single_finger", load_actuator("P10.finger")
OWN_EFFECT = Path(__file__).parents[2] / "examples" / "own_effect.py"
STEP, PLATEAU = 0.005, 0.7  # [s]
PLATEAUS = (10e3, 22e3, 14e3, 0.0)  # of the base model's finger [Pa]
# none that acts on a finger that bends freely is left out but gravity: the monitor does not know
# how the hand is held
VALUES = {
    "actuation_nonlinearity": {"a": 5.0, "p0": 40e3},
    "angle_offset": {"offset": 0.1},
    "angle_sensor_lag": {"time_constant": 0.3},
    "dead_zone": {"threshold": 4e3},
    "arruda_boyce": {"links": 3.0},
    "ballooning": {"gain": 1.0, "onset": 20e3, "sharpness": 6.0},
    "camera_perspective": {"foreshortening": 0.6},
    "chamber_contact": {"gain": 2.0, "onset": 20e3},
    "creep": {"rate": 0.12, "onset_time": 0.05},
    "gent_stiffening": {"jm": 4.0},
    "growing_chamber_lag": {"time_constant": 0.2, "doubling_pressure": 30e3},
    "hysteresis": {"relative_pressure": 0.2, "stretch_scale": 0.05},
    "ogden": {"exponent": 4.0},
    "saturation": {"limit": 0.8},
    "second_invariant": {"ratio": 2.0},
    "angle_gain": {"gain": 0.85},
    "sensor_drift": {"rate": 0.1, "settling_time": 100.0, "per_run": 0.0},
    "yeoh_third_order": {"c3": 0.05},
    "mullins_softening": {"softening": 0.3, "stretch_scale": 0.2},
    "permanent_set": {"share": 0.2},
    "pressure_gain": {"gain": 1.2},
    "pressure_offset": {"offset": 3e3},
    "second_relaxation": {"relative_modulus": 0.4, "relaxation_time": 0.5},
    "section_rounding": {"gain": 0.5, "pressure_scale": 15e3},
    "side_wall_integral": {},
    "thick_wall": {"gain": 3.0},
    "tube_lag": {"time_constant": 0.3},
    "viscoelasticity": {"relative_modulus": 0.4, "relaxation_time": 0.5},
    "yeoh_stiffening": {"c2": 0.1},
}
SILENT = {"gravity", "temperature_modulus", "discrepancy"}  # at room temperature; no physics
SILENT |= {"ageing"}  # in the first run
REFUSED = {"clock_offset", "tip_load"}  # by the simulator


def model_file(folder, entry):
    document = {"format": "softhand-model/1", "base": "pneuflex", "effects": [entry]}
    path = folder / "model.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


def simulated(model):
    """Times [ns], true pressures [Pa] and sensor readings [rad] of a finger brought to PLATEAUS."""
    simulation = Simulation(
        SimulationConfig(hand=HAND, scene="stand", model=model, step=STEP, seed=1)
    )
    masses = [enclosed_air(FINGER, pressure) for pressure in PLATEAUS]
    samples, before = [], 0.0
    for mass in masses:
        for index in range(round(PLATEAU / STEP)):
            share = min(1.0, index * STEP / 0.1)
            simulation.set_air_masses(np.array([before + share * (mass - before)]))
            simulation.step()
            stamp = round(simulation.time * 1e9)
            samples.append((stamp, simulation.pressures(), simulation.read_tip_angles()))
        before = mass
    return samples


def residual(samples, model):
    """Residuals [rad] of the model at the end of every plateau, where nothing swings."""
    prediction = LivePrediction(load_hand(HAND), model)
    found = []
    for stamp, pressures, angles in samples:
        prediction.add_pressures(stamp, pressures)
        found += prediction.add_angles(stamp, angles)
    at = np.array([one.stamp for one in found]) * 1e-9
    ends = PLATEAU * np.arange(1, len(PLATEAUS) + 1)
    near = np.any(np.abs(at[:, None] - ends + 0.05) < 0.04, axis=1)
    return np.concatenate([one.residual for one in found])[near]


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def test_every_effect_of_a_finger_that_bends_freely_is_tried():
    free = {n for n, c in effect_classes().items() if "free_bending" in c.experiments}
    assert free == VALUES.keys() | SILENT | REFUSED


@pytest.mark.parametrize("name", VALUES)
def test_the_monitor_predicts_what_the_simulator_does_with_the_same_file(name, tmp_path):
    path = model_file(tmp_path, {"name": name, "parameters": VALUES[name]})
    samples = simulated(path)
    right = rms(residual(samples, load_model(path)))
    assert right < math.radians(0.3)
    assert rms(residual(samples, load_model("base"))) > 5 * right


def test_an_effect_of_the_users_own_acts_in_both(tmp_path):
    shutil.copy(OWN_EFFECT, tmp_path)
    entry = {
        "name": "stretching_layer",
        "file": OWN_EFFECT.name,
        "parameters": {"compliance": 1e-5},
    }
    model = load_model(model_file(tmp_path, entry), allow_effect_files=True)
    samples = simulated(model)
    assert rms(residual(samples, model)) < math.radians(0.3)
    assert rms(residual(samples, load_model("base"))) > math.radians(3.0)
