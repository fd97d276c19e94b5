"""Commanded air masses against values worked out by hand."""

import numpy as np
import pytest

from softhand_bringup.bags.reading import Command
from softhand_bringup.figures import commanded_masses

TIME = np.arange(0.0, 5.01, 0.5)


def command(start, names, times, positions, received=None):
    received = start if received is None else received
    return Command(received, start, names, np.array(times), np.array(positions))


def test_without_a_command_nothing_is_asked_for():
    assert commanded_masses([], ("a", "b"), TIME).tolist() == [[0.0, 0.0]] * len(TIME)


def test_a_ramp_begins_at_the_value_then_commanded_and_its_end_is_held():
    ramp = command(1.0, ("a",), [2.0], [[4.0]])
    values = commanded_masses([ramp], ("a",), TIME)[:, 0]
    assert values == pytest.approx([0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 4])


def test_a_later_command_replaces_the_rest_of_the_schedule_and_starts_where_it_was():
    first = command(1.0, ("a",), [2.0], [[4.0]])
    second = command(2.0, ("a",), [1.0], [[0.0]])
    values = commanded_masses([first, second], ("a",), TIME)[:, 0]
    assert values == pytest.approx([0, 0, 0, 1, 2, 1, 0, 0, 0, 0, 0])


def test_a_channel_that_is_not_named_keeps_its_schedule_and_columns_follow_the_names():
    first = command(0.0, ("b", "a"), [0.0], [[7.0, 3.0]])
    second = command(2.0, ("b",), [0.0], [[1.0]])
    values = commanded_masses([first, second], ("a", "b"), TIME)
    assert values[:, 0].tolist() == [3.0] * len(TIME)
    assert values[:, 1].tolist() == [7.0] * 4 + [1.0] * 7


def test_a_command_scheduled_for_later_waits_for_its_start():
    later = command(3.0, ("a",), [0.0], [[5.0]], received=0.5)
    assert commanded_masses([later], ("a",), TIME)[:, 0].tolist() == [0.0] * 6 + [5.0] * 5
