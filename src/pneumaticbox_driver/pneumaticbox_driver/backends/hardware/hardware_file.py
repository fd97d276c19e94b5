"""Hardware file: the wiring of a box, read from YAML and checked."""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softhand_common.documents.quoted import quoted
from softhand_common.documents.yaml_document import Bounds, Node, read_document

FORMAT = "pneumaticbox-hardware/1"
LINUX = "linux"
ALLOW_BOARD_MODULE = "--allow-board-module"  # option of `softhand hardware`
REFERENCES = ("gauge", "absolute")
MOST_OUTLETS = 8
LONGEST_VENT = 10.0  # [s]
MOST_LINE = 10_000  # numbers of GPIO lines and analog inputs
SENSOR_GAIN, SENSOR_OFFSET = Bounds(1.0, 1e9, "Pa/V"), Bounds(-1e9, 1e9, "Pa")
SENSOR_VOLTAGE, DIVIDER = Bounds(1e-9, 1e3, "V"), Bounds(1e-4, 1.0, "")


class HardwareError(ValueError):
    """A device is missing, must not be used or has failed."""


@dataclass(frozen=True)
class Coil:
    """A GPIO line: path of its chip, number or name of the line, and its `place` in the file."""

    place: str
    chip: str
    line: int | str
    active_low: bool


@dataclass(frozen=True)
class SensorType:
    """Linear characteristic of a sensor: `gain` [Pa/V] and `offset` [Pa].

    `reference` is gauge or absolute; `output` is the range of voltages [V] of a working sensor.
    """

    gain: float
    offset: float
    reference: str
    output: tuple[float, float]


@dataclass(frozen=True)
class Sensor:
    """A sensor on the analog input number `input`; a voltage divider passes the share `divider`."""

    place: str
    type: SensorType
    input: int
    divider: float


@dataclass(frozen=True)
class Outlet:
    """An outlet of the box: the two coils of its valve and its pressure sensor."""

    inflate: Coil
    deflate: Coil
    sensor: Sensor


@dataclass(frozen=True)
class Converter:
    """The analog inputs: an IIO device below `sysfs`, given by its name or folder.

    `scale` is in [V per count], None for that of the device; `full_scale` [V] is the largest input.
    """

    place: str
    sysfs: Path
    device: str
    scale: float | None
    full_scale: float


@dataclass(frozen=True)
class LinuxHardware:
    """Valves on GPIO lines and sensors on IIO inputs; `close` vents for `vent_time` [s]."""

    outlets: tuple[Outlet, ...]
    supply: Sensor
    converter: Converter
    vent_time: float

    @property
    def coils(self) -> tuple[Coil, ...]:
        """All coils of the box: inflate and deflate of the first outlet, of the second, ..."""
        return tuple(coil for outlet in self.outlets for coil in (outlet.inflate, outlet.deflate))


@dataclass(frozen=True)
class OtherHardware:
    """A user's board: `board` is the YAML node `module:Class`, `settings` its keyword arguments."""

    board: Node
    settings: Node | None
    vent_time: float


def read_hardware(
    path: str | Path, allow_board_module: bool = False
) -> LinuxHardware | OtherHardware:
    """Read the wiring of a box.

    Args:
        path: YAML file of format `pneumaticbox-hardware/1`.
        allow_board_module: whether it may name a user's board, whose Python module is run.

    Raises:
        ValueError: the file cannot be read, a key is missing, unknown or of the wrong kind, a line
            or an input is used twice, or the output of a sensor exceeds its input; the message
            names file, key, what was expected and what was found.
    """
    document = read_document(Path(path), FORMAT)
    board = document.mapping().get("board")
    if board is not None and board.text() != LINUX:
        if not allow_board_module:
            raise board.error(
                f"{LINUX}; if you trust the code of another board, allow it by "
                f"{ALLOW_BOARD_MODULE}, or by the driver's parameter allow_board_module: true"
            )
        return _other_hardware(document)
    return _linux_hardware(document)


def _other_hardware(document: Node) -> OtherHardware:
    content = document.fields(["format", "board", "vent_time"], ["settings"])
    settings = content.get("settings")
    if settings is not None:
        settings.mapping()
    return OtherHardware(content["board"], settings, _vent_time(content["vent_time"]))


def _linux_hardware(document: Node) -> LinuxHardware:
    content = document.fields(
        ["format", "board", "vent_time", "gpio", "outlets", "supply", "converter", "sensor_types"]
    )
    types = {name: _sensor_type(node) for name, node in content["sensor_types"].mapping().items()}
    converter = _converter(content["converter"])
    gpio = content["gpio"].fields(["chip", "active_low"])
    chip, active_low = gpio["chip"].text(), _flag(gpio["active_low"])
    listed = content["outlets"].items()
    if not 1 <= len(listed) <= MOST_OUTLETS:
        raise content["outlets"].error(f"1 to {MOST_OUTLETS} outlets")
    outlets = tuple(_outlet(node, chip, active_low, types, converter) for node in listed)
    supply = _sensor(content["supply"], types, converter)
    hardware = LinuxHardware(outlets, supply, converter, _vent_time(content["vent_time"]))
    _refuse_twice("line", ((coil.place, (coil.chip, coil.line)) for coil in hardware.coils))
    sensors = [*(outlet.sensor for outlet in outlets), supply]
    _refuse_twice("input", ((f"{sensor.place}.input", sensor.input) for sensor in sensors))
    return hardware


def _vent_time(node: Node) -> float:
    return node.number(0.0, LONGEST_VENT)


def _sensor_type(node: Node) -> SensorType:
    content = node.fields(["gain", "offset", "reference", "output"])
    low, high = content["output"].vector(2, SENSOR_VOLTAGE)
    if not 0 < low < high:
        raise content["output"].error("[smallest, largest] above 0 V")
    return SensorType(
        gain=content["gain"].within(SENSOR_GAIN),
        offset=content["offset"].within(SENSOR_OFFSET),
        reference=content["reference"].choice(REFERENCES),
        output=(low, high),
    )


def _converter(node: Node) -> Converter:
    content = node.fields(["sysfs", "device", "full_scale"], ["scale"])
    return Converter(
        place=node.place,
        sysfs=Path(content["sysfs"].text()),
        device=content["device"].text(),
        scale=content["scale"].within(SENSOR_VOLTAGE) if "scale" in content else None,
        full_scale=content["full_scale"].within(SENSOR_VOLTAGE),
    )


def _outlet(
    node: Node, chip: str, active_low: bool, types: dict[str, SensorType], converter: Converter
) -> Outlet:
    content = node.fields(["inflate", "deflate", "sensor"], ["chip", "active_low"])
    chip = content["chip"].text() if "chip" in content else chip
    active_low = _flag(content["active_low"]) if "active_low" in content else active_low
    coils = {
        name: Coil(content[name].place, chip, _line(content[name]), active_low)
        for name in ("inflate", "deflate")
    }
    return Outlet(sensor=_sensor(content["sensor"], types, converter), **coils)


def _sensor(node: Node, types: dict[str, SensorType], converter: Converter) -> Sensor:
    content = node.fields(["type", "input", "divider"])
    kind = types[content["type"].choice(types)]
    divider = content["divider"].within(DIVIDER)
    most = min(1.0, converter.full_scale / kind.output[1])
    if divider > most:
        raise content["divider"].error(
            f"at most {most:.4g}, so that {kind.output[1]:g} V of the sensor stay within "
            f"{converter.full_scale:g} V of the input"
        )
    return Sensor(node.place, kind, content["input"].whole(0, MOST_LINE), divider)


def _line(node: Node) -> int | str:
    return (
        node.text()
        if isinstance(node.value, str)
        else node.whole(0, MOST_LINE, " or a line's name")
    )


def _flag(node: Node) -> bool:
    if not isinstance(node.value, bool):
        raise node.error("true or false")
    return node.value


def _refuse_twice(kind: str, used: Iterable[tuple[str, Hashable]]) -> None:
    seen: dict[Any, str] = {}
    for place, what in used:
        if what in seen:
            first = seen[what].rpartition(": ")[2]
            raise ValueError(
                f"{place}: expected an unused {kind}, got that of {first}: {quoted(what)}"
            )
        seen[what] = place
