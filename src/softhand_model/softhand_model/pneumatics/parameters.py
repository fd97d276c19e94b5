"""Constants of the simulated Pneumaticbox, read from one YAML file and checked."""

from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.yaml_document import Bounds, Node, read_document
from softhand_common.numerics.arrays import Array
from softhand_model.data_files import data_file

FORMAT = "softhand-pneumatics/1"
Range = tuple[float, float]


@dataclass(frozen=True)
class Valve:
    """A 5/3 valve: ranges of its delays [s], their jitter [s], and the diameter of the equivalent
    orifice [m].
    """

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
    """The pressure regulator: gauge set point [Pa], droop (loss of pressure per flow) [Pa s/kg],
    and the volume behind it [m3].
    """

    pressure: float
    droop: float
    volume: float


@dataclass(frozen=True)
class Compressor:
    """The compressor before the regulator: tank [m3], gauge pressures [Pa] of its start and stop.

    `delivery` [kg/s] while it runs; `passed` is the share of a change of the tank's pressure that
    the regulator passes on [-].
    """

    tank_volume: float
    cut_in: float
    cut_out: float
    delivery: float
    passed: float


@dataclass(frozen=True)
class Leak:
    """Leaks of the channels: range of conductances to the surroundings [kg/(s Pa)]."""

    conductance: Range


@dataclass(frozen=True)
class Gas:
    """Air in the channels: time constant [s] with which it takes on the temperature of the walls, 0
    for isothermal air.

    The time is that of a channel of `thermal_volume` [m3]. In smaller ones of the same shape the
    way to the walls is shorter: by conduction the time goes with the square of their size. With a
    `thermal_volume` of 0 it is the same in all.
    """

    thermal_time_constant: float
    thermal_volume: float = 0.0

    def time_constants(self, volumes: Array) -> Array:
        """Time constants (n,) [s] of channels with these `volumes` (n,) [m3].

        >>> Gas(0.6, 5e-4).time_constants(np.array([5e-4, 4e-6])).round(3).tolist()
        [0.6, 0.024]
        """
        if not self.thermal_volume:
            return np.full(len(volumes), self.thermal_time_constant)
        size = (volumes / self.thermal_volume) ** (1 / 3)
        return np.asarray(self.thermal_time_constant * size**2)


@dataclass(frozen=True)
class Relief:
    """A mechanical relief valve: opens at `margin` [-] times the limit of its channel.

    Its gauge pressure has to rise by the share `accumulation` [-] until it is wide open, an
    orifice of `diameter` [m].
    """

    margin: float
    accumulation: float
    diameter: float

    def pressures(self, limits: ArrayLike) -> Array:
        """Gauge pressures (n,) [Pa] at which the valves begin to open.

        Args:
            limits: of the channels, gauge (n,) [Pa].

        >>> Relief(1.3, 0.1, 2e-3).pressures([100e3]).tolist()
        [130000.0]
        """
        return self.margin * np.asarray(limits, dtype=float)


@dataclass(frozen=True)
class Sensor:
    """A pressure sensor: gauge full scale `range` [Pa], accuracy as a share of it [-], standard
    deviation of the noise [Pa], bits of the converter, time constant [s].
    """

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
    compressor: Compressor
    leak: Leak
    gas: Gas
    relief: Relief
    channel_sensor: Sensor
    supply_sensor: Sensor


PNEUMATICS_PARTS: dict[str, type] = {
    "valve": Valve,
    "choke": Choke,
    "line": Line,
    "supply": Supply,
    "compressor": Compressor,
    "leak": Leak,
    "gas": Gas,
    "relief": Relief,
    "channel_sensor": Sensor,
    "supply_sensor": Sensor,
}
MAY_BE_ZERO = {"delay_jitter", "noise", "accuracy", "droop", "conductance"}
MAY_BE_ZERO |= {"thermal_time_constant", "thermal_volume"}
DELAY_BOUNDS, DIAMETER_BOUNDS = Bounds(0.0, 1.0, "s"), Bounds(1e-5, 0.1, "m")
SUPPLY_BOUNDS = Bounds(1e3, 1e8, "Pa")
PNEUMATICS_BOUNDS = {
    **dict.fromkeys(("opening_delay", "closing_delay", "delay_jitter"), DELAY_BOUNDS),
    **dict.fromkeys(("diameter", "inlet_diameter", "outlet_diameter"), DIAMETER_BOUNDS),
    **dict.fromkeys(("pressure", "cut_in", "cut_out", "range"), SUPPLY_BOUNDS),
    **dict.fromkeys(("dead_volume", "volume", "tank_volume"), Bounds(1e-10, 10.0, "m3")),
    "discharge_coefficient": Bounds(0.01, 2.0, ""),
    "length": Bounds(1e-3, 1e3, "m"),
    "droop": Bounds(0.0, 1e12, "Pa s/kg"),
    "delivery": Bounds(1e-9, 10.0, "kg/s"),
    "passed": Bounds(0.0, 1.0, ""),
    "conductance": Bounds(0.0, 1e-3, "kg/(s Pa)"),
    "thermal_time_constant": Bounds(0.0, 1e5, "s"),
    "thermal_volume": Bounds(0.0, 10.0, "m3"),
    "margin": Bounds(1.0, 100.0, ""),
    "accumulation": Bounds(1e-6, 100.0, ""),
    "accuracy": Bounds(0.0, 1.0, "of full scale"),
    "noise": Bounds(0.0, 1e6, "Pa"),
    "bits": Bounds(1.0, 24.0, ""),
    "time_constant": Bounds(1e-9, 10.0, "s"),
}  # what each constant can be; wider than any box
MOST_SEED = 2**63 - 1
AMBIENT_BOUNDS, TEMPERATURE_BOUNDS = Bounds(1e4, 2e5, "Pa"), Bounds(200.0, 500.0, "K")


PRESETS = {"pneumaticbox": "pneumatics.yaml", "ideal": "pneumatics_ideal.yaml"}
DEFAULT = "ideal"


def load_pneumatics(path: str | Path | None = None) -> Pneumatics:
    """Read the constants of a pneumatic box.

    Args:
        path: YAML file of format `softhand-pneumatics/1`, or the name of a shipped one:
            `pneumaticbox`, with the figures of the thesis and of data sheets, or `ideal`, with
            isothermal air, as the thesis assumes for a hand (section 4.2). None: `ideal`.

    Raises:
        ValueError: a key is missing, unknown or of the wrong kind; the message names file, key,
            what was expected and what was found.

    >>> load_pneumatics().gas.thermal_time_constant
    0.0
    >>> load_pneumatics("pneumaticbox").gas.thermal_time_constant
    0.5
    """
    given = DEFAULT if path is None else str(path)
    source = data_file(PRESETS[given]) if given in PRESETS else Path(given)
    scalars = ("box_seed", "ambient_pressure", "temperature")
    content = read_document(source, FORMAT).fields(["format", *scalars, *PNEUMATICS_PARTS])
    sections = {key: _section(content[key], kind) for key, kind in PNEUMATICS_PARTS.items()}
    _check_compressor(content["compressor"], sections["compressor"])
    return Pneumatics(
        box_seed=content["box_seed"].whole(0, MOST_SEED),
        ambient_pressure=content["ambient_pressure"].within(AMBIENT_BOUNDS),
        temperature=content["temperature"].within(TEMPERATURE_BOUNDS),
        **sections,
    )


def _section(node: Node, kind: type) -> Any:
    types = {field.name: field.type for field in fields(kind)}
    optional = [field.name for field in fields(kind) if field.default is not MISSING]
    given = node.fields([name for name in types if name not in optional], optional)
    return kind(
        **{
            name: _range(name, value) if types[name] == Range else _scalar(name, value)
            for name, value in given.items()
        }
    )


def _scalar(name: str, node: Node) -> float:
    if name in PNEUMATICS_BOUNDS:
        return node.within(PNEUMATICS_BOUNDS[name])
    return node.number(low=0.0) if name in MAY_BE_ZERO else node.positive()


def _range(name: str, node: Node) -> Range:
    low, high = node.vector(2, PNEUMATICS_BOUNDS.get(name))
    if name in MAY_BE_ZERO and not 0 <= low <= high:
        raise node.error("[smallest, largest] of at least 0")
    if name not in MAY_BE_ZERO and not 0 < low <= high:
        raise node.error("[smallest, largest] above 0")
    return low, high


def _check_compressor(node: Node, compressor: Compressor) -> None:
    fields = node.mapping()
    if not compressor.cut_in < compressor.cut_out:
        raise fields["cut_out"].error(f"a number above cut_in, {compressor.cut_in:g}")
