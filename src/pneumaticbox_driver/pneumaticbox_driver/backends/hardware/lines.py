"""GPIO lines that drive the coils, through libgpiod."""

from collections.abc import Container, Mapping, Sequence
from types import ModuleType
from typing import Any, Protocol

from pneumaticbox_driver.backends.hardware.hardware_file import Coil, HardwareError

CONSUMER = "pneumaticbox"  # shown by gpioinfo as the user of the lines


class LinesError(HardwareError):
    """GPIO lines that could not be set; `lines` are their indices."""

    def __init__(self, message: str, lines: Sequence[int]) -> None:
        super().__init__(message)
        self.lines = frozenset(lines)


class OutputLines(Protocol):
    """Output lines, given by their index; all are inactive at first."""

    def switch(self, active: Mapping[int, bool]) -> None:
        """Switch these lines on (True) or off; the others stay as they are.

        Raises:
            LinesError: some lines cannot be set; the others in `active` have been set.
        """

    def release(self) -> None:
        """Release the lines."""


class GpioLines:
    """The lines of `coils`, in their order, as outputs that are inactive from the start.

    Args:
        coils: chip, line and polarity of each.

    Raises:
        HardwareError: the package gpiod is missing or of version 1, or a chip or a line is missing,
            must not be used or is in use; no line is held then.
    """

    def __init__(self, coils: Sequence[Coil]) -> None:
        gpiod = load_gpiod()
        self._on, self._off = gpiod.line.Value.ACTIVE, gpiod.line.Value.INACTIVE
        self._requests: dict[str, Any] = {}
        self._index: list[tuple[str, int]] = [("", 0)] * len(coils)
        try:
            for chip in dict.fromkeys(coil.chip for coil in coils):
                self._request(
                    gpiod, chip, [i for i, c in enumerate(coils) if c.chip == chip], coils
                )
        except BaseException:
            self.release()
            raise

    def _request(
        self, gpiod: ModuleType, path: str, indices: Sequence[int], coils: Sequence[Coil]
    ) -> None:
        place = coils[indices[0]].place
        try:
            chip = gpiod.Chip(path)
        except OSError as error:
            raise HardwareError(
                f"{place}: expected a GPIO chip at {path}, got {error.strerror}"
            ) from error
        with chip:
            settings: dict[int, Any] = {}
            for i in indices:
                offset = _offset(chip, coils[i], settings)
                settings[offset] = gpiod.LineSettings(
                    direction=gpiod.line.Direction.OUTPUT,
                    output_value=self._off,
                    active_low=coils[i].active_low,
                )
                self._index[i] = (path, offset)
            try:
                self._requests[path] = chip.request_lines(settings, consumer=CONSUMER)
            except OSError as error:
                raise HardwareError(
                    f"{place}: expected lines {sorted(settings)} of {path} to be free, "
                    f"got {error.strerror}"
                ) from error

    def switch(self, active: Mapping[int, bool]) -> None:
        """Switch these lines, those of one chip together.

        Raises:
            LinesError: lines of a chip cannot be set; those of other chips have been set.
        """
        values: dict[str, dict[int, Any]] = {}
        for index, on in active.items():
            path, offset = self._index[index]
            values.setdefault(path, {})[offset] = self._on if on else self._off
        failed = {}
        for path, settings in values.items():
            try:
                self._requests[path].set_values(settings)
            except OSError as error:
                failed[path] = (
                    f"{path}: expected to set lines {sorted(settings)}, got {error.strerror}"
                )
        if failed:
            lines = [index for index in active if self._index[index][0] in failed]
            raise LinesError("; ".join(failed.values()), lines)

    def release(self) -> None:
        """Release the lines; their state afterwards depends on the chip's driver."""
        for request in self._requests.values():
            request.release()
        self._requests.clear()


def load_gpiod() -> ModuleType:
    """Import the package gpiod, which only this backend needs.

    Raises:
        HardwareError: the package is not installed or older than version 2.
    """
    try:
        import gpiod
    except ImportError as error:
        raise HardwareError(
            "backend hardware: expected the package gpiod (pip install 'gpiod>=2'), got none"
        ) from error
    if not hasattr(gpiod, "LineSettings"):
        version = getattr(gpiod, "__version__", "another")
        raise HardwareError(
            f"backend hardware: expected the package gpiod of version 2 or above, got {version}"
        )
    return gpiod


def _offset(chip: Any, coil: Coil, taken: Container[int]) -> int:
    """Number of a coil's line on its chip; raises HardwareError if it is taken, as a name and a
    number may mean the same line.
    """
    try:
        offset = int(chip.line_offset_from_id(coil.line))
    except (OSError, ValueError) as error:
        raise HardwareError(
            f"{coil.place}: expected a line of {coil.chip}, got {coil.line!r}"
        ) from error
    if offset in taken:
        raise HardwareError(
            f"{coil.place}: expected a line of its own, got {coil.line}, line {offset} of "
            f"{coil.chip}, twice"
        )
    return offset
