"""Regression of equation 4.1: exact on synthetic pulses, far better than the baseline."""

import numpy as np
import pytest

from pneumaticbox_driver.calibration.command import calibrate, main
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.calibration.regression import (
    Pulse,
    fit_pulses,
    regressors,
)
from pneumaticbox_driver.observer.coefficients import PulseCoefficients

KNOWN = PulseCoefficients(-2e-7, 3e-13, 1.2e-10, 2.5e-12, -1.9e-12)
VENTING = PulseCoefficients(1e-8, 2e-11, 9.8e-10, -1.2e-11)


def synthetic(coefficients, inflating, count=60, supplies=(361e3, 421e3), seed=0):
    """Pulses that obey equation 4.1 exactly."""
    random = np.random.default_rng(seed)
    pulses = []
    for _ in range(count):
        duration, channel = random.uniform(0.04, 1.0), random.uniform(105e3, 200e3)
        p_in = random.choice(supplies) if inflating else channel
        p_out = channel if inflating else 101.3e3
        friction = (p_in - p_out) * duration * random.uniform(0.9, 1.0)
        injector = p_in * random.uniform(0.2, 0.484) * duration
        columns = np.array([1.0, friction, injector, p_in, p_out])
        mass = float(columns @ coefficients.as_array())
        pulses.append(Pulse(inflating, duration, friction, injector, p_in, p_out, mass))
    return pulses


@pytest.mark.parametrize(("known", "inflating"), [(KNOWN, True), (VENTING, False)])
def test_known_coefficients_are_recovered_from_pulses_that_obey_them(known, inflating):
    fit = fit_pulses(synthetic(known, inflating))
    np.testing.assert_allclose(fit.as_array(), known.as_array(), rtol=1e-6, atol=1e-16)
    assert fit.residual < 1e-12


def test_deflation_leaves_out_the_ambient_column_which_is_collinear_with_the_bias():
    fit = fit_pulses(synthetic(VENTING, False))
    assert fit.switch_out == 0.0


def test_pulses_that_leave_terms_undetermined_are_refused_and_the_terms_named():
    pulses = synthetic(KNOWN, True, supplies=(400e3,))
    with pytest.raises(ValueError, match="do not separate bias from switch_in"):
        fit_pulses(pulses)


def test_too_few_or_mixed_pulses_are_refused():
    with pytest.raises(ValueError, match="pulses must be more than 5, got 4"):
        fit_pulses(synthetic(KNOWN, True, 4))
    with pytest.raises(ValueError, match="pulses must be of one direction, got 2"):
        fit_pulses(synthetic(KNOWN, True) + synthetic(VENTING, False))


@pytest.fixture(scope="module")
def fresh_pulses(bench_pulses):
    """Pulses that no calibration has seen, at another supply pressure (two channels)."""
    return bench_pulses(cycles=20, seed=77, channels=2, supply=290e3)


def test_on_the_bench_the_shipped_coefficients_beat_the_baseline_as_the_thesis_states(
    fresh_pulses,
):
    for channel, calibration in zip(fresh_pulses, load_calibration(None, 2), strict=True):
        pulses = [pulse for pulse in channel if not pulse.inflating]
        mass = np.array([pulse.mass for pulse in pulses])
        error = mass - regressors(pulses) @ calibration.deflate.as_array()
        # baseline of section 4.4.3: `c p_in dt`, c fitted over the same pulses
        product = np.array([pulse.pressure_in_abs * pulse.duration for pulse in pulses])
        naive = mass - product * (product @ mass) / (product @ product)
        assert np.sqrt(np.mean(error**2)) < 0.1e-6
        assert np.sqrt(np.mean(naive**2) / np.mean(error**2)) > 7


def test_on_the_bench_inflation_is_estimated_to_a_tenth_of_a_milligram(fresh_pulses):
    for channel, calibration in zip(fresh_pulses, load_calibration(None, 2), strict=True):
        pulses = [pulse for pulse in channel if pulse.inflating]
        mass = np.array([pulse.mass for pulse in pulses])
        error = mass - regressors(pulses) @ calibration.inflate.as_array()
        assert np.sqrt(np.mean(error**2)) < 0.1e-6 < np.max(mass) / 50


def test_a_shared_calibration_is_worse_than_the_channel_s_own(fresh_pulses):
    own, *others = load_calibration(None, 8)
    pulses = [pulse for pulse in fresh_pulses[0] if not pulse.inflating]
    mass, design = np.array([pulse.mass for pulse in pulses]), regressors(pulses)
    # what adds up from pulse to pulse
    own_error = np.abs(np.mean(mass - design @ own.deflate.as_array()))
    shared = [np.abs(np.mean(mass - design @ other.deflate.as_array())) for other in others]
    assert np.mean(shared) > 3 * own_error


def test_a_calibration_repeats_with_its_seed():
    short = {"points": 24, "seed": 5, "channels": 1, "leak_test": 0.0}
    assert calibrate(**short) == calibrate(**short)


def test_a_new_calibration_agrees_with_the_shipped_one(fresh_pulses):
    again = calibrate(points=80, seed=5, channels=1, leak_test=0.0)[0]
    for direction in (True, False):
        pulses = [pulse for pulse in fresh_pulses[0] if pulse.inflating == direction]
        shipped = load_calibration(None, 1)[0]
        name = "inflate" if direction else "deflate"
        design = regressors(pulses)
        expected = design @ getattr(shipped, name).as_array()
        np.testing.assert_allclose(
            design @ getattr(again, name).as_array(), expected, atol=0.15e-6, rtol=0.02
        )


def test_a_file_with_too_few_outlets_is_refused():
    with pytest.raises(ValueError, match="outlets: expected outlet 9, got 1, 2, 3"):
        load_calibration(None, 9)


def test_the_command_does_not_overwrite_unasked(tmp_path, capsys):
    path = tmp_path / "box.yaml"
    path.write_text("mine")
    assert main(["--output", str(path)]) == 2
    assert "exists; --force overwrites it" in capsys.readouterr().err
    assert path.read_text() == "mine"
