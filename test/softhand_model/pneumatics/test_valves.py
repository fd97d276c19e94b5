"""The plant's rule: outlets open when the driver is silent for 250 ms."""

import pytest

from softhand_model.pneumatics import CommandWatch


def test_the_last_command_holds_for_250_ms_and_then_the_outlets_open():
    watch = CommandWatch(2)
    watch.receive(1.0, [1, 0])
    assert watch.valves(1.25).tolist() == [1, 0]
    assert watch.valves(1.252).tolist() == [-1, -1]


def test_a_command_after_silence_is_obeyed_again():
    watch = CommandWatch(1)
    assert watch.valves(9.0).tolist() == [-1]
    watch.receive(9.0, [1])
    assert watch.valves(9.1).tolist() == [1]


def test_a_repeated_command_is_a_sign_of_life():
    watch = CommandWatch(1)
    for k in range(10):
        watch.receive(0.2 * k, [1])
    assert not watch.silent(2.0)


def test_a_command_that_cannot_be_is_refused_and_changes_nothing():
    watch = CommandWatch(2)
    watch.receive(0.0, [1, 1])
    with pytest.raises(ValueError, match=r"valves must have shape \(2,\), got \(1,\)"):
        watch.receive(0.1, [0])
    with pytest.raises(ValueError, match="valves must be -1, 0 or 1, got nan"):
        watch.receive(0.1, [0, float("nan")])
    assert watch.valves(0.1).tolist() == [1, 1]


def test_reset_closes_the_valves_and_starts_anew():
    watch = CommandWatch(1)
    watch.receive(5.0, [1])
    watch.reset(0.0)
    assert watch.valves(0.2).tolist() == [0]
    assert watch.valves(0.3).tolist() == [-1]
