"""Drift and its correction on actuators that follow the pressure; leaks and their model."""

from dataclasses import replace

import numpy as np
import pytest

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.observer.coefficients import Leak
from pneumaticbox_driver.observer.drift import PostureMass, combine
from pneumaticbox_driver.observer.volume_model import FixedVolumes
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.chain.volumes import FreeActuators, FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import load_hand
from softhand_model.pneumatics import load_pneumatics
from softhand_model.pneumatics.parameters import Leak as TrueLeak

MG = 1e-6
HAND = load_hand("rbo_hand_2")
CHANNELS = len(HAND.channels)
OFFSET = 0.014 * 250e3 * np.array([1, -1, 1, -1, 0])  # of the sensors, 1.4 % of full scale [Pa]
PERIOD = 8e-3


class Swollen(FreeActuators):
    """A hand whose volumes grow by a share more than the box believes."""

    growth = 1.02

    def volumes(self, pressures_abs):
        rest = FreeVolumes.volumes(self._free, np.zeros(CHANNELS))
        return rest + self.growth * (super().volumes(pressures_abs) - rest)


class HandRig:
    """The box on the hand's actuators in free posture, past its start; one tare, at the start."""

    def __init__(self, chambers=None, calibrations=None, parameters=None, seed=3):
        free = FreeVolumes(HAND)
        self.bench = EmbeddedRig(
            HAND.channels, chambers or FreeActuators(HAND), parameters, seed=seed
        )
        settings = BoxSettings(
            HAND.channels,
            tuple(free.rest),
            tuple(1.5 * HAND.max_pressures()),
            ("mass",) * CHANNELS,
            volume_model="hand",
            hand="rbo_hand_2",
        )
        self.box = PneumaticBox(settings, calibrations or load_calibration(None, CHANNELS))
        top = 0.6 * HAND.max_pressures()
        filled = air_mass(top + AMBIENT_PRESSURE, free.volumes(top))
        self.full = filled - air_mass(AMBIENT_PRESSURE, free.rest)
        self.run(1.2)

    def run(self, duration):
        end = self.bench.time + duration
        while self.bench.time < end - 1e-9:
            readings = self.bench.advance(PERIOD) + OFFSET
            self.bench.command(self.box.on_sample(self.bench.time, readings))

    def follow(self, duration):
        """A sine between a tenth and nine tenths of `full` on all channels, period 6 s."""
        times = np.arange(0.1, duration, 0.1)
        shares = 0.5 - 0.4 * np.cos(2 * np.pi * times / 6.0)
        points = [
            TrajectoryPoint(t, share * self.full) for t, share in zip(times, shares, strict=True)
        ]
        self.box.command(HAND.channels, points, 0.0, self.box.time)
        self.run(duration + 1.0)

    @property
    def error(self):
        return np.abs(self.bench.mass - self.box.observer.mass)


def test_after_a_minute_of_motion_the_corrected_mass_is_right_within_a_milligram():
    rig = HandRig()
    rig.box.zeroing.drift_correction = True
    rig.follow(60.0)
    assert rig.box.openings.min() > 100
    assert rig.error.max() < 0.3 * MG
    assert (rig.error < 1.5 * rig.box.zeroing.drift_bound).all()
    assert not rig.box.latch


def test_without_correction_the_same_motion_drifts_more():
    rig = HandRig()
    rig.follow(20.0)
    assert rig.error.max() > 0.5 * MG


def test_volumes_that_grow_a_little_more_than_believed_cost_little():
    rig = HandRig(Swollen(HAND))
    rig.box.zeroing.drift_correction = True
    rig.follow(20.0)
    assert (rig.error < 0.03 * rig.full).all()


def test_a_hand_that_is_pushed_is_not_taken_for_free():
    chambers = FreeActuators(HAND)
    rig = HandRig(chambers)
    rig.box.zeroing.drift_correction = True
    rig.box.command(HAND.channels, [TrajectoryPoint(0.0, 0.7 * rig.full)], 0.0, rig.box.time)
    rig.run(6.0)
    assert rig.error.max() < 0.5 * MG
    chambers.set_load(0.5 * HAND.max_pressures())
    mass = rig.bench.mass.copy()
    rig.run(3.0)
    assert rig.error.max() < 0.5 * MG
    np.testing.assert_allclose(rig.bench.mass, mass, atol=1e-3 * MG)


def test_a_correction_moves_the_estimate_and_not_the_setpoint():
    rig = HandRig()
    rig.box.command(HAND.channels, [TrajectoryPoint(0.0, 0.6 * rig.full)], 0.0, rig.box.time)
    rig.run(6.0)
    before = rig.box.commands.setpoints.at(rig.box.time).copy()
    rig.box.zeroing.drift_correction = True
    rig.run(2.0)
    np.testing.assert_array_equal(rig.box.commands.setpoints.at(rig.box.time), before)


def test_a_tare_under_pressure_uses_the_volume_of_the_bent_hand():
    rig = HandRig()
    rig.box.command(HAND.channels, [TrajectoryPoint(0.0, 0.6 * rig.full)], 0.0, rig.box.time)
    rig.run(6.0)
    for channel in range(CHANNELS):
        rig.box.observer.set_mass(channel, 0.0)
    rig.box.enable(False)
    rig.run(0.5)
    rig.box.tare()
    np.testing.assert_allclose(rig.box.observer.mass, rig.bench.mass, rtol=0.03)


# leaks


def leaking(conductance, known):
    parameters = replace(load_pneumatics(), leak=TrueLeak((conductance, conductance)))
    calibrations = [
        replace(each, leak=Leak(known, 0.0)) for each in load_calibration(None, CHANNELS)
    ]
    rig = HandRig(parameters=parameters, calibrations=calibrations)
    rig.box.command(HAND.channels, [TrajectoryPoint(0.0, 0.7 * rig.full)], 0.0, rig.box.time)
    rig.run(4.0)
    return rig


def test_a_leak_is_held_with_the_leak_model_and_not_without():
    conductance = 8e-12  # a milligram in four seconds at 30 kPa [kg/(s Pa)]
    errors = {}
    for model in (False, True):
        rig = leaking(conductance, conductance)
        rig.box.observer.leak_model = model
        before = rig.bench.mass - rig.box.observer.mass
        rig.run(12.0)
        errors[model] = np.abs(rig.bench.mass - rig.box.observer.mass - before)
    assert errors[False].min() > 1.0 * MG
    assert (errors[True] < 0.25 * errors[False] + 0.3 * MG).all()


# weighing


def test_equal_uncertainty_is_no_reason_to_change_and_a_wide_gap_neither():
    one = np.ones(3)
    mass, variance, used, far = combine(
        0 * one, np.array([1.0, 4.0, 4.0]), np.array([1.0, 1.0, 50.0]), one
    )
    assert used.tolist() == [False, True, False]
    assert far.tolist() == [False, False, True]
    assert mass.tolist() == pytest.approx([0.0, 0.8, 0.0])
    assert variance.tolist() == pytest.approx([1.0, 0.8, 4.0])


def test_in_a_bottle_the_mass_is_that_of_the_gas_law():
    settings = BoxSettings(("a",), (1e-4,), (1e5,), ("mass",))
    mass, variance = PostureMass(settings, FixedVolumes((1e-4,))).at(np.array([131.3e3]))
    assert mass[0] == pytest.approx(float(air_mass(30e3, 1e-4)))
    assert np.sqrt(variance[0]) == pytest.approx(float(air_mass(91.2, 1e-4)), rel=0.01)
