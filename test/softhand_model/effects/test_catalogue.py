"""The catalogue of effects: complete, documented, and each equation against its own formula."""

import numpy as np
import pytest

from softhand_model.bending.balance import grows
from softhand_model.effects import effect_classes
from softhand_model.effects.effect import EXPERIMENTS
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain
from softhand_model.hand.section import side_wall_ratio, side_wall_term

EFFECTS = effect_classes()
BY_STAGE = {
    "input": {
        "pressure_offset",
        "pressure_gain",
        "tube_lag",
        "growing_chamber_lag",
        "dead_zone",
        "clock_offset",
        "stretch_offset",
    },
    "load": {
        "temperature_modulus",
        "section_rounding",
        "gravity",
        "tip_load",
        "chamber_contact",
        "ballooning",
        "ageing",
    },
    "elastic": {
        "gent_stiffening",
        "yeoh_stiffening",
        "mooney_rivlin",
        "thick_wall",
        "mullins_softening",
        "viscoelasticity",
        "hysteresis",
        "yeoh_third_order",
        "second_invariant",
        "arruda_boyce",
        "ogden",
        "creep",
        "permanent_set",
        "second_relaxation",
    },
    "structure": {
        "side_wall_integral",
        "actuation_nonlinearity",
        "passive_layer_slack",
        "bend_twist_coupling",
        "gauge_compliance",
        "tip_friction",
        "finite_rotation",
        "machine_compliance",
    },
    "output": {
        "angle_offset",
        "force_offset",
        "angle_gain",
        "stress_offset",
        "angle_sensor_lag",
        "camera_perspective",
        "sensor_drift",
        "saturation",
    },
}
SHAPE = SectionShape(
    np.array([0.02]),
    np.array([0.018]),
    0.004,
    0.003,
    side_wall_ratio(np.array([0.02]), 0.018, 0.004, 0.003),
    67e3,
)
STRETCH = np.array([0.9, 1.0, 1.3, 2.0])


def effect(name, **values):
    return EFFECTS[name](**values)


def stress(name, mode="pure_shear", memory=None, dt=0.1, **values):
    """Elastic side over the base's at STRETCH, or what is added to it."""
    strain = Strain(STRETCH, mode)
    base = strain.elastic_term
    return effect(name, **values).stress(base, strain, SHAPE, memory or {}, dt), base


@pytest.mark.parametrize("stage", BY_STAGE)
def test_catalogue_is_complete_and_in_its_stage(stage):
    physical = {name for name, one in EFFECTS.items() if one.stage == stage and one.physical}
    assert physical == BY_STAGE[stage]


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_is_described(name):
    one = EFFECTS[name]
    assert one.__doc__
    assert one.experiments or one.unseen_in  # where it shows, or why it does not
    assert set(one.unseen_in) <= set(EXPERIMENTS)
    known = {*EFFECTS, "modulus_scale", "coefficient", "calibration"}
    assert set(one.confounded_with) <= known
    for parameter in one.parameters:
        assert parameter.description
        low, high = parameter.typical
        assert parameter.low <= low < high <= parameter.high
        assert parameter.low > 0.0 or not parameter.logarithmic


def test_effects_act_in_one_order_whatever_the_order_of_the_file():
    names = ["angle_offset", "angle_sensor_lag", "hysteresis", "dead_zone", "viscoelasticity"]
    names += ["gent_stiffening", "tube_lag", "pressure_gain", "pressure_offset"]
    made = [EFFECTS[name].in_lanes({}) for name in names]
    assert [one.name for one in StagedEffects(made).all] == [
        "pressure_offset",
        "pressure_gain",
        "tube_lag",
        "dead_zone",
        "gent_stiffening",
        "viscoelasticity",
        "hysteresis",
        "angle_sensor_lag",
        "angle_offset",
    ]


def test_sensor_reads_gain_times_pressure_and_offset():
    staged = StagedEffects(
        [effect("pressure_gain", gain=1.2), effect("pressure_offset", offset=500.0)]
    )
    pressure = np.array([0.0, 10e3, 40e3])
    read = 1.2 * pressure + 500.0
    assert staged.chamber_pressure(read, 0.0) == pytest.approx(pressure)


def test_dead_zone_takes_the_first_pressure():
    zone = effect("dead_zone", threshold=2e3)
    acting = zone.chamber_pressure(np.array([-1e3, 1e3, 5e3]), {}, 0.1)
    assert acting.tolist() == [0.0, 0.0, 3e3]


def test_lag_is_exact_for_a_ramp():
    """Answer to a ramp of rate r from rest: r*(t - tau*(1 - exp(-t/tau)))."""
    rate, tau, memory = 3e3, 0.4, {}
    lag = effect("tube_lag", time_constant=tau)
    assert lag.chamber_pressure(np.array(0.0), memory, 0.0) == 0.0
    times = np.cumsum([0.05, 0.3, 1.0, 0.01])
    found = [
        float(lag.chamber_pressure(np.array(rate * time), memory, step))
        for time, step in zip(times, np.diff(times, prepend=0.0), strict=True)
    ]
    assert found == pytest.approx(rate * (times - tau * (1 - np.exp(-times / tau))))


def test_reading_that_jumps_at_the_first_sample_finds_the_chamber_at_rest():
    lag = effect("tube_lag", time_constant=0.4)
    memory = {}
    assert lag.chamber_pressure(np.array(20e3), memory, 0.0) == 0.0
    later = float(lag.chamber_pressure(np.array(20e3), memory, 0.4))
    assert later == pytest.approx(20e3 * (1 - np.exp(-1)))


def test_modulus_follows_the_temperature():
    warm = effect("temperature_modulus", coefficient=0.004)
    assert float(warm.modulus_factor(np.array(313.15))) == pytest.approx(1.08)


def test_section_rounding_takes_load_at_low_pressure():
    rounding = effect("section_rounding", gain=0.4, pressure_scale=10e3)
    pressure = np.array([-5e3, 0.0, 10e3, 1e6])
    share = 1 - 0.4 * np.exp(-np.array([0.0, 0.0, 1.0, 100.0]))
    assert rounding.act_on_load(np.ones(4), pressure, SHAPE) == pytest.approx(share)


@pytest.mark.parametrize(
    ("name", "values", "factor"),
    [
        ("gent_stiffening", {"jm": 9.0}, lambda lam, j: 1 / (1 - j / 9.0)),
        ("yeoh_stiffening", {"c2": 0.03}, lambda lam, j: 1 + 0.06 * j),
        ("thick_wall", {"gain": 2.0}, lambda lam, j: 1 + 2 * 0.4**2 * np.exp(-(lam - 1) / 0.25)),
        ("mooney_rivlin", {"c01_ratio": 0.5}, lambda lam, j: 1.0),
    ],
)
def test_stiffening_is_a_factor(name, values, factor):
    found, base = stress(name, **values)
    invariant = STRETCH**2 + STRETCH**-2.0 - 2
    assert found == pytest.approx(base * factor(STRETCH, invariant))


def test_uniaxial_stress_of_mooney_and_rivlin_is_that_of_its_energy():
    """W = C10*(I1 - 3) + C01*(I2 - 3), differentiated numerically; G = 2*(C10 + C01)."""
    ratio = 0.7
    found, _ = stress("mooney_rivlin", "uniaxial", c01_ratio=ratio)

    def energy(lam):
        first, second = lam**2 + 2 / lam - 3, 2 * lam + lam**-2.0 - 3
        return (first + ratio * second) / (2 * (1 + ratio))

    slope = (energy(STRETCH + 1e-5) - energy(STRETCH - 1e-5)) / 2e-5
    assert found == pytest.approx(slope, rel=1e-6, abs=1e-9)


def test_gent_locks_without_a_pole():
    locked = effect("gent_stiffening", jm=2.0)
    strain = Strain(np.linspace(1.0, 4.0, 500))
    found = locked.stress(strain.elastic_term, strain, SHAPE, {}, 0.0)
    assert np.all(np.diff(found) > 0)
    assert np.isfinite(found).all()


def test_a_slack_strip_bears_nothing_until_it_is_taut():
    reading = np.array([0.9, 1.0, 1.02, 1.04, 1.5])
    slack = effect("stretch_offset", offset=0.04).imposed_stretch(reading)
    assert slack == pytest.approx([0.9, 1.0, 1.0, 1.0, 1.46])
    taut = effect("stretch_offset", offset=-0.03).imposed_stretch(reading)
    assert taut == pytest.approx(reading + 0.03)


def test_mullins_softens_below_the_largest_stretch_and_keeps_it():
    memory = {}
    mullins = effect("mullins_softening", softening=0.3, stretch_scale=0.2)
    for stretch in (1.5, 1.2):
        strain = Strain(np.array([stretch]))
        mullins.remember(strain.elastic_term, strain, SHAPE, memory, 0.1)
    assert memory["largest_stretch"].tolist() == [1.5]
    strain = Strain(STRETCH)
    found = mullins.stress(np.ones(4), strain, SHAPE, memory, 0.1)
    lost = 0.3 * (1 - np.exp(-np.maximum(1.5 - STRETCH, 0.0) / 0.2))
    assert found == pytest.approx(1 - lost)


def test_viscoelastic_stress_is_exact_for_a_ramp_and_jumps_at_once():
    """nu' = -nu/tau + g*Q' under Q = r*t: nu = g*r*tau*(1 - exp(-t/tau)); a jump leaves g*Q."""
    g, tau, rate = 0.4, 0.7, 0.5
    solid = effect("viscoelasticity", relative_modulus=g, relaxation_time=tau)
    memory, strain = {}, Strain(np.ones(1))
    assert solid.stress(np.array([2.0]), strain, SHAPE, {}, 0.0)[0] == pytest.approx(2.0 * (1 + g))
    times = np.cumsum([0.1, 0.5, 2.0])
    for time, step in zip(times, np.diff(times, prepend=0.0), strict=True):
        stress_now = np.array([rate * time])
        found = solid.stress(stress_now, strain, SHAPE, memory, step) - stress_now
        solid.remember(stress_now, strain, SHAPE, memory, step)
        assert found[0] == pytest.approx(g * rate * tau * (1 - np.exp(-time / tau)))


def test_hysteresis_does_not_depend_on_steps_and_turns_with_the_motion():
    """dw = (sign - w)*|dlam|/scale, integrated: up 1 -> 1.3, then down to 1.2."""
    rubbing = effect("hysteresis", relative_pressure=0.1, stretch_scale=0.05)

    def friction(path):
        memory = {}
        for stretch in path:
            strain = Strain(np.array([stretch]))
            found = rubbing.stress(np.zeros(1), strain, SHAPE, memory, 0.1)
            rubbing.remember(np.zeros(1), strain, SHAPE, memory, 0.1)
        return found[0]

    up = 1 - np.exp(-6.0)
    down = -1 + (up + 1) * np.exp(-2.0)
    assert friction([1.3, 1.2]) == pytest.approx(0.1 * down)
    fine = [*np.linspace(1.0, 1.3, 40), *np.linspace(1.3, 1.2, 17)]
    assert friction(fine) == pytest.approx(0.1 * down)
    assert friction([1.3, 1.3, 1.3]) == pytest.approx(0.1 * up)


def test_side_walls_integrated_balance_the_unreduced_pressure():
    """p*h/(2*G*d) = q + term, both sides times ratio/2."""
    found = effect("side_wall_integral").wall_stress(
        Strain(STRETCH).elastic_term, Strain(STRETCH), SHAPE
    )
    term = side_wall_term((STRETCH - 1) / 0.02, 0.02, 0.018, 0.004, 0.003)
    expected = SHAPE.ratio / 2 * (Strain(STRETCH).elastic_term + term)
    assert found == pytest.approx(expected)


def test_printed_nonlinearity_with_the_numbers_of_the_thesis():
    pressure = 30e3
    p0 = 0.9 * 8 * 67e3 * 0.004 / 0.02
    found = effect("actuation_nonlinearity", a=4.0, p0=p0).act_on_curvature(
        np.zeros(1), np.array([pressure]), SHAPE
    )
    u = pressure * 0.02 / (8 * 67e3 * 0.004)
    shape_of_it = 0.5 + u / np.sqrt(u**2 / 3 + 3 * 0.81)
    assert found == pytest.approx(pressure / (8 * 67e3 * 0.004) * SHAPE.ratio * shape_of_it)


def test_slack_layer_is_softer_where_it_is_pushed_straight():
    slack = effect("passive_layer_slack", ratio=0.4)
    assert slack.stiffness_factor(np.array([0.1, 0.5]), np.array([0.3, 0.3])).tolist() == [0.4, 1.0]


def test_friction_holds_against_what_changes_and_rests_with_it():
    friction, memory = effect("tip_friction", coefficient=0.2), {}
    forces = [0.0, 1.0, 2.0, 2.0, 2.0 + 1e-12, 1.5]
    found = [float(friction.tip_force(np.array(f), memory, 0.1)) for f in forces]
    assert found == pytest.approx([0.0, 0.8, 1.6, 2.0, 2.0, 1.8])


def test_gauge_yields_and_offsets_add():
    assert effect("gauge_compliance", stiffness=200.0).tip_compliance() == pytest.approx(0.005)
    assert effect("force_offset", offset=0.1).reading(2.0, {}, 0.0) == pytest.approx(2.1)
    staged = StagedEffects(
        [effect("angle_offset", offset=0.1), effect("angle_sensor_lag", time_constant=1.0)]
    )
    staged.reading("tip_angle", np.array(0.0), 0.0)
    shown = staged.reading("tip_angle", np.array(1.0), 1.0)
    assert float(shown) == pytest.approx(np.exp(-1) + 0.1)
    assert float(staged.reading("tip_force", np.array(1.0), 1.0)) == 1.0


def test_parameters_that_let_the_elastic_side_fall_are_told():
    shape = SectionShape(*(np.full((1, 1, 1), value) for value in (0.02, 0.02, 0.005, 0.005, 1, 1)))
    gains = EFFECTS["thick_wall"].in_lanes({"gain": [2.0, 11.9, 12.1, 40.0]})
    assert grows([gains], shape).tolist() == [True, True, False, False]
    assert grows([effect("gent_stiffening", jm=1.0)], shape).tolist() == [True]
    falling = EFFECTS["yeoh_stiffening"].in_lanes({"c2": [0.1, -0.05]})
    assert grows([falling], shape).tolist() == [True, False]
