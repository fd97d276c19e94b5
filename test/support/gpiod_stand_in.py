"""The part of gpiod 2 that the driver uses, for tests without the package or a chip.

test_lines compares it with the real package where that is installed.
"""

import enum
from dataclasses import dataclass
from types import SimpleNamespace


class Value(enum.Enum):
    INACTIVE = 0
    ACTIVE = 1


class Direction(enum.Enum):
    AS_IS = 1
    INPUT = 2
    OUTPUT = 3


@dataclass
class LineSettings:
    direction: Direction = Direction.AS_IS
    active_low: bool = False
    output_value: Value = Value.INACTIVE


line = SimpleNamespace(Value=Value, Direction=Direction)


class LineRequest:
    def __init__(self, chip, config):
        self.chip, self.live = chip, True
        for offset, settings in config.items():
            assert settings.direction is Direction.OUTPUT
            self._put(offset, settings.output_value, settings.active_low)
        self.low = {offset: settings.active_low for offset, settings in config.items()}

    def _put(self, offset, value, active_low):
        self.chip.levels[offset] = (value is Value.ACTIVE) != active_low

    def set_values(self, values):
        if self.chip.broken:
            raise OSError(5, "Input/output error")
        for offset, value in values.items():
            self._put(offset, value, self.low[offset])

    def release(self):
        self.live = False
        for offset in self.low:
            self.chip.users.pop(offset, None)


class FakeChip:
    """A chip with 32 lines: electrical `levels` of those that were set, `users` of lines."""

    def __init__(self, names=None, users=None):
        self.names, self.users, self.levels, self.broken = names or {}, users or {}, {}, False


class Gpiod:
    """The module: `chips` by path; a path may be an OSError to raise."""

    LineSettings, line = LineSettings, line

    def __init__(self, chips):
        self.chips = chips

    def Chip(self, path):
        chip = self.chips.get(path, FileNotFoundError(2, "No such file or directory"))
        if isinstance(chip, OSError):
            raise chip
        return Chip(chip)


class Chip:
    def __init__(self, chip):
        self._chip = chip

    def __enter__(self):
        return self

    def __exit__(self, exc_type, exc_value, traceback):
        pass

    def line_offset_from_id(self, id):
        if isinstance(id, str):
            if id not in self._chip.names:
                raise FileNotFoundError(2, "No such file or directory")
            return self._chip.names[id]
        if id >= 32:
            raise ValueError("line offset of out range")
        return id

    def request_lines(self, config, consumer=None):
        if any(offset in self._chip.users for offset in config):
            raise OSError(16, "Device or resource busy")
        self._chip.users.update(dict.fromkeys(config, consumer))
        return LineRequest(self._chip, config)
