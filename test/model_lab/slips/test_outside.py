"""Data by which no model can be judged are refused, with what was expected and what came."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.slips.outside import dead_readings, outside
from softhand_model.model_file import load_model

EXAMPLE = Path(__file__).parents[3] / "examples" / "measurements" / "finger"
BASE = load_model("base")


def with_angles(change):
    """The example with tip angles [rad] that are change(angle, random)."""
    data, random = load_measurements(EXAMPLE), np.random.default_rng(1)
    runs = (
        replace(r, columns={**r.columns, "tip_angle": change(r.columns["tip_angle"], random)})
        for r in data.runs
    )
    return replace(data, runs=tuple(runs))


DEAD = {
    "expected readings that change with the input, got 12 deg throughout": lambda angle, _: (
        np.full_like(angle, np.radians(12.0))
    ),
    "got 9999 deg in .* samples": lambda angle, _: np.where(
        angle > np.radians(50.0), np.radians(9999.0), angle
    ),
    "expected readings that follow the input": lambda angle, random: random.normal(
        0.0, 0.3, len(angle)
    ),
}


@pytest.mark.parametrize(("said", "change"), DEAD.items())
def test_readings_of_a_dead_sensor_are_refused_before_any_search(said, change):
    data = with_angles(change)
    with pytest.raises(ValueError, match=f"experiment.yaml: tip_angle: .*{said}|: {said}"):
        diagnose(data, BASE)
    found = compare(data, BASE)
    assert found.slips == () and found.outside.startswith("tip_angle: expected readings")


@pytest.mark.parametrize("seed", range(20))
def test_noisy_or_coarse_readings_are_not_dead(seed):
    random = np.random.default_rng(seed)
    step = np.radians(random.uniform(1.0, 20.0))
    coarse = with_angles(lambda angle, _: step * np.round(angle / step))
    noisy = with_angles(lambda angle, _: angle + random.normal(0.0, np.ptp(angle), len(angle)))
    stopped = with_angles(lambda angle, _: np.minimum(angle, np.radians(20.0)))
    assert [outside(data, "pneuflex") for data in (coarse, noisy, stopped)] == [None] * 3


def test_steps_between_two_readings_are_no_marks():
    two = with_angles(lambda angle, _: np.where(angle > 0.5, 1.0, 0.0))
    assert dead_readings(two) is None
