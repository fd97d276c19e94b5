"""How near the base model comes to measurements of two fingers.

`python examples/compare_with_measurements.py` prints the comparison; so does
`model-lab compare examples/measurements/finger`.
"""

from pathlib import Path

import numpy as np

import model_lab as lab

FOLDER = Path(__file__).parent / "measurements" / "finger"


def comparison():
    """The base model, its modulus fitted, against the set."""
    return lab.compare(FOLDER, "base")


def test_the_fitted_modulus_is_the_one_that_was_put_in_and_the_rest_is_noise():
    found = comparison()
    errors = found.details.errors
    np.testing.assert_allclose(errors.calibration["modulus_scale"]["A"], 1.04, atol=0.01)
    assert errors.held_out.rmse <= errors.floor.upper
    assert found.unit == "deg"


if __name__ == "__main__":
    print(comparison())
