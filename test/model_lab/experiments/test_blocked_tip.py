"""Forces of a blocked tip in a measurement set; the balance itself has tests in softhand_model."""

import numpy as np
import pytest
from lab_sets import SIZE, measured, run, specimen

from model_lab.experiments.forward import Forward
from softhand_model.effects import effect_classes
from softhand_model.hand import section

EFFECTS = effect_classes()
BETWEEN_SAMPLES = 0.03  # [s] of a delay: a pressure between two samples is a smooth function
SIDES = (SIZE["height"], SIZE["width"], SIZE["wall"], SIZE["side_wall"])
PRESSURE = np.linspace(0.0, 60e3, 40)
TIME = np.linspace(0.0, 4.0, 40)


def blocked(*pressures, time=TIME, **sizes):
    runs = [run(f"r{index}", time, pressure=p) for index, p in enumerate(pressures)]
    return measured("blocked_tip", runs, specimen(**sizes))


def forces(data, *effects, springs="exact"):
    forward = Forward(data, fixed=effects, free_calibration=False, springs=springs)
    return forward.predict(np.zeros((1, 0)))[0]


def test_force_is_that_of_a_straight_finger_at_small_pressure():
    """F = 1.5*M/L with M = h**2*z*p/2, whatever G, wall and side walls are."""
    small = np.array([5.0, 10.0])
    for sizes in ({}, {"wall": 0.005}, {"shear_modulus": 30e3}, {"side_wall": 0.001}):
        found = forces(blocked(small, time=np.arange(2), **sizes))
        assert found == pytest.approx(1.5 * 0.02**3 * small / 2 / 0.09, rel=1e-3)


def test_shear_modulus_barely_shows():
    soft, stiff = (
        Forward(blocked(PRESSURE)).predict(np.array([[scale]]))[0] for scale in (0.9, 1.1)
    )
    change = np.abs(stiff[1:] / soft[1:] - 1)
    assert change.max() < 0.03
    assert change[:10].max() < 0.01


def test_moment_profile_of_the_balance_holds_along_a_tapered_finger():
    """At the force found the deflection of the tip vanishes, with curvatures from 3.4.3."""
    profile = np.array([[0.0, 0.02], [0.09, 0.012]])
    found = forces(blocked(PRESSURE, height=profile))[-1]
    x = (np.arange(4000) + 0.5) * 0.09 / 4000
    height = np.interp(x, *profile.T)
    moment = found * (0.09 - x)
    low, high = np.full(4000, -0.5) / height, np.full(4000, 8.0) / height
    for _ in range(60):
        middle = (low + high) / 2
        carried = section.bending_moment(60e3, middle, height, 0.02, 0.0025, 0.0025, 67e3)
        low, high = (
            np.where(carried > moment, middle, low),
            np.where(carried > moment, high, middle),
        )
    assert np.sum(middle * (0.09 - x)) * 0.09 / 4000 == pytest.approx(0.0, abs=1e-6)


def test_linear_springs_follow_the_free_curvature():
    """B = 2*G*d*(c/4)**3 and F = 1.5*B*kappa/L."""
    free = section.free_curvature(PRESSURE, *SIDES, 67e3)
    bending = 2 * 67e3 * 0.0025 * 0.02**3
    found = forces(blocked(PRESSURE), springs="linear")
    assert found == pytest.approx(1.5 * bending * free / 0.09, rel=1e-9, abs=1e-12)
    around = forces(blocked(PRESSURE, circumference=0.1), springs="linear")
    assert around == pytest.approx(found * (0.025 / 0.02) ** 3, rel=1e-9, abs=1e-12)
    with pytest.raises(ValueError, match="springs: expected one of exact, linear, got quartic"):
        forces(blocked(PRESSURE), springs="quartic")


def test_slack_layer_scales_the_force():
    slack = EFFECTS["passive_layer_slack"](ratio=0.5)
    for springs in ("exact", "linear"):
        whole = forces(blocked(PRESSURE), springs=springs)
        found = forces(blocked(PRESSURE), slack, springs=springs)
        assert found == pytest.approx(0.5 * whole, rel=1e-8, abs=1e-12)


def test_a_finger_that_bulges_pushes_more_and_depends_on_its_modulus():
    bulges, data = EFFECTS["finite_rotation"](), blocked(PRESSURE)
    gain = forces(data, bulges)[1:] / forces(data)[1:]
    assert gain[0] == pytest.approx(1.0, abs=1e-4)
    assert (np.diff(gain) > 0.0).all()
    soft = blocked(PRESSURE, shear_modulus=50e3)
    assert (forces(soft, bulges)[-1] / forces(soft)[-1]) > gain[-1] > 1.03


def test_friction_parts_loading_from_unloading():
    up_and_down = np.concatenate([PRESSURE, PRESSURE[::-1]])
    data = blocked(up_and_down, time=np.arange(80))
    found = forces(data, EFFECTS["tip_friction"](coefficient=0.2)).reshape(2, 40)
    base = forces(data).reshape(2, 40)
    assert found[0, 1:] == pytest.approx(0.8 * base[0, 1:])
    assert found[1, 0] == pytest.approx(base[1, 0])
    assert found[1, 1:] == pytest.approx(1.2 * base[1, 1:])


def test_gauge_reads_its_offset_behind_friction():
    effects = [
        EFFECTS["tip_friction"](coefficient=0.2),
        EFFECTS["force_offset"](offset=0.3),
        EFFECTS["gauge_compliance"](stiffness=1e7),
    ]
    expected = 0.8 * forces(blocked(PRESSURE)) + 0.3
    assert forces(blocked(PRESSURE), *effects) == pytest.approx(expected, rel=1e-5)


def test_viscous_rubber_barely_shows_and_fades():
    """G and what acts like it barely show in the force; after a while the rubber has relaxed."""
    held = np.concatenate([PRESSURE, np.full(200, 60e3)])
    data = blocked(held, time=np.arange(240) * 0.1)
    solid = EFFECTS["viscoelasticity"](relative_modulus=0.5, relaxation_time=1.0)
    found, base = forces(data, solid), forces(data)
    assert found[-1] == pytest.approx(base[-1], rel=1e-5)
    assert 1e-3 < np.abs(found - base).max() / base.max() < 0.05


@pytest.mark.parametrize(
    "name", [name for name, one in EFFECTS.items() if "blocked_tip" in one.experiments]
)
def test_predictions_are_smooth_and_finite_over_the_typical_range(name):
    time = np.linspace(0.0, 10.0, 60)
    pressure = 50e3 * np.abs(np.sin(0.7 * time))
    forward = Forward(blocked(pressure, 0.7 * pressure + 3e3, time=time), effects=[EFFECTS[name]])
    low, high = np.array([p.typical for p in forward.parameters]).T
    middle = forward.start() + BETWEEN_SAMPLES * (name == "clock_offset")
    lanes = middle + np.arange(-2, 3)[:, None] * 1e-4 * (high - low)
    found = forward.predict(lanes)
    assert np.isfinite(found).all()
    assert (np.abs(np.diff(found, n=4, axis=0)).max(axis=0) > 1e-7).mean() < 0.02
    assert np.isfinite(forward.predict(np.stack([low, high]))).all()


def test_a_wall_that_varies_along_the_finger_counts_in_the_balance():
    wall = np.array([[0.0, 0.0035], [0.09, 0.0015]])
    found = forces(blocked(PRESSURE, wall=wall, side_wall=wall))[-1]
    x = (np.arange(4000) + 0.5) * 0.09 / 4000
    thick, moment = np.interp(x, *wall.T), found * (0.09 - x)
    low, high = np.full(4000, -25.0), np.full(4000, 400.0)
    for _ in range(60):
        middle = (low + high) / 2
        carried = section.bending_moment(60e3, middle, 0.02, 0.02, thick, thick, 67e3)
        low, high = (
            np.where(carried > moment, middle, low),
            np.where(carried > moment, high, middle),
        )
    assert np.sum(middle * (0.09 - x)) * 0.09 / 4000 == pytest.approx(0.0, abs=1e-6)
