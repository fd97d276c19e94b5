"""Pressure and volume control on the bench: by few pulses, whatever the volumes do."""

import numpy as np
import pytest
from bottle_rig import GAS, SWELLING_PRESSURE, BottleRig, Swelling

from pneumaticbox_driver.box.commands import TrajectoryPoint
from softhand_model.gas import AMBIENT_PRESSURE

KPA, CM3, MG = 1e3, 1e-6, 1e-6
SETTLING = 2.5
BOTTLE = {"volume": 0.2e-3, "compliance": 0.0}
RIGID = {"volume": 30e-6, "compliance": 0.0}
FINGER = {"volume": 30e-6, "compliance": 0.8}  # nearly doubles at 40 kPa


def rig_for(mode, volume, compliance, believed=1.0, channels=2, **options):
    """A started rig; the box believes in volumes or a compliance `believed` times the true one."""
    scales = (1.0, believed) if compliance else (believed, 1.0)
    model = Swelling(volume * scales[0], compliance * scales[1], channels)
    return BottleRig(
        volume=volume,
        compliance=compliance,
        channels=channels,
        mode=mode,
        model=model,
        volume_model="hand",
        seed=3,
        **options,
    ).started()


def ask(rig, value):
    field = "effort" if rig.box.control.modes[0] == "pressure" else "positions"
    rig.openings[:] = 0
    point = TrajectoryPoint(0.0, **{field: [value] * len(rig.names)})
    rig.box.command(rig.names, [point], 0.0, rig.box.time)


def gauge(rig):
    return rig.plant.pressures - AMBIENT_PRESSURE


def pressure_pulse(rig):
    """What the smallest pulse does to the true pressures [Pa], free of load."""
    slope = rig.volume * rig.compliance / SWELLING_PRESSURE
    capacity = (rig.volumes() + rig.plant.pressures * slope) / GAS
    return rig.smallest_pulses() / capacity


def test_what_was_learnt_against_an_object_is_forgotten_when_it_lets_go():
    rig = rig_for("pressure", volume=30e-6, compliance=3.0)
    ask(rig, 20 * KPA)
    rig.run(4.0, 1e-2)
    rig.hold(0.9 * float(rig.volumes()[0]))  # held, it is as stiff as a bottle
    rig.run(3.0, 1e-2)
    rig.hold(None)
    rig.openings[:] = 0
    rig.run(4.0, 1e-2)
    assert (np.abs(gauge(rig) - 20 * KPA) < pressure_pulse(rig)).all()
    # as many as from free to free; with the stiffness of the held one it takes four
    assert (rig.openings >= 1).all() and (rig.openings <= 3).all()


@pytest.mark.parametrize("load", [BOTTLE, RIGID, FINGER], ids=["bottle", "rigid", "finger"])
def test_the_true_pressure_ends_within_the_smallest_pulse_by_few_pulses(load):
    rig = rig_for("pressure", **load)
    for target in (20 * KPA, 60 * KPA, 35 * KPA, 10 * KPA):
        ask(rig, target)
        rig.run(8.0 if load is BOTTLE else 5.0, 1e-2)
        assert (np.abs(gauge(rig) - target) < pressure_pulse(rig)).all()
        assert (rig.openings <= 4).all()


@pytest.mark.parametrize("believed", [0.4, 2.5])
@pytest.mark.parametrize("load", [RIGID, FINGER], ids=["rigid", "finger"])
def test_a_wrong_model_of_the_volume_costs_pulses_but_makes_no_chatter(load, believed):
    rig = rig_for("pressure", **load, believed=believed)
    for target in (20 * KPA, 60 * KPA, 35 * KPA, 10 * KPA):
        ask(rig, target)
        rig.run(6.0, 1e-2)
        assert (np.abs(gauge(rig) - target) < 2 * pressure_pulse(rig)).all()
        assert (rig.openings <= 6).all()
        rig.openings[:] = 0
        rig.run(1.0, 1e-2)
        assert not rig.openings.any()


def test_pressure_control_corrects_after_a_push_and_mass_control_does_not():
    rig = rig_for("pressure", **RIGID)
    ask(rig, 40 * KPA)
    rig.run(SETTLING, 4e-3)
    rig.box.set_modes(["pressure", "mass"])
    rig.openings[:] = 0
    mass = rig.mass.copy()
    rig.volume *= 0.8
    rig.run(SETTLING, 4e-3)
    assert abs(gauge(rig)[0] - 40 * KPA) < pressure_pulse(rig)[0]
    assert rig.mass[0] < mass[0] - 5 * MG
    assert gauge(rig)[1] > 65 * KPA
    assert rig.mass[1] == pytest.approx(mass[1], abs=1e-12)
    assert rig.openings[0] >= 1 and rig.openings[1] == 0


def test_a_sine_of_pressure_is_followed_within_a_few_pulses():
    rig = rig_for("pressure", **FINGER)
    start, times = rig.box.time, np.arange(0.1, 8.0, 0.1)
    points = [TrajectoryPoint(t, effort=[(30 - 20 * np.cos(t)) * KPA] * 2) for t in times]
    rig.box.command(rig.names, points, 0.0, start)
    rig.run(2.0, 4e-3)
    while rig.box.time < start + 7.5:
        rig.run(0.1)
        wanted = (30 - 20 * np.cos(rig.box.time - start)) * KPA
        assert (np.abs(gauge(rig) - wanted) < 3 * pressure_pulse(rig) + 2 * KPA).all()


def test_a_pressure_of_zero_empties_the_channel():
    rig = rig_for("pressure", **FINGER)
    ask(rig, 30 * KPA)
    rig.run(SETTLING, 4e-3)
    ask(rig, 0.0)
    rig.run(SETTLING, 4e-3)
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.05 * MG)
    assert rig.box.zeroing.empty.all() and not rig.box.valves.any()


# volume


def test_the_true_volume_ends_within_the_smallest_pulse_by_few_pulses():
    rig = rig_for("volume", **FINGER)
    for target in (15 * CM3, 35 * CM3, 20 * CM3, 8 * CM3):
        ask(rig, target)
        rig.run(SETTLING, 4e-3)
        slope = rig.volume * rig.compliance / SWELLING_PRESSURE
        assert (np.abs(rig.volumes() - rig.volume - target) < slope * pressure_pulse(rig)).all()
        assert (rig.openings <= 4).all()


def test_volume_control_corrects_after_a_push():
    rig = rig_for("volume", **FINGER)
    ask(rig, 20 * CM3)
    rig.run(SETTLING, 4e-3)
    rig.openings[:] = 0
    rig.volume *= 0.85  # squeezed: less volume at every pressure
    rig.run(2 * SETTLING, 4e-3)
    slope = rig.volume * rig.compliance / SWELLING_PRESSURE
    error = rig.volumes() - 30 * CM3 - 20 * CM3
    assert (np.abs(error) < 1.5 * slope * pressure_pulse(rig)).all()
    assert (rig.openings >= 1).all() and (rig.openings <= 5).all()


def test_the_estimated_volume_is_that_of_the_plant():
    rig = rig_for("volume", **FINGER)
    ask(rig, 25 * CM3)
    rig.run(SETTLING, 4e-3)
    np.testing.assert_allclose(rig.box.volume, rig.volumes() - rig.volume, rtol=0.04)


def test_the_volume_of_a_bottle_cannot_be_controlled():
    rig = BottleRig(channels=2).started()
    with pytest.raises(ValueError, match="'volume' expects volume_model 'hand', got 'fixed'"):
        rig.box.set_modes(["mass", "volume"])
