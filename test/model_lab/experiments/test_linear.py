"""The base `linear`: coefficients, and effects in units of the largest output."""

import numpy as np
import pytest
from lab_sets import measured, run
from scipy.optimize import brentq

from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import Specimen
from softhand_model.effects import effect_classes

EFFECTS = effect_classes()
PRESSURE = np.linspace(0.0, 40e3, 50)
TIME = np.linspace(0.0, 5.0, 50)


def unknown(experiment="blocked_tip", time=TIME, temperature=293.15, **columns):
    runs = [
        run("r0", time, of="a", temperature=temperature, **columns),
        run("r1", time, of="b", temperature=temperature, **columns),
    ]
    return measured(experiment, runs, Specimen("a"), Specimen("b"))


def outputs(data, *effects, coefficients=(2e-5, 4e-5)):
    forward = Forward(data, "linear", fixed=effects)
    return forward.predict(np.array([coefficients]))[0].reshape(2, -1)


def test_output_is_proportional_for_each_specimen():
    found = outputs(unknown(pressure=PRESSURE))
    assert found == pytest.approx(np.stack([2e-5 * PRESSURE, 4e-5 * PRESSURE]))


def test_coefficients_start_at_their_least_squares():
    data = unknown(pressure=PRESSURE, tip_force=3e-5 * PRESSURE + 0.01)
    forward = Forward(data, "linear")
    assert [p.name for p in forward.parameters] == ["coefficient[a]", "coefficient[b]"]
    assert {p.unit for p in forward.parameters} == {"N/Pa"}
    best = 3e-5 + 0.01 * PRESSURE.sum() / (PRESSURE @ PRESSURE)
    assert forward.start() == pytest.approx([best, best])


def test_stiffening_acts_on_the_output_over_the_largest():
    """u*(1 + 2*c2*u**2) = s with u = y/y_ref and y_ref = 1.6 N, the largest of both specimens."""
    found = outputs(unknown(pressure=PRESSURE), EFFECTS["yeoh_stiffening"](c2=0.3))
    for row, coefficient in zip(found, (2e-5, 4e-5), strict=True):
        shares = coefficient * PRESSURE / 1.6
        exact = [brentq(lambda u, s=s: u * (1 + 0.6 * u**2) - s, -1.0, 2.0) for s in shares]
        assert row == pytest.approx(1.6 * np.array(exact), rel=1e-8, abs=1e-10)


def test_memory_acts_on_the_output_over_the_largest():
    solid = EFFECTS["viscoelasticity"](relative_modulus=0.5, relaxation_time=1.0)
    data = unknown(pressure=np.full(50, 40e3))
    found = outputs(data, solid)
    # u + nu = s with nu' = -nu + 0.5*u': u' = nu/1.5, so u = s*(1 - exp(-t/1.5)/3)
    exact = 1 - np.exp(-TIME / 1.5) / 3
    assert found == pytest.approx(np.stack([0.8 * exact, 1.6 * exact]), rel=1e-4)


def test_pressure_temperature_and_readings_act_as_written():
    warm = unknown(pressure=PRESSURE, temperature=303.15)
    found = outputs(
        warm,
        EFFECTS["dead_zone"](threshold=5e3),
        EFFECTS["section_rounding"](gain=0.5, pressure_scale=10e3),
        EFFECTS["temperature_modulus"](coefficient=0.02),
        EFFECTS["force_offset"](offset=0.1),
    )
    acting = np.maximum(PRESSURE - 5e3, 0.0)
    load = acting * (1 - 0.5 * np.exp(-acting / 10e3)) / 1.2
    assert found[1] == pytest.approx(4e-5 * load + 0.1)


def test_stretch_is_imposed_in_tension():
    data = unknown("uniaxial", stretch=1.0 + PRESSURE / 40e3)
    found = outputs(data, EFFECTS["gent_stiffening"](jm=4.0), coefficients=(50e3, 100e3))
    shares = PRESSURE / 40e3
    assert found[1] == pytest.approx(100e3 * shares / (1 - shares**2 / 4))
    half = shares / 2
    assert found[0] == pytest.approx(100e3 * half / (1 - half**2 / 4))


def test_what_needs_to_know_the_inside_is_refused():
    for name in ("gauge_compliance", "tip_friction", "thick_wall", "side_wall_integral"):
        with pytest.raises(ValueError, match=f"{name}: it has no meaning beside the base linear"):
            Forward(unknown(pressure=PRESSURE), "linear", effects=[EFFECTS[name]])
    with pytest.raises(ValueError, match="base linear: expected one of the experiments"):
        pulses = measured("valve_pulse", [run("r", of="a", direction=np.ones(3))], Specimen("a"))
        Forward(pulses, "linear")
