"""The lab's predictions against sets from the independent generator, with the true parameters."""

from dataclasses import replace

import numpy as np
import pytest

from bench.hidden.cases import all_cases
from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from softhand_model.effects import effect_classes

NOISE = 0.004
# each push once: the search for their strength goes through the whole set a hundred times
SMALLER = {"base_torque": {"runs": 6, "repeats": 1, "samples": 30}}
CASES = [
    case
    for case in all_cases()
    if case.row == "catalogue" and not case.name.endswith(("weak", "strong"))
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_true_parameters_leave_the_noise(case, tmp_path):
    shorter = {**case.options, "scatter": 0.0, **SMALLER.get(case.experiment, {})}
    truth = replace(case, options=shorter).make(tmp_path, 1, NOISE)
    fixed = [effect_classes()[law["name"]](**law["parameters"]) for law in truth["hidden"]]
    data = load_measurements(tmp_path)
    forward = Forward(data, "pneuflex", (), fixed)
    values = forward.start()
    for place, parameter in enumerate(forward.parameters):
        known = truth.get("calibration", {}).get(parameter.name, truth.get("modulus_scale"))
        values[place] = known
    residual = forward.measured - forward.predict(values[None])[0]
    assert np.sqrt((residual**2).mean()) == pytest.approx(truth["noise"], rel=0.12)
