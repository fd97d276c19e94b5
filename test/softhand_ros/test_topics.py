"""Stamps of messages as numbers and back."""

import pytest

from softhand_ros.topics import nanoseconds, seconds, stamp_of, stamp_of_seconds


@pytest.mark.parametrize("time", [0, 1, 999_999_999, 10**9, 1_234_567_890_123_456_789])
def test_a_stamp_keeps_every_nanosecond(time):
    assert nanoseconds(stamp_of(time)) == time


def test_a_stamp_of_seconds_is_rounded_to_the_nanosecond():
    assert nanoseconds(stamp_of_seconds(1.9999999999)) == 2 * 10**9
    assert seconds(stamp_of_seconds(3.25)) == 3.25
