"""Samples of the sensors as the driver takes them."""

import pytest
from sensor_msgs.msg import JointState

from pneumaticbox_driver.ros.plant_topics import absolute_pressures


def test_pressures_are_those_of_the_sample_supply_last():
    sample = JointState(name=["a", "supply"], effort=[1.1e5, 4.0e5])
    assert absolute_pressures(sample, ("a",)).tolist() == [1.1e5, 4.0e5]


@pytest.mark.parametrize("names", [["x" * 10_000_000], ["y" * 300] * 100])
def test_names_that_are_not_the_box_s_are_quoted_short(names):
    with pytest.raises(ValueError, match="name: expected") as refused:
        absolute_pressures(JointState(name=names), ("a",))
    assert len(str(refused.value)) < 300
