"""An effect of one's own: a passive layer that stretches under pressure, so that the finger bends
less.

The class is all that is needed. A model file names it together with this file, and simulator,
monitor and lab have it; `model-lab diagnose DATA --model M --effects examples/own_effect.py` lets
it compete with the built-in ones. `python examples/own_effect.py` prints what it does.
"""

import shutil

import numpy as np
import pandas as pd

import model_lab as lab
from softhand_model.chain.chain import discretise
from softhand_model.effects import Parameter, StructureEffect
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model


class StretchingLayer(StructureEffect):
    """Curvature over 1 + compliance*p: the passive layer gives way to the pressure."""

    name = "stretching_layer"
    experiments = frozenset({"free_bending", "base_torque"})
    parameters = (
        Parameter(
            "compliance",
            "1/Pa",
            0.0,
            1e-4,
            "relative stretch of the layer per pressure",
            typical=(5e-7, 1e-5),
            neutral=0.0,
        ),
    )

    def act_on_curvature(self, curvature, pressure, shape):
        """Free curvature [1/m]."""
        return curvature / (1.0 + self.values["compliance"] * pressure)


MODEL = """
format: softhand-model/1
base: pneuflex
effects:
  - {name: stretching_layer, file: own_effect.py, parameters: {compliance: 5.0e-6}}
"""
FINGER = load_hand("single_finger").chain("finger")


def simulated_angle(model, pressure):
    """Tip angle [rad] of the simulator's finger when nothing touches it."""
    chain = discretise(FINGER, 5, model)
    return float(chain.step(1e-3, [pressure], np.zeros((5, 3)))[:, 1].sum())


def predicted_angles(pressure, *effects):
    """Tip angles [rad] that the lab predicts at pressures [Pa]."""
    size = {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.0025, "side_wall": 0.0025}
    frame = pd.DataFrame({"pressure": pressure, "tip_angle": 0.0 * pressure})
    units = {"pressure": "Pa", "tip_angle": "rad"}
    specimens = {"d2.5": {**size, "shear_modulus": 67e3}}
    data = lab.from_frames({"ramp": frame}, "free_bending", specimens, units)
    return lab.predict(data, Model(effects=effects)).runs["ramp"]["tip_angle"]


def test_a_model_file_brings_the_effect_into_the_simulator(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL, encoding="utf-8")
    shutil.copy(__file__, tmp_path)
    stretched = simulated_angle(load_model(path, allow_effect_files=True), 40e3)
    np.testing.assert_allclose(stretched, simulated_angle(Model(), 40e3) / 1.2, rtol=1e-6)


def test_the_lab_predicts_with_the_effect():
    pressure = np.linspace(0.0, 40e3, 50)
    stretched = predicted_angles(pressure, StretchingLayer(compliance=5e-6))
    np.testing.assert_allclose(stretched, predicted_angles(pressure) / (1 + 5e-6 * pressure))


if __name__ == "__main__":
    for compliance in (0.0, 2.5e-6, 5e-6):
        model = Model(effects=(StretchingLayer(compliance=compliance),))
        angle = np.degrees(simulated_angle(model, 40e3))
        print(f"compliance {compliance:.1e} 1/Pa: the finger bends by {angle:.1f} deg at 40 kPa")
