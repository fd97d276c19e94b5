"""Recording test pulses on the pretended bench."""

import pytest

from pneumaticbox_driver.calibrate import BOTTLE, record_on_bench


@pytest.fixture(scope="session")
def bench_pulses():
    """Record pulses per channel on bottles of 0.5 L."""

    def record(cycles, seed, channels, supply):
        return record_on_bench(cycles, seed, channels, BOTTLE, supply)

    return record
