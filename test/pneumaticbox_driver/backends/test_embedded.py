"""The bench in process: bottles, or a hand that follows its pressure and is pushed."""

import numpy as np
import pytest

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from softhand_model.chain.volumes import Bottles, FreeActuators
from softhand_model.hand.hand import load_hand
from softhand_model.pneumatics import load_pneumatics

HAND = load_hand("rbo_hand_2")


def run(bench, duration, valves, dt=2e-3):
    pressures = []
    for _ in range(round(duration / dt)):
        bench.command(valves)
        bench.advance(dt)
        pressures.append(bench.plant.pressures)
    return np.array(pressures)


def filled_hand(dt=2e-3):
    bench = EmbeddedRig(HAND.channels, FreeActuators(HAND))
    run(bench, 0.6, [1] * 4, dt)
    run(bench, 1.0, [0] * 4, dt)
    return bench


def test_volumes_as_numbers_and_as_bottles_are_the_same_bench():
    readings = []
    for volumes in ([1e-4, 5e-4], Bottles([1e-4, 5e-4])):
        bench = EmbeddedRig("ab", volumes, seed=4)
        run(bench, 0.3, [1, 1])
        readings.append(bench.advance(2e-3))
    np.testing.assert_array_equal(*readings)


def test_a_hand_comes_to_rest_where_its_volumes_balance_the_pressures():
    bench = filled_hand()
    balanced = bench.chambers.volumes(bench.plant.pressures)
    assert (bench.volumes > 1.02 * HAND.rest_volumes()).all()
    np.testing.assert_allclose(bench.volumes, balanced, rtol=1e-5)


@pytest.mark.parametrize("dt", [2e-3, 0.1])
def test_pushed_with_closed_valves_a_hand_keeps_its_air_and_goes_along_the_iso_mass_line(dt):
    bench = filled_hand(dt)
    mass, pressures, volumes = bench.plant.mass, bench.plant.pressures, bench.volumes
    bench.chambers.set_load(np.full(4, 8e3))
    seen = run(bench, 1.0, [0] * 4, dt)
    np.testing.assert_allclose(bench.plant.mass, mass, rtol=1e-12)
    assert (bench.volumes < 0.99 * volumes).all()
    dead = 2 * load_pneumatics().choke.dead_volume
    product = pressures * (volumes + dead)
    np.testing.assert_allclose(seen[-1] * (bench.volumes + dead), product, rtol=1e-4)
    assert seen.max() < 1.001 * seen[-1].max(), "the pressures overshoot"


def test_let_go_a_hand_returns_to_where_it_was():
    bench = filled_hand()
    before = bench.volumes
    for load in (8e3, 0.0):
        bench.chambers.set_load(np.full(4, load))
        run(bench, 1.0, [0] * 4)
    np.testing.assert_allclose(bench.volumes, before, rtol=1e-5)


def test_relief_valves_of_the_bench_hold_its_pressure():
    bench = EmbeddedRig("a", [1e-5], relief_pressures=[5e4])
    bench.plant.faults.stick_valve("a", 1)
    run(bench, 2.0, [0])
    gauge = bench.plant.pressures[0] - bench.plant.parameters.ambient_pressure
    assert 5e4 < gauge < 5.5e4
