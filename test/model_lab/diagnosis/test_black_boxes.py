"""Black boxes: each finds what varies with its own input, and none finds anything in noise."""

from dataclasses import replace

import numpy as np
import pytest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis.black_boxes import fit_black_boxes
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.noise_floor import make_spectrum, noise_floor
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen


def best(data):
    """The best black_box of the fitted toy model, and the error of that model."""
    forward = toy_forward(data)
    spectrum = make_spectrum(data.table, forward.measured)
    floor = noise_floor(data, spectrum, forward.measured - forward.predict(np.array([[2, 0.5]]))[0])
    found = fit(Likelihood(forward, spectrum, floor.variance), np.array([[1.0, 0.1]]))
    black_boxes = fit_black_boxes(found, data, forward.measured - found.residual)
    return black_boxes[0], found.rmse


def waves(random):
    """A toy set of waves up and down, of a frequency for each of six protocols."""
    runs = []
    for index in range(12):
        time = np.linspace(0.0, 10.0, 100)
        x = 0.5 - 0.5 * np.cos(0.4 * (1 + index // 2) * time)
        angle = 2.0 * x + 0.5 * x**2 + 0.02 * random.standard_normal(100)
        columns = {"time": time, "pressure": x, "tip_angle": angle}
        runs.append(Run(f"r{index}", "s", f"p{index // 2}", 293.15, columns))
    return MeasurementSet("free_bending", "toy", {"s": Specimen("s")}, tuple(runs))


def changed(data, change):
    """The set with `change(index, run)` added to the output."""
    return replace(
        data,
        runs=tuple(
            replace(
                run,
                columns={
                    **run.columns,
                    "tip_angle": run.columns["tip_angle"] + change(index, run),
                },
            )
            for index, run in enumerate(data.runs)
        ),
    )


@pytest.mark.parametrize(
    ("axis", "change"),
    [
        ("pressure", lambda _, run: 0.3 * np.sin(6.0 * run.columns["pressure"])),
        ("run_order", lambda index, _: 0.3 * np.cos(index / 3.0)),
        ("time_since_step", lambda _, run: 0.1 * np.sqrt(run.columns["time"])),
    ],
)
def test_the_best_black_box_is_the_one_with_the_input_that_matters(axis, change):
    black_box, error = best(changed(waves(np.random.default_rng(0)), change))
    assert black_box.against == axis
    assert black_box.rmse < 0.7 * error


def test_no_black_box_is_better_than_the_model_in_noise():
    shares = []
    for seed in range(20):
        black_box, error = best(toy_set(np.random.default_rng(seed)))
        shares.append(black_box.rmse / error)
    assert min(shares) > 0.9
