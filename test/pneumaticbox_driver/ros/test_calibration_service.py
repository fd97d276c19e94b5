"""What a calibration has found is saved while samples are answered."""

import os
import threading
import time
from types import SimpleNamespace

import pytest

from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.calibration.file import load_box_note, load_calibration
from pneumaticbox_driver.ros.calibration_service import Calibrating
from pneumaticbox_driver.settings import BoxSettings

VALUES = {"calibration_file": "", "box": "of the test", "calibration_volume": 5e-4}


@pytest.fixture
def calibrating(tmp_path):
    """A calibration that has ended and is to be saved."""
    found = load_calibration(None, 1)
    box = PneumaticBox(BoxSettings(("a",), (1e-4,), (1e5,), ("mass",)), found)
    calibrating = Calibrating(box, found, VALUES.__getitem__)
    calibrating._run = SimpleNamespace(state="done", result=found)
    calibrating._output = tmp_path / "found.yaml"
    return calibrating


def finish(calibrating):
    end = time.monotonic() + 60.0
    while calibrating.report().values.get("state"):
        assert time.monotonic() < end
        calibrating.look()
        time.sleep(0.01)
    return calibrating.report()


def test_a_disk_that_takes_its_time_holds_up_no_sample(calibrating, monkeypatch):
    written = threading.Event()
    monkeypatch.setattr(os, "fsync", lambda file: written.wait(20.0))
    calibrating.look()
    assert not calibrating._output.exists()
    assert calibrating.report().values["state"] == "saving"
    with pytest.raises(ValueError, match="the last calibration is being saved to"):
        calibrating.begin()
    written.set()
    assert finish(calibrating).values["file"] == str(calibrating._output)
    assert load_box_note(calibrating._output).box == "of the test"


def test_a_file_that_cannot_be_written_is_told(calibrating, tmp_path):
    (tmp_path / "file").touch()
    calibrating._output = tmp_path / "file" / "found.yaml"
    calibrating.look()
    report = finish(calibrating)
    assert "is in use, but was not saved" in report.message
    assert any("was not saved" in note for note in calibrating._box.notes)
