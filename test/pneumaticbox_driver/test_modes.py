"""The table of control modes: its controllers and its page in the docs agree with it."""

import math
from pathlib import Path

import pytest

from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.control.channels import CONTROLLERS, PRESENT
from pneumaticbox_driver.modes import MODES, check_mode

(PAGE,) = (Path(__file__).parents[2] / "docs").rglob("pneumaticbox.md")


def test_every_mode_has_its_controller_and_a_setpoint_that_holds_what_is_or_asks_for_nothing():
    assert list(CONTROLLERS) == list(MODES)
    assert [name for name, mode in MODES.items() if math.isnan(mode.idle)] == list(PRESENT)


@pytest.mark.parametrize("mode", MODES.values(), ids=MODES)
def test_every_mode_stands_on_its_page_with_the_field_and_the_unit_that_it_reads(mode):
    assert hasattr(TrajectoryPoint(0.0), mode.field)
    (row,) = [line for line in PAGE.read_text("utf-8").splitlines() if f"| `{mode.name}` |" in line]
    assert mode.field in row
    assert mode.scheduled or f"[{mode.unit}" in row


def test_a_mode_that_does_not_exist_is_refused_with_those_that_do():
    with pytest.raises(ValueError, match=r"control_mode must be one of \['mass', .*, got 'magic'"):
        check_mode("magic")


def test_only_a_flow_and_a_schedule_have_a_target_that_asks_for_nothing():
    idle = {name: mode.idle for name, mode in MODES.items() if not math.isnan(mode.idle)}
    assert idle == {"mass_flow": 0.0, "time": 0.0}
    assert [name for name, mode in MODES.items() if mode.scheduled] == ["time"]
