"""The used calibration: read from its file, or measured on the box while the node runs."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.calibration.file import (
    BoxNote,
    check_calibration,
    load_box_note,
    load_calibration,
    save_calibration,
)
from pneumaticbox_driver.calibration.run import CalibrationPlan, CalibrationRun
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.settings import outlet_numbers
from softhand_common.documents.output_file import UnwritableFile
from softhand_common.status import Level, Report

Value = Callable[[str], Any]
UNNAMED = "unnamed"


def calibrations_of(value: Value, channels: int) -> list[ChannelCalibration]:
    """Read the coefficients of the outlets that the channels use.

    Args:
        value: returns a parameter's value by its name.
        channels: number of channels.

    Raises:
        ValueError: the file or the parameter outlets cannot be used.
    """
    outlets = outlet_numbers(value("outlets"), channels)
    return load_calibration(value("calibration_file") or None, channels, outlets)


class Calibrating:
    """Starts calibrations of a box, saves their results and uses them at once.

    Args:
        box: the box, which uses `calibrations`.
        calibrations: the result of `calibrations_of`.
        value: returns a parameter's value by its name.

    Raises:
        ValueError: as `load_box_note` does.
    """

    def __init__(
        self, box: PneumaticBox, calibrations: list[ChannelCalibration], value: Value
    ) -> None:
        self._box, self._value = box, value
        self._calibrations = calibrations
        self._source = value("calibration_file") or "that of the simulated box"
        self._note: BoxNote = load_box_note(value("calibration_file") or None)
        self._run: CalibrationRun | None = None
        self._saving: Future[BoxNote] | None = None
        self._output = Path()
        self._failure = ""

    def begin(self) -> str:
        """Begin a calibration; returns a sentence on what was done.

        Raises:
            ValueError: parameters that cannot be used, the box cannot begin now, or the last
                calibration is not saved yet.
        """
        if self._saving is not None:
            raise ValueError(f"the last calibration is being saved to {self._output}")
        volume = self._value("calibration_volume")
        if not volume > 0:
            raise ValueError("calibration_volume must be above 0 m3: no fixed volume is attached")
        output = _new_file(self._value("calibration_output"))
        channels = self._box.settings.channels
        plan = CalibrationPlan(
            points=self._value("calibration_points"),
            supplies=self._value("calibration_supplies"),
            leak_test=self._value("calibration_leak_test"),
        )
        run = CalibrationRun(channels, np.full(len(channels), volume), plan, aside=True)
        done = self._box.start_calibration(run)
        self._run, self._output, self._failure = run, output, ""
        return done

    def next(self) -> str:
        """Continue at another supply pressure; raises ValueError unless a run waits for it."""
        return self._box.calibration.next()

    def look(self) -> None:
        """When a calibration has ended, use and save its result, or report why it has failed."""
        if self._saving is not None and self._saving.done():
            self._finish_saving(self._saving)
        run = self._run
        if run is None or run.state not in ("done", "failed"):
            return
        self._run = None
        if run.state == "done":
            self._use(run)
        else:
            self._failure = f"calibration failed: {run.message}"
            self._box.notes.append(self._failure)

    def _use(self, run: CalibrationRun) -> None:
        self._calibrations = run.result
        self._box.observer.set_calibrations(self._calibrations)
        box, volume = self._value("box") or UNNAMED, self._value("calibration_volume")
        ambient = self._box.settings.ambient
        # in a thread: a disk may take longer than a sample can wait
        saver = ThreadPoolExecutor(1, "calibration")
        self._saving = saver.submit(_save, self._output, box, self._calibrations, volume, ambient)
        saver.shutdown(wait=False)

    def _finish_saving(self, saving: "Future[BoxNote]") -> None:
        self._saving = None
        try:
            self._note = saving.result()
            self._source = str(self._output)
        except UnwritableFile as error:
            self._failure = f"the new calibration is in use, but was not saved: {error}"
            self._box.notes.append(self._failure)

    def report(self) -> Report:
        """Report the used calibration, warnings about it, and the progress of a running one."""
        report = Report("calibration")
        report.values = {
            "file": self._source,
            "box": self._note.box,
            "date": self._note.date,
            "version": self._note.version,
        }
        box, expected = self._note.box, self._value("box")
        supply = (
            self._box.supply_abs - self._box.settings.ambient if self._box.zeroing.ready else None
        )
        names = self._box.settings.channels
        for warning in check_calibration(names, self._calibrations, box, expected, supply):
            report.raise_to(Level.WARN, warning)
        if self._failure:
            report.raise_to(Level.WARN, self._failure)
        if self._run is not None:
            self._report_run(self._run, report)
        if self._saving is not None:
            report.values["state"] = "saving"
        return report

    def _report_run(self, run: CalibrationRun, report: Report) -> None:
        report.values["state"] = run.state
        report.values["progress"] = f"{100 * run.progress:.0f} %"
        report.level = Level.WARN if run.state == "waiting" else Level.OK
        report.message = run.message


def _save(
    path: Path, box: str, channels: list[ChannelCalibration], volume: float, ambient: float
) -> BoxNote:
    save_calibration(path, box, channels, volume, ambient)
    return load_box_note(path)


def _new_file(given: str) -> Path:
    """The path of a file to write; raises ValueError if it is empty or cannot be written."""
    if not given:
        raise ValueError("calibration_output must be the path of a new file, got ''")
    path = Path(given).expanduser()
    if path.exists():
        raise ValueError(f"calibration_output: expected a new file, got {path}, which exists")
    if not path.parent.is_dir():
        raise ValueError(f"calibration_output: expected a folder {path.parent}, which is missing")
    return path
