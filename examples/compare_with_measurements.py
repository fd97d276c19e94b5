"""How near the base model comes to measurements of two fingers.

`python examples/compare_with_measurements.py` prints the comparison; so does
`model-lab compare examples/measurements/finger`.
"""

from pathlib import Path

import numpy as np

from model_lab.comparison.compare import compare
from model_lab.measurements.load import load_measurements
from model_lab.report.comparison_text import comparison_text
from softhand_model.model_file import load_model

FOLDER = Path(__file__).parent / "measurements" / "finger"


def comparison():
    """The base model, its modulus fitted, against the set."""
    return compare(load_measurements(FOLDER), load_model("base"))


def test_the_fitted_modulus_is_the_one_that_was_put_in_and_the_rest_is_noise():
    errors = comparison().errors
    np.testing.assert_allclose(errors.calibration["modulus_scale"]["A"], 1.04, atol=0.01)
    assert errors.held_out.rmse <= errors.floor.upper


if __name__ == "__main__":
    print(comparison_text(comparison(), "base"), end="")
