"""Constants of the pretended Pneumaticbox, read from one YAML file and checked."""

import math
from dataclasses import dataclass, fields
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

FORMAT = "softhand-pneumatics/1"
Range = tuple[float, float]


@dataclass(frozen=True)
class Valve:
    """A 5/3 valve: ranges of its delays [s], jitter [s] and equivalent orifice [m]."""

    opening_delay: Range
    closing_delay: Range
    delay_jitter: float
    diameter: float


@dataclass(frozen=True)
class Choke:
    """The choke foil: diameters [m], range of discharge coefficients [-], dead volume [m3]."""

    inlet_diameter: float
    outlet_diameter: float
    discharge_coefficient: Range
    dead_volume: float


@dataclass(frozen=True)
class Line:
    """The tube to the actuator: inner diameter [m] and range of lengths [m]."""

    diameter: float
    length: Range


@dataclass(frozen=True)
class Supply:
    """The regulator: gauge set point [Pa], droop [Pa s/kg] and the volume behind it [m3]."""

    pressure: float
    droop: float
    volume: float


@dataclass(frozen=True)
class Sensor:
    """A pressure sensor: full scale [Pa], accuracy [of full scale], noise [Pa], bits, lag [s]."""

    range: float
    accuracy: float
    noise: float
    bits: float
    time_constant: float


@dataclass(frozen=True)
class Pneumatics:
    """All constants of one pneumatic box; `load_pneumatics` reads them.

    `ambient_pressure` is absolute [Pa], `temperature` in [K]; `box_seed` draws the tolerances.
    """

    box_seed: int
    ambient_pressure: float
    temperature: float
    valve: Valve
    choke: Choke
    line: Line
    supply: Supply
    channel_sensor: Sensor
    supply_sensor: Sensor


SECTIONS: dict[str, type] = {
    "valve": Valve,
    "choke": Choke,
    "line": Line,
    "supply": Supply,
    "channel_sensor": Sensor,
    "supply_sensor": Sensor,
}
MAY_BE_ZERO = ("delay_jitter", "noise", "accuracy", "droop")


def load_pneumatics(path: str | Path | None = None) -> Pneumatics:
    """Read the constants of a pneumatic box.

    Args:
        path: YAML file of format `softhand-pneumatics/1`; None for the one that is shipped.

    Raises:
        ValueError: a key is missing, unknown or of the wrong kind; the message names file, key,
            what was expected and what was found.

    >>> load_pneumatics().choke.inlet_diameter
    0.0002
    """
    shipped = resources.files("softhand_model") / "data" / "pneumatics.yaml"
    source = shipped if path is None else Path(path)
    content = yaml.safe_load(source.read_text(encoding="utf-8"))
    name = "pneumatics.yaml" if path is None else str(path)
    top = {"format", *(field.name for field in fields(Pneumatics))}
    _check_keys(name, "", content, top)
    if content["format"] != FORMAT:
        raise ValueError(f"{name}: format: expected {FORMAT}, got {content['format']!r}")
    seed = content["box_seed"]
    if not isinstance(seed, int) or seed < 0:
        raise ValueError(f"{name}: box_seed: expected a whole number >= 0, got {seed!r}")
    return Pneumatics(
        box_seed=seed,
        ambient_pressure=_number(name, "ambient_pressure", content["ambient_pressure"]),
        temperature=_number(name, "temperature", content["temperature"]),
        **{key: _section(name, key, content[key]) for key in SECTIONS},
    )


def _check_keys(name: str, section: str, content: Any, expected: set[str]) -> None:
    label = section or "the file"
    if not isinstance(content, dict):
        raise ValueError(f"{name}: {label}: expected a mapping, got {content!r}")
    for key in sorted(expected ^ set(content)):
        verb = "missing" if key in expected else "unknown"
        raise ValueError(f"{name}: {verb} key {key} in {label}; expected {sorted(expected)}")


def _section(name: str, section: str, content: Any) -> Any:
    kind = SECTIONS[section]
    _check_keys(name, section, content, {field.name for field in fields(kind)})
    values = {}
    for field in fields(kind):
        read = _range if field.type == Range else _number
        values[field.name] = read(name, f"{section}.{field.name}", content[field.name])
    return kind(**values)


def _number(name: str, key: str, value: Any) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    least = 0.0 if key.split(".")[-1] in MAY_BE_ZERO else math.ulp(0.0)
    if not is_number or not math.isfinite(value) or value < least:
        bound = "0 or above" if least == 0.0 else "above 0"
        raise ValueError(f"{name}: {key}: expected a number {bound}, got {value!r}")
    return float(value)


def _range(name: str, key: str, value: Any) -> Range:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{name}: {key}: expected [smallest, largest], got {value!r}")
    low, high = (_number(name, key, item) for item in value)
    if low > high:
        raise ValueError(f"{name}: {key}: expected smallest <= largest, got {value!r}")
    return low, high
