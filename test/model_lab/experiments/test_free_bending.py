"""Free bending of specimens: each effect in its place, against independent integration."""

import numpy as np
import pytest
from lab_sets import SIZE, bending, measured, run, specimen
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from model_lab.experiments.forward import Forward
from softhand_model.effects import effect_classes
from softhand_model.hand import section

EFFECTS = effect_classes()
BETWEEN_SAMPLES = 0.03  # [s] of a delay: a pressure between two samples is a smooth function
SIDES = (SIZE["height"], SIZE["width"], SIZE["wall"], SIZE["side_wall"])
RATIO = float(section.side_wall_ratio(*SIDES))
PRESSURE = np.linspace(0.0, 50e3, 40)
TIME = np.linspace(0.0, 4.0, 40)


def load(pressure, modulus=67e3):
    return pressure * RATIO * 0.02 / (4 * modulus * 0.0025)


def angles(data, name=None, **values):
    effects = [EFFECTS[name](**values)] if name else []
    forward = Forward(data, fixed=effects, free_calibration=False)
    return forward.predict(np.zeros((1, 0)))[0]


def tip(stretch):
    return (stretch - 1) / 0.02 * 0.09


def test_base_is_the_exact_free_curvature():
    kappa = section.free_curvature(PRESSURE, *SIDES, 67e3)
    assert angles(bending(PRESSURE)) == pytest.approx(0.09 * kappa, rel=1e-10, abs=1e-12)


def test_suction_bends_backwards():
    found = angles(bending(np.array([-10e3])))
    exact = brentq(lambda lam: lam - lam**-3 - load(-10e3), 0.1, 1.0)
    assert found[0] == pytest.approx(tip(exact), rel=1e-9)


def test_modulus_scale_of_a_batch_divides_the_load():
    runs = [run("a", pressure=PRESSURE), run("b", of="other", pressure=PRESSURE)]
    data = measured("free_bending", runs, specimen(), specimen("other", batch="B"))
    both = Forward(data).predict(np.array([[1.1, 0.9]]))[0]
    assert both[:40] == pytest.approx(angles(bending(PRESSURE / 1.1)), rel=1e-9, abs=1e-12)
    assert both[40:] == pytest.approx(angles(bending(PRESSURE / 0.9)), rel=1e-9, abs=1e-12)


def test_temperature_of_the_run_counts():
    warm = bending(PRESSURE, temperature=303.15)
    found = angles(warm, "temperature_modulus", coefficient=0.01)
    assert found == pytest.approx(angles(bending(PRESSURE / 1.1)), rel=1e-9, abs=1e-12)


def test_profile_along_the_finger_is_integrated():
    profile = np.array([[0.0, 0.02], [0.03, 0.018], [0.09, 0.008]])
    data = measured("free_bending", [run("r", pressure=PRESSURE)], specimen(height=profile))
    x = (np.arange(20000) + 0.5) * 0.09 / 20000
    height = np.interp(x, *profile.T)
    kappa = section.free_curvature(PRESSURE[:, None], height, 0.02, 0.0025, 0.0025, 67e3)
    assert angles(data) == pytest.approx(kappa.mean(axis=1) * 0.09, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", ["gent_stiffening", "thick_wall", "side_wall_integral"])
def test_elastic_side_is_balanced(name):
    values = {"gent_stiffening": {"jm": 4.0}, "thick_wall": {"gain": 5.0}}.get(name, {})

    def side(lam):
        q, invariant = lam - lam**-3, lam**2 + lam**-2 - 2
        if name == "gent_stiffening":
            return q / (1 - invariant / 4.0)
        if name == "thick_wall":
            return q * (1 + 5 * 0.25**2 * np.exp(-(lam - 1) / 0.25))
        walls = section.side_wall_term((lam - 1) / 0.02, *SIDES)
        return RATIO / 2 * (q + float(walls))

    highest = 2.4 if name == "gent_stiffening" else 9.0
    exact = [brentq(lambda lam, p=p: side(lam) - load(p), 1.0, highest) for p in PRESSURE]
    found = angles(bending(PRESSURE), name, **values)
    assert found == pytest.approx(tip(np.array(exact)), rel=1e-8, abs=1e-10)


def test_viscoelastic_finger_follows_its_differential_equation():
    """q(lam) + nu = s(t), nu' = -nu/tau + g*q'(lam)*lam': one equation for lam."""
    g, tau, rate = 0.5, 0.8, load(12.5e3)

    def slope(time, state):
        lam = state[0]
        over = rate * time - (lam - lam**-3)
        return [(rate + over / tau) / ((1 + g) * (1 + 3 * lam**-4))]

    exact = solve_ivp(slope, (0, 4), [1.0], "DOP853", TIME, rtol=1e-11, atol=1e-12).y[0]
    fine = np.linspace(0.0, 4.0, 39 * 64 + 1)
    values = {"relative_modulus": g, "relaxation_time": tau}
    found = angles(bending(12.5e3 * fine, time=fine), "viscoelasticity", **values)
    assert found[::64] == pytest.approx(tip(exact), rel=1e-6, abs=1e-9)
    coarse = angles(bending(12.5e3 * TIME, time=TIME), "viscoelasticity", **values)
    assert coarse == pytest.approx(tip(exact), rel=2e-3, abs=1e-9)


def test_tube_lag_delays_the_pressure():
    """Chamber pressure of a ramp: r*(t - tau*(1 - exp(-t/tau)))."""
    rate, tau = 12.5e3, 0.5
    chamber = rate * (TIME - tau * (1 - np.exp(-TIME / tau)))
    found = angles(bending(rate * TIME, time=TIME), "tube_lag", time_constant=tau)
    assert found == pytest.approx(angles(bending(chamber)), rel=1e-9, abs=1e-11)


def test_sensor_lags_behind_the_angle():
    true = angles(bending(12.5e3 * TIME))
    found = angles(bending(12.5e3 * TIME, time=TIME), "angle_sensor_lag", time_constant=0.5)

    def slope(time, state):
        return [(np.interp(time, TIME, true) - state[0]) / 0.5]

    exact = solve_ivp(slope, (0, 4), [0.0], "RK45", TIME, rtol=1e-9, atol=1e-10, max_step=0.02)
    assert found == pytest.approx(exact.y[0], abs=1e-6)


def test_hysteresis_follows_the_motion_up_and_down():
    up_and_down = 45e3 * np.sin(np.linspace(0.0, 3.0, 60))
    values = {"relative_pressure": 0.2, "stretch_scale": 0.05}
    data = bending(up_and_down, time=np.arange(60))
    found = angles(data, "hysteresis", **values)
    lam, rubbing = 1.0, 0.0
    exact = []
    for pressure in up_and_down:

        def turned(new, lam=lam, rubbing=rubbing):
            sign = np.sign(new - lam)
            return sign + (rubbing - sign) * np.exp(-abs(new - lam) / 0.05)

        new = brentq(
            lambda x, p=pressure, w=turned: x - x**-3 + 0.2 * w(x) - load(p), 0.5, 4.0, xtol=1e-13
        )
        lam, rubbing = new, turned(new)
        exact.append(new)
    assert found == pytest.approx(tip(np.array(exact)), rel=1e-7, abs=1e-8)


def test_largest_stretch_carries_over_in_the_order_of_runs():
    time = np.arange(40)
    values = {"softening": 0.3, "stretch_scale": 0.2}
    small, large = 0.5 * PRESSURE, PRESSURE
    data = bending(small, large, small, time=time)
    first, second, third = angles(data, "mullins_softening", **values).reshape(3, 40)
    base = angles(bending(small))
    assert first == pytest.approx(base, rel=1e-9, abs=1e-11)
    beyond = large > small.max()
    assert second[beyond] == pytest.approx(angles(bending(large))[beyond], rel=1e-9)
    highest = 1 + second[-1] / 0.09 * 0.02

    def side(lam):
        return (lam - lam**-3) * (1 - 0.3 * (1 - np.exp(-(highest - lam) / 0.2)))

    exact = [brentq(lambda lam, p=p: side(lam) - load(p), 1.0, highest) for p in small]
    assert third == pytest.approx(tip(np.array(exact)), rel=1e-8, abs=1e-9)
    renewed = measured(
        "free_bending",
        [
            run("r0", time, pressure=large),
            run("r1", time, pressure=small, virgin=True),
            run("r2", time, of="twin", pressure=small),
        ],
        specimen(),
        specimen("twin"),
    )
    found = angles(renewed, "mullins_softening", **values).reshape(3, 40)
    assert found[1] == pytest.approx(base, rel=1e-9, abs=1e-11)
    assert found[2] == pytest.approx(base, rel=1e-9, abs=1e-11)


def test_largest_stretch_of_a_creeping_finger_carries_over():
    """Viscous rubber stays below the peak of slow loading: what carries over is the true one."""
    time = np.arange(40) * 0.02
    effects = [
        EFFECTS["mullins_softening"](softening=0.3, stretch_scale=0.2),
        EFFECTS["viscoelasticity"](relative_modulus=0.5, relaxation_time=2.0),
    ]

    def predicted(*pressures):
        data = bending(*pressures, time=time)
        forward = Forward(data, fixed=effects, free_calibration=False)
        return forward.predict(np.zeros((1, 0)))[0].reshape(-1, 40)

    together = predicted(PRESSURE, 0.6 * PRESSURE)
    highest = 1 + together[0].max() / 0.09 * 0.02
    slow = 1 + angles(bending(PRESSURE)).max() / 0.09 * 0.02
    assert highest < slow - 0.05
    lam = 1 + together[1] / 0.09 * 0.02
    q = (lam - lam**-3) * (1 - 0.3 * (1 - np.exp(-(highest - lam) / 0.2)))
    over = np.diff(q, prepend=0.0)
    left, share = np.exp(-0.02 / 2.0), (1 - np.exp(-0.02 / 2.0)) / (0.02 / 2.0)
    nu = np.zeros(40)
    for tick in range(1, 40):
        nu[tick] = left * nu[tick - 1] + 0.5 * share * over[tick]
    assert q + nu == pytest.approx(load(0.6 * PRESSURE), abs=1e-7)


def test_steady_run_starts_where_it_has_been_for_long():
    constant = np.full(30, 30e3)
    values = {"relative_modulus": 0.5, "relaxation_time": 3.0}
    steady = bending(constant, time=np.arange(30) * 0.1, steady=True)
    rest = angles(bending(constant))
    found = angles(steady, "viscoelasticity", **values)
    assert found == pytest.approx(rest, rel=1e-8)
    suddenly = angles(bending(constant, time=np.arange(30) * 0.1), "viscoelasticity", **values)
    at_once = brentq(lambda lam: 1.5 * (lam - lam**-3) - load(30e3), 1.0, 4.0)
    assert suddenly[0] == pytest.approx(tip(at_once), rel=1e-8)


def test_runs_of_different_length_do_not_disturb_each_other():
    short, long = PRESSURE[:12], PRESSURE
    values = {"relative_modulus": 0.5, "relaxation_time": 3.0}
    data = measured(
        "free_bending",
        [run("a", TIME[:12], pressure=short), run("b", TIME, pressure=long)],
    )
    together = angles(data, "viscoelasticity", **values)
    alone = angles(bending(long, time=TIME), "viscoelasticity", **values)
    assert together[12:] == pytest.approx(alone, rel=1e-9, abs=1e-10)
    assert together[:12] == pytest.approx(alone[:12], rel=1e-9, abs=1e-10)


SIGN_OF_WEIGHT = {
    "base_up": -1,
    "base_down": 1,
    "bending_plane_level": 0,
    "level_curling_up": -1,
    "level_curling_down": 1,
}


@pytest.mark.parametrize("mount", SIGN_OF_WEIGHT)
def test_weight_acts_by_the_mount(mount):
    data = measured(
        "free_bending", [run("r", TIME, pressure=PRESSURE)], specimen(mount=mount, mass=0.07)
    )
    free, weighted = angles(bending(PRESSURE)), angles(data, "gravity", mass_scale=1.0)
    assert np.sign(weighted - free)[5:25].tolist() == [SIGN_OF_WEIGHT[mount]] * 20
    with_memory = Forward(
        data,
        fixed=[
            EFFECTS["gravity"](mass_scale=1.0),
            EFFECTS["hysteresis"](relative_pressure=0.0, stretch_scale=0.1),
        ],
        free_calibration=False,
    ).predict(np.zeros((1, 0)))[0]
    assert with_memory == pytest.approx(weighted, rel=1e-8, abs=1e-9)


def test_gravity_needs_the_mass():
    lacking = specimen(mount="base_up")
    values = {key: value for key, value in lacking.values.items() if key != "mass"}
    lacking = type(lacking)("d2.5", values, "base_up")
    data = measured("free_bending", [run("r", pressure=PRESSURE)], lacking)
    with pytest.raises(ValueError, match="specimens.d2.5: expected the key mass"):
        angles(data, "gravity", mass_scale=1.0)


@pytest.mark.parametrize("mount", SIGN_OF_WEIGHT)
def test_a_load_at_the_tip_acts_by_the_mount_and_more_than_the_same_mass_of_the_finger(mount):
    values = {key: value for key, value in specimen().values.items() if key != "mass"}
    light = type(specimen())("d2.5", values, mount)  # whose own mass is not needed
    hung = measured("free_bending", [run("r", TIME, pressure=PRESSURE)], light)
    own = measured(
        "free_bending", [run("r", TIME, pressure=PRESSURE)], specimen(mount=mount, mass=0.02)
    )
    free = angles(bending(PRESSURE))
    at_tip = (angles(hung, "tip_load", mass=0.02) - free)[5:25]
    spread = (angles(own, "gravity", mass_scale=1.0) - free)[5:25]
    assert np.sign(at_tip).tolist() == [SIGN_OF_WEIGHT[mount]] * 20
    assert np.all(np.abs(at_tip) >= 1.5 * np.abs(spread))
    nothing = angles(hung, "tip_load", mass=0.0)
    assert nothing == pytest.approx(free, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "name", [name for name, one in EFFECTS.items() if "free_bending" in one.experiments]
)
def test_predictions_are_smooth_and_finite_over_the_typical_range(name):
    """Fourth differences over steps of 1e-4 are rounding, or the solver has ended too early."""
    time = np.linspace(0.0, 10.0, 60)
    pressure = 40e3 * np.abs(np.sin(0.7 * time))
    data = bending(pressure, 0.7 * pressure + 3e3, time=time, temperature=300.0)
    forward = Forward(data, effects=[EFFECTS[name]])
    middle = forward.start() + BETWEEN_SAMPLES * (name == "clock_offset")
    steps = np.arange(-2, 3)[:, None] * 1e-4
    low, high = np.array([p.typical for p in forward.parameters]).T
    lanes = middle + steps * (high - low)
    found = forward.predict(lanes)
    assert np.isfinite(found).all()
    rough = np.abs(np.diff(found, n=4, axis=0))
    kinks = rough.max(axis=0) > 1e-7
    assert kinks.mean() < 0.02
    assert np.isfinite(forward.predict(np.stack([low, high]))).all()


def test_a_wall_that_varies_along_the_finger_is_integrated():
    wall = np.array([[0.0, 0.0032], [0.03, 0.0022], [0.09, 0.0018]])
    runs, sizes = [run("r", pressure=PRESSURE)], {"wall": wall, "side_wall": wall}
    found = angles(measured("free_bending", runs, specimen(**sizes)))
    x = (np.arange(4000) + 0.5) * 0.09 / 4000
    thick = np.interp(x, *wall.T)
    kappa = section.free_curvature(PRESSURE[:, None], 0.02, 0.02, thick, thick, 67e3)
    assert found == pytest.approx(kappa.mean(axis=1) * 0.09, rel=1e-6, abs=1e-9)
