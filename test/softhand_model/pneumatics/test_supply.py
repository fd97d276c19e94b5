"""Compressor, tank and regulator against bounds and the balance of the air."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT
from softhand_model.pneumatics import load_pneumatics
from softhand_model.pneumatics.supply import AirSupply

GAS = GAS_CONSTANT * 293.15  # [J/kg]
USE = 5e-5  # of air [kg/s]
DT = 1e-3


def small_tank(**changes):
    p = load_pneumatics()
    return replace(p, compressor=replace(p.compressor, tank_volume=2e-4, **changes))


def record(supply, duration, use=USE):
    """Tank, reservoir [Pa] and whether the compressor runs, per step."""
    rows = []
    for _ in range(round(duration / DT)):
        supply.step(DT, use * DT)
        rows.append((supply.tank_pressure, supply.pressure, supply.compressor_runs))
    return np.array(rows)


def test_the_compressor_cycles_between_its_pressures():
    box = small_tank()
    tank, _, runs = record(AirSupply(box), 40.0).T
    assert np.sum(np.diff(runs) > 0) >= 3
    low, high = box.compressor.cut_in + AMBIENT_PRESSURE, box.compressor.cut_out + AMBIENT_PRESSURE
    assert tank.min() == pytest.approx(low, abs=500)
    assert tank.max() == pytest.approx(high, abs=500)


def test_what_tank_and_reservoir_have_lost_is_what_was_used_less_what_was_delivered():
    box = small_tank()
    supply = AirSupply(box)
    before = supply.tank_pressure, supply.pressure
    tank, reservoir, runs = record(supply, 23.0).T
    lost = (before[0] - tank[-1]) * 2e-4 + (before[1] - reservoir[-1]) * box.supply.volume
    delivered = box.compressor.delivery * DT * runs.sum()
    assert delivered > 0
    assert lost / GAS == pytest.approx(USE * 23.0 - delivered, rel=1e-6)


def test_the_regulator_passes_on_its_share_of_the_cycle():
    box = small_tank(passed=0.05)
    settled = record(AirSupply(box), 40.0)[3000:, 1]
    swing = 0.05 * (box.compressor.cut_out - box.compressor.cut_in)
    assert np.ptp(settled) == pytest.approx(swing, rel=0.1)
    nothing_passed = record(AirSupply(small_tank(passed=0.0)), 40.0)[3000:, 1]
    assert np.ptp(nothing_passed) < 1.0


def test_the_shipped_supply_wanders_by_a_few_kilopascals():
    box = load_pneumatics()
    wander = box.compressor.passed * (box.compressor.cut_out - box.compressor.cut_in)
    droop = box.supply.droop * USE
    assert 1e3 < wander < 5e3 and 1e3 < droop + wander < 10e3


def test_unused_the_supply_stays_at_its_set_point():
    supply = AirSupply(load_pneumatics())
    before = supply.pressure
    record(supply, 1.0, use=0.0)
    assert supply.pressure == before


@pytest.mark.parametrize("gauge", [260e3, 320e3])
def test_turned_to_another_pressure_the_reservoir_takes_it_on(gauge):
    supply = AirSupply(load_pneumatics())
    supply.set(gauge)
    record(supply, 3.0, use=0.0)
    assert supply.pressure == pytest.approx(gauge + AMBIENT_PRESSURE, abs=50)
    assert supply.tank_pressure > load_pneumatics().compressor.cut_in


def test_an_empty_tank_bounds_the_supply():
    supply = AirSupply(small_tank(delivery=1e-9))
    tank, reservoir, _ = record(supply, 60.0).T
    assert tank[-1] < 300e3
    assert reservoir[-1] <= tank[-1]
