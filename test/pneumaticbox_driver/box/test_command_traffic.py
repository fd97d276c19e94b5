"""Commands are counted, and a storm of them is noticed whether they are taken or overwritten."""

import pytest

from pneumaticbox_driver.box.diagnostics import CommandTraffic


def one():
    return 1


def two():
    return 2


def stream(traffic, start, rate, duration, taken_of=1, commanders=one):
    """Messages at a rate [1/s], every `taken_of`-th of them taken."""
    for number in range(1, int(rate * duration) + 1):
        if number % taken_of == 0:
            traffic.note(start + number / rate, "command", number, commanders)


@pytest.mark.parametrize("rate", [1.0, 100.0, 450.0])
def test_a_stream_that_control_can_follow_is_no_storm(rate):
    traffic = CommandTraffic()
    stream(traffic, 50.0, rate, 5.0)
    assert traffic.storm(55.0) == 0.0
    assert (traffic.taken, traffic.lost) == (int(5 * rate), 0)


def test_of_a_storm_rate_and_losses_are_told_though_most_were_never_seen():
    traffic = CommandTraffic()
    stream(traffic, 50.0, 40000.0, 0.25, taken_of=10)
    assert traffic.taken == 1000
    assert traffic.lost == 10000 - 1000 - 9  # those before the first one are unknown
    assert traffic.storm(50.3) == pytest.approx(40000.0, rel=0.02)


def test_a_storm_is_forgotten_after_ten_seconds():
    traffic = CommandTraffic()
    stream(traffic, 50.0, 2000.0, 1.0)
    assert traffic.storm(60.0) > 1900.0
    assert traffic.storm(62.0) == 0.0


def test_with_two_commanders_numbers_to_and_fro_are_no_losses():
    traffic = CommandTraffic()
    for k in range(100):
        traffic.note(50.0 + 0.01 * k, "command", 5000 + k if k % 2 else k, two)
    assert (traffic.taken, traffic.lost) == (100, 0)
    assert traffic.storm(51.0) == 0.0


def test_numbers_of_the_two_topics_are_apart():
    traffic = CommandTraffic()
    for k in range(10):
        traffic.note(50.0 + k, "command", 1 + k, one)
        traffic.note(50.0 + k, "schedule", 1000 + k, one)
    assert traffic.lost == 0
