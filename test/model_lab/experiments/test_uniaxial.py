"""Stress of a stretched strip: closed forms of each effect."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run

from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import Specimen
from softhand_model.effects import effect_classes

EFFECTS = effect_classes()
TIME = np.linspace(0.0, 5.0, 200)
STRETCH = 1.0 + 0.4 * TIME
NEO_HOOKEAN = 67e3 * (STRETCH - STRETCH**-2.0)


def pulled(*stretches, time=TIME, **options):
    runs = [run(f"r{index}", time, stretch=s, **options) for index, s in enumerate(stretches)]
    return measured("uniaxial", runs)


def stresses(data, *effects):
    forward = Forward(data, fixed=effects, free_calibration=False)
    return forward.predict(np.zeros((1, 0)))[0]


def test_base_is_neo_hookean():
    assert stresses(pulled(STRETCH)) == pytest.approx(NEO_HOOKEAN)


@pytest.mark.parametrize(("strips", "accuracy"), [(4.0, 2e-5), (1.0, 1e-3)])
@pytest.mark.parametrize("lasting", [(), ("viscoelasticity",)])
def test_grips_that_yield_add_to_the_stretch_that_is_read(strips, accuracy, lasting):
    """lambda_read = lambda + stress/stiffness; strips: stiffness of the grips over the modulus."""
    effects = [EFFECTS[name](relative_modulus=0.3, relaxation_time=1.0) for name in lasting]
    free = stresses(pulled(STRETCH), *effects)
    stiffness = 67e3 * strips
    read = pulled(STRETCH + free / stiffness)
    found = stresses(read, *effects, EFFECTS["machine_compliance"](stiffness=stiffness))
    assert np.abs(found - free).max() <= accuracy * free.max()


@pytest.mark.filterwarnings("error")
def test_the_stress_in_grips_far_softer_than_the_rubber_is_about_theirs():
    law = EFFECTS["ogden"](exponent=8.0)
    found = stresses(pulled(STRETCH), law, EFFECTS["machine_compliance"](stiffness=1e4))
    assert (found >= 0.0).all() and (found[1:] < 1.1e4 * (STRETCH[1:] - 1.0)).all()


def test_grips_are_taken_to_be_stiffer_than_the_strip_that_they_hold():
    """Else a soft spring in series with a stiff strip makes up for any law of the rubber."""
    strip = replace(pulled(STRETCH).runs[0], columns={"time": TIME, "stretch": STRETCH})
    read = measured("uniaxial", [replace(strip, columns=strip.columns | {"stress": NEO_HOOKEAN})])
    (stiffness,) = Forward(
        read, effects=[EFFECTS["machine_compliance"]], free_calibration=False
    ).parameters
    late = STRETCH - 1.0 > 0.05 * 2.0
    secant = (NEO_HOOKEAN[late] / (STRETCH[late] - 1.0)).max()
    assert stiffness.low == pytest.approx(2.0 * secant)
    assert stiffness.low < stiffness.start < stiffness.high


def test_modulus_and_temperature_scale_the_stress():
    warm = pulled(STRETCH, temperature=313.15)
    stiffer = EFFECTS["temperature_modulus"](coefficient=0.005)
    forward = Forward(warm, fixed=[stiffer])
    assert forward.predict(np.array([[1.2]]))[0] == pytest.approx(1.2 * 1.1 * NEO_HOOKEAN)


@pytest.mark.parametrize(
    ("name", "values", "factor"),
    [
        ("gent_stiffening", {"jm": 20.0}, lambda lam, j: 1 / (1 - j / 20.0)),
        ("yeoh_stiffening", {"c2": 0.02}, lambda lam, j: 1 + 0.04 * j),
        ("mooney_rivlin", {"c01_ratio": 0.3}, lambda lam, j: (1 + 0.3 / lam) / 1.3),
    ],
)
def test_stiffening_has_the_invariant_of_tension(name, values, factor):
    invariant = STRETCH**2 + 2 / STRETCH - 3
    found = stresses(pulled(STRETCH), EFFECTS[name](**values))
    assert found == pytest.approx(NEO_HOOKEAN * factor(STRETCH, invariant))


def test_hysteresis_adds_its_loop():
    """Up to 3 and back: w = 1 - exp(-(lam-1)/a), then -1 + (w+1)*exp(-(3-lam)/a)."""
    stretch = np.concatenate([STRETCH, STRETCH[::-1]])
    rubbing = EFFECTS["hysteresis"](relative_pressure=0.1, stretch_scale=0.3)
    found = stresses(pulled(stretch, time=np.arange(400)), rubbing)
    up = 1 - np.exp(-(STRETCH - 1) / 0.3)
    down = -1 + (up[-1] + 1) * np.exp(-(3 - STRETCH[::-1]) / 0.3)
    friction = 0.1 * 67e3 * np.concatenate([up, down])
    both_ways = np.concatenate([NEO_HOOKEAN, NEO_HOOKEAN[::-1]])
    assert found == pytest.approx(both_ways + friction)


def test_mullins_softens_the_second_pull():
    softening = EFFECTS["mullins_softening"](softening=0.4, stretch_scale=0.5)
    first, second = stresses(pulled(STRETCH, STRETCH), softening).reshape(2, -1)
    assert first == pytest.approx(NEO_HOOKEAN)
    lost = 0.4 * (1 - np.exp(-(3.0 - STRETCH) / 0.5))
    assert second == pytest.approx(NEO_HOOKEAN * (1 - lost))


def test_mullins_knows_how_far_a_strip_was_stretched_before():
    """Below the stretch of 4 that no run holds: softened from the first sample on."""
    softening = EFFECTS["mullins_softening"](softening=0.4, stretch_scale=0.5)
    data = pulled(STRETCH, STRETCH)
    runs = (replace(data.runs[0], stretched_to=4.0), data.runs[1])
    lost = 0.4 * (1 - np.exp(-(4.0 - STRETCH) / 0.5))
    softened = NEO_HOOKEAN * (1 - lost)
    for one in (replace(data, runs=runs), in_modes(replace(data, runs=runs))):
        first, second = stresses(one, softening).reshape(2, -1)
        assert first == pytest.approx(softened)
        assert second == pytest.approx(softened)  # the same strip
    less = (data.runs[0], replace(data.runs[1], stretched_to=2.0))  # than in the first run
    first, second = stresses(replace(data, runs=less), softening).reshape(2, -1)
    assert first == pytest.approx(NEO_HOOKEAN)
    assert second == pytest.approx(NEO_HOOKEAN * (1 - 0.4 * (1 - np.exp(-(3.0 - STRETCH) / 0.5))))
    viscous = EFFECTS["viscoelasticity"](relative_modulus=0.5, relaxation_time=2.0)
    both = stresses(replace(data, runs=runs), softening, viscous)
    alone = stresses(pulled(STRETCH), viscous)
    assert not np.allclose(both[: len(STRETCH)], alone)
    rubbing = EFFECTS["hysteresis"](relative_pressure=0.1, stretch_scale=0.3)
    assert stresses(replace(data, runs=runs), rubbing) == pytest.approx(stresses(data, rubbing))


def in_modes(data):
    """The same pulls as a set of rubber."""
    runs = tuple(replace(run, mode="uniaxial") for run in data.runs)
    return replace(data, experiment="rubber", runs=runs)


def test_viscous_stress_relaxes_after_a_jump():
    held = np.full(200, 2.0)
    solid = EFFECTS["viscoelasticity"](relative_modulus=0.5, relaxation_time=2.0)
    found = stresses(pulled(held), solid)
    expected = 67e3 * 1.75 * (1 + 0.5 * np.exp(-TIME / 2.0))
    assert found == pytest.approx(expected)
    at_rest = stresses(pulled(held, steady=True), solid)
    assert at_rest == pytest.approx(np.full(200, 67e3 * 1.75))


def test_effects_of_pressure_and_shape_are_refused():
    with pytest.raises(ValueError, match="dead_zone: the stretch is imposed"):
        Forward(pulled(STRETCH), effects=[EFFECTS["dead_zone"]])
    with pytest.raises(ValueError, match="thick_wall: a strip in tension"):
        Forward(pulled(STRETCH), effects=[EFFECTS["thick_wall"]])


def test_only_the_modulus_is_needed():
    data = measured(
        "uniaxial", [run("r", stretch=STRETCH)], Specimen("d2.5", {"shear_modulus": 67e3})
    )
    assert stresses(data) == pytest.approx(NEO_HOOKEAN)
    with pytest.raises(ValueError, match="expected the key shear_modulus"):
        Forward(measured("uniaxial", [run("r", stretch=STRETCH)], Specimen("d2.5", {})))


def test_every_lane_stretches_to_its_own_modulus():
    data = pulled(STRETCH)
    lanes = Forward(data).predict(np.array([[1.0], [1.1]]))
    assert lanes == pytest.approx(np.stack([NEO_HOOKEAN, 1.1 * NEO_HOOKEAN]))
