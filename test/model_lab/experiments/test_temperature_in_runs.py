"""A temperature that changes during a run acts sample by sample, as that of whole runs does."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run, specimen
from measurement_folder import csv_text, document, write_set

from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import Specimen
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects import effect_classes

WARMTH = np.array([283.15, 293.15, 303.15, 313.15])
TIME = np.arange(4.0)
STRIP = Specimen("strip", {"gauge_length": 0.03, "shear_modulus": 60e3}, batch="A")
SETS = {
    "free_bending": ("pressure", 25e3, specimen()),
    "blocked_tip": ("pressure", 25e3, specimen()),
    "uniaxial": ("stretch", 1.6, STRIP),
}


def predicted(experiment, runs, of, *names):
    effects = [effect_classes()["temperature_modulus"](coefficient=-0.006)]
    data = measured(experiment, runs, of)
    forward = Forward(data, "pneuflex", (), [*effects, *(effect_classes()[n]() for n in names)], {})
    return forward.predict(forward.start()[None])[0].reshape(len(runs), -1)


@pytest.mark.parametrize(
    ("experiment", "names"),
    [
        ("free_bending", ()),
        ("blocked_tip", ()),
        ("blocked_tip", ("finite_rotation",)),
        ("uniaxial", ()),
    ],
)
def test_each_sample_is_that_of_a_run_at_its_temperature(experiment, names):
    name, value, of = SETS[experiment]
    held = {name: np.full(4, value)}
    plain = run("r", TIME, of=of.name, temperature=296.0, **held)
    changing = replace(plain, columns={**plain.columns, "temperature": WARMTH})
    constant = [run(f"c{k}", TIME, of=of.name, temperature=t, **held) for k, t in enumerate(WARMTH)]
    expected = predicted(experiment, constant, of, *names)[:, 0]
    found = predicted(experiment, [changing], of, *names)[0]
    assert found == pytest.approx(expected, rel=1e-9)
    if experiment != "blocked_tip":  # whose force hardly shows the modulus
        assert np.ptp(found) > 0.05 * found.mean()


def written(tmp_path, kelvin, unit):
    content = document()
    content["columns"]["temperature"] = {"unit": unit}
    content["runs"]["r1"].pop("temperature", None)
    rows = {"time": TIME, "pressure": TIME, "tip_angle": TIME, "temperature": kelvin}
    return write_set(tmp_path, content, {"r1.csv": csv_text(rows)})


def test_a_run_without_a_temperature_has_the_mean_of_its_column(tmp_path):
    (one,) = load_measurements(written(tmp_path, WARMTH - 273.15, "degC")).runs
    assert one.temperature == pytest.approx(WARMTH.mean())
    np.testing.assert_allclose(one.warmth, WARMTH)


def test_a_temperature_without_its_unit_is_refused(tmp_path):
    with pytest.raises(DocumentError, match="temperature of 200 to 500 K.*degC"):
        load_measurements(written(tmp_path, WARMTH - 273.15, "K"))
