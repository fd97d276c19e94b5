"""Pressure sensors on the analog inputs of an IIO device, read through sysfs."""

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.backends.hardware.hardware_file import Converter, HardwareError, Sensor

MILLIVOLT = 1e-3  # IIO gives a scale in millivolts per count


class IioInputs:
    """Sensors on IIO inputs; their files stay open, and a reading is one `pread` per sensor.

    volts = (raw + offset) scale / divider, absolute pressure = gain volts + offset (+ ambient)

    Args:
        converter: the IIO device.
        sensors: wiring, in the order of the readings (k,).
        ambient: absolute ambient pressure, added to the readings of gauge sensors [Pa].

    Raises:
        HardwareError: the device, an input or its scale is missing or cannot be read.
    """

    def __init__(self, converter: Converter, sensors: Sequence[Sensor], ambient: float) -> None:
        folder = find_device(converter)
        types = [sensor.type for sensor in sensors]
        self._gain = np.array([kind.gain for kind in types])
        zero = {"gauge": ambient, "absolute": 0.0}
        self._offset = np.array([kind.offset + zero[kind.reference] for kind in types])
        self._low, self._high = np.array([kind.output for kind in types]).T
        scales = [_scale(converter, folder, sensor) for sensor in sensors]
        self._volts_per_count = np.array(scales) / [sensor.divider for sensor in sensors]
        self._count_offset = np.array([_count_offset(folder, sensor.input) for sensor in sensors])
        self._files: list[int] = []
        try:
            for sensor in sensors:
                self._files.append(_open(folder, sensor))
        except BaseException:
            self.close()
            raise

    def volts(self) -> Floats:
        """Read the outputs of the sensors, before the dividers (k,) [V]; NaN if unreadable."""
        counts = np.array([_count(file) for file in self._files])
        return (counts + self._count_offset) * self._volts_per_count

    def read(self) -> Floats:
        """Read absolute pressures (k,) [Pa].

        NaN if the file cannot be read or has no number, or if the voltage is outside of the
        sensor's output range, as with a broken wire or a short circuit.
        """
        volts = self.volts()
        sound = (volts >= self._low) & (volts <= self._high)
        return np.where(sound, self._gain * volts + self._offset, math.nan)

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            os.close(file)
        self._files.clear()


def find_device(converter: Converter) -> Path:
    """Return the folder of the IIO device, given by its name or its folder.

    Raises:
        HardwareError: there is none, or more than one of that name.
    """
    names = _device_names(converter.sysfs)
    found = [path for path, name in names.items() if converter.device in (name, path.name)]
    if len(found) != 1:
        known = [f"{name} ({path.name})" for path, name in names.items()]
        raise HardwareError(
            f"{converter.place}.device: expected one IIO device below {converter.sysfs} "
            f"({', '.join(known) or 'there is none'}), got {converter.device}"
        )
    return found[0]


def _device_names(sysfs: Path) -> dict[Path, str]:
    names = {}
    for folder in sorted(sysfs.glob("iio:device*")):
        try:
            names[folder] = (folder / "name").read_text(encoding="utf-8").strip()
        except OSError:
            names[folder] = ""
    return names


def _scale(converter: Converter, folder: Path, sensor: Sensor) -> float:
    """Volts per count, from the hardware file, else from the input, else from the device."""
    if converter.scale is not None:
        return converter.scale
    scale = _number(folder, sensor.input, "scale")
    if scale is None or not scale > 0:
        raise HardwareError(
            f"{converter.place}: expected the key scale [V per count], as {folder} states none "
            f"above 0: got {scale} there"
        )
    return scale * MILLIVOLT


def _count_offset(folder: Path, number: int) -> float:
    return _number(folder, number, "offset") or 0.0


def _number(folder: Path, number: int, kind: str) -> float | None:
    """The number in an input's file of this kind, else in the file for all inputs; None without."""
    for name in (f"in_voltage{number}_{kind}", f"in_voltage_{kind}"):
        path = folder / name
        if path.exists():
            try:
                return float(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise HardwareError(f"{path}: expected a number, got {error}") from error
    return None


def _open(folder: Path, sensor: Sensor) -> int:
    path = folder / f"in_voltage{sensor.input}_raw"
    try:
        return os.open(path, os.O_RDONLY)
    except OSError as error:
        raise HardwareError(
            f"{sensor.place}.input: expected the analog input {path}, got {error.strerror}"
        ) from error


def _count(file: int) -> float:
    """The number in an open file; NaN without one, for which the box vents."""
    try:
        return float(int(os.pread(file, 32, 0)))
    except (OSError, ValueError):
        return math.nan
