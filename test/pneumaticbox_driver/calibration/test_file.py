"""The file of a calibration, and the warnings on a calibration that does not fit."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from synthetic_pulses import design, noisy

from pneumaticbox_driver.calibration.command import SIMULATED_BOX, main
from pneumaticbox_driver.calibration.file import (
    check_calibration,
    load_box_note,
    load_calibration,
    save_calibration,
)
from pneumaticbox_driver.calibration.regression import fit_channel
from pneumaticbox_driver.observer.coefficients import Leak, PulseCoefficients

DATE = datetime(2017, 5, 4, 12, 30, tzinfo=UTC)
NAMES = ("a", "b")


@pytest.fixture(scope="module")
def pair():
    """Two channels on outlets 3 and 5, the second with a leak."""
    random = np.random.default_rng(4)
    return [
        fit_channel(
            noisy(design(True), random, 1e-3) + noisy(design(False), random, 1e-3), leak, outlet
        )
        for outlet, leak in ((3, Leak()), (5, Leak(2e-12, 1e-13)))
    ]


@pytest.fixture
def saved(tmp_path, pair):
    """A file with both."""
    path = tmp_path / "box.yaml"
    save_calibration(path, "mine", pair, 0.5e-3, 101e3, DATE)
    return path


def test_what_is_saved_is_read_back_by_outlet(saved, pair):
    read = load_calibration(saved, 2, outlets=(5, 3))
    for found, made in zip(read, reversed(pair), strict=True):
        assert found.outlet == made.outlet and found.points == made.points
        assert found.leak.conductance == pytest.approx(made.leak.conductance)
        for name in ("supply_range", "pressure_range"):
            assert getattr(found, name) == pytest.approx(getattr(made, name))
        for ours, given in ((found.inflate, made.inflate), (found.deflate, made.deflate)):
            for name in ("residual", "jitter", "delays"):
                assert getattr(ours, name) == pytest.approx(getattr(given, name))
            np.testing.assert_allclose(ours.as_array(), given.as_array(), rtol=1e-7)
            np.testing.assert_allclose(ours.covariance, given.covariance, rtol=1e-6)


def test_the_file_says_which_box_when_by_what_and_on_what(saved):
    note = load_box_note(saved)
    assert (note.box, note.date) == ("mine", "2017-05-04T12:30:00+00:00")
    assert note.ambient == 101e3 and note.volume == 0.5e-3
    assert note.version


def test_format_1_is_refused_by_name_with_the_command_that_makes_a_new_one(saved):
    saved.write_text(saved.read_text().replace("calibration/2", "calibration/1"))
    with pytest.raises(
        ValueError, match="box.yaml:2: format: expected pneumaticbox-calibration/2"
    ) as e:
        load_calibration(saved, 1)
    assert "`calibrate --output FILE`" in str(e.value)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("calibration/2", "calibration/9", "format: expected one of pneumaticbox-calibration/2"),
        ("outlet: 3", "outlt: 3", "outlets[0]: expected a mapping with the key outlet"),
        ("points: ", "points: many # ", "outlets[0].points: expected a whole number"),
        ("friction:", "frction:", "outlets[0].inflate: expected the key friction"),
        ("date: ", "day: ", "expected the key date"),
        ("conductance: ", "conductivity: ", "outlets[0].leak: expected the key conductance"),
        (
            "volume: 0.0005",
            "volume: -1.0",
            "volume: expected a number from 1e-09 to 10 m3",
        ),
    ],
)
def test_a_damaged_file_is_refused_by_key_expected_and_got(saved, old, new, expected):
    saved.write_text(saved.read_text().replace(old, new, 1))
    with pytest.raises(ValueError) as error:
        load_calibration(saved, 1, outlets=(3,))
        load_box_note(saved)
    assert "box.yaml:" in str(error.value) and expected in str(error.value)


def test_an_outlet_that_was_not_calibrated_is_refused(saved):
    with pytest.raises(ValueError, match="outlets: expected outlet 1, got 3, 5"):
        load_calibration(saved, 1)
    with pytest.raises(ValueError, match="outlets must have 2 entries, one per channel, got 1"):
        load_calibration(saved, 2, outlets=(3,))


def test_nothing_speaks_against_a_calibration_that_fits(pair):
    fits = {"box": "mine", "expected_box": "mine", "supply": 290e3, "pressures": (10e3, 40e3)}
    assert check_calibration(NAMES, pair, **fits) == []


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"box": "mine", "expected_box": "yours"}, "of the box 'mine', not of 'yours'"),
        ({"supply": 200e3}, "channel a: supply of 200 kPa is outside of the 260 to 320 kPa"),
        ({"pressures": (30e3, 90e3)}, "channel b: pressure of 90 kPa is outside of"),
    ],
)
def test_a_calibration_that_does_not_fit_is_warned_of(pair, given, expected):
    assert any(expected in warning for warning in check_calibration(NAMES, pair, **given))


def test_coefficients_used_by_two_channels_are_warned_of_wherever_they_come_from(pair):
    same = [pair[0], replace(pair[0], outlet=4)]
    (warning,) = check_calibration(NAMES, same)
    assert warning.startswith("channels a and b share one calibration")


def test_coefficients_that_let_air_flow_uphill_are_warned_of(pair):
    wrong = replace(pair[1], deflate=PulseCoefficients(0.0, 1e-12, -1e-10, 0.0))
    (warning,) = check_calibration(NAMES, [pair[0], wrong])
    assert "channel b: coefficients of deflate give a negative flow" in warning


def test_the_command_writes_what_the_driver_reads_and_tells_residuals(tmp_path, capsys):
    path = tmp_path / "new.yaml"
    few = ["--points", "24", "--outlets", "1", "--supplies", "250e3", "330e3"]
    assert main(["--output", str(path), *few]) == 0
    (channel,) = load_calibration(path, 1)
    assert channel.points == 24 and load_box_note(path).box == SIMULATED_BOX
    low, high = channel.supply_range
    assert 55e3 < high - low < 95e3
    told = capsys.readouterr()
    assert "outlet 1: residual" in told.out


def test_the_command_s_help_names_the_units(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    assert "[Pa]" in text and "[m3]" in text


def test_the_command_refuses_a_plan_that_cannot_be_played(tmp_path, capsys):
    assert main(["--output", str(tmp_path / "c.yaml"), "--points", "10"]) == 1
    assert "points must be at least 24" in capsys.readouterr().err
