"""The forward model's parameters and layout; the physics is in the experiments' own tests."""

import numpy as np
import pytest

from model_lab.experiments.forward import Forward, not_searched
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import effect_classes

EFFECTS = effect_classes()
SIZE = {
    "length": 0.09,
    "height": 0.02,
    "width": 0.02,
    "wall": 0.0025,
    "side_wall": 0.0025,
    "shear_modulus": 67e3,
}


def bending(with_time=True, samples=(3, 4)):
    runs = []
    for index, count in enumerate(samples):
        pressure = np.linspace(0.0, 40e3, count)
        columns = {"pressure": pressure, "tip_angle": pressure * 1e-5 + index}
        if with_time:
            columns["time"] = np.arange(count) * 0.1
        runs.append(Run(f"r{index}", "ab"[index], f"p{index}", 293.15, columns))
    specimens = {name: Specimen(name, SIZE, batch=name.upper()) for name in "ab"}
    return MeasurementSet("free_bending", "two specimens", specimens, tuple(runs))


def test_parameters_are_calibration_first_then_effects_in_the_order_of_stages():
    forward = Forward(bending(), effects=[EFFECTS["gent_stiffening"], EFFECTS["tube_lag"]])
    names = [parameter.name for parameter in forward.parameters]
    assert names == [
        "modulus_scale[A]",
        "modulus_scale[B]",
        "tube_lag.time_constant",
        "gent_stiffening.jm",
    ]
    assert [p.effect for p in forward.parameters] == [None, None, "tube_lag", "gent_stiffening"]
    for parameter in forward.parameters:
        assert parameter.low < parameter.typical[0] <= parameter.start <= parameter.typical[1]


def test_samples_are_laid_out_run_after_run():
    data = bending()
    forward = Forward(data)
    joined = np.concatenate([run.columns["tip_angle"] for run in data.runs])
    assert forward.measured.tolist() == joined.tolist()
    assert data.table.run.tolist() == [0, 0, 0, 1, 1, 1, 1]
    assert data.table.output.tolist() == [0] * 7
    assert data.column("pressure")[3:].tolist() == data.runs[1].columns["pressure"].tolist()
    assert forward.predict(np.ones((5, 2))).shape == (5, 7)


def test_every_lane_is_a_model_of_its_own():
    forward = Forward(bending(), effects=[EFFECTS["viscoelasticity"]])
    lanes = np.array([[1.0, 1.1, 0.2, 0.3], [0.9, 1.0, 0.4, 2.0]])
    together = forward.predict(lanes)
    for lane, predicted in zip(lanes, together, strict=True):
        assert forward.predict(lane[None])[0] == pytest.approx(predicted, rel=1e-7, abs=1e-9)


def test_calibration_of_a_model_file_stays_when_it_is_not_free():
    data, scales = bending(), {"modulus_scale": {"A": 1.1, "B": 0.9, "C": 2.0}}
    kept = Forward(data, calibration=scales, free_calibration=False)
    assert kept.parameters == ()
    expected = Forward(data).predict(np.array([[1.1, 0.9]]))
    assert kept.predict(np.zeros((1, 0))).tolist() == expected.tolist()
    assert Forward(data, calibration=scales).start().tolist() == [1.1, 0.9]


def test_fixed_effects_act_without_parameters():
    stiff = EFFECTS["gent_stiffening"](jm=5.0)
    fixed = Forward(bending(), fixed=[stiff]).predict(np.ones((1, 2)))
    free = Forward(bending(), effects=[EFFECTS["gent_stiffening"]])
    assert fixed.tolist() == free.predict(np.array([[1.0, 1.0, 5.0]])).tolist()


def test_what_cannot_act_is_refused_with_its_reason():
    with pytest.raises(ValueError, match="tube_lag: it depends on what was before"):
        Forward(bending(with_time=False), effects=[EFFECTS["tube_lag"]])
    with pytest.raises(ValueError, match="base: expected one of pneuflex, linear, got cubic"):
        Forward(bending(), base="cubic")
    with pytest.raises(KeyError):
        bending(with_time=False).column("time")


def test_specimen_without_a_size_is_named():
    data = bending()
    size = {key: value for key, value in SIZE.items() if key != "wall"}
    broken = {**data.specimens, "b": Specimen("b", size)}
    lacking = MeasurementSet("free_bending", "", broken, data.runs)
    with pytest.raises(ValueError, match=r"specimens.b: expected the key wall \[m\]"):
        Forward(lacking)


def pulled(*courses):
    """A set of strips that are pulled along such stretches over times (time, stretch)."""
    runs = tuple(
        Run(f"r{k}", "s", f"p{k}", 293.15, {"time": t, "stretch": x, "stress": 0.0 * t})
        for k, (t, x) in enumerate(courses)
    )
    return MeasurementSet("uniaxial", "", {"s": Specimen("s")}, runs)


TIME = np.linspace(0.0, 10.0, 101)
RAMP = (TIME, 1.0 + 0.2 * TIME)


@pytest.mark.parametrize(
    ("courses", "searched"),
    [
        ([RAMP, RAMP], False),
        ([RAMP, (4.0 * TIME, RAMP[1])], True),  # another rate
        ([(TIME, 1.0 + 0.2 * np.minimum(TIME, 5.0))], True),  # it rests
        ([(TIME, 2.0 - 0.2 * np.abs(TIME - 5.0))], True),  # it returns
    ],
)
def test_what_depends_on_time_is_not_sought_where_the_input_tells_the_time(courses, searched):
    data = pulled(*courses)
    assert (not_searched(EFFECTS["viscoelasticity"], data, "pneuflex") is None) == searched
    assert not_searched(EFFECTS["yeoh_stiffening"], data, "pneuflex") is None
