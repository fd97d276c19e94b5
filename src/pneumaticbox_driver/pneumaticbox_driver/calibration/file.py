"""Calibration file: written for a box, read with checks, and compared with its use."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata, resources
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pneumaticbox_driver.observer.coefficients import (
    EQUATION_TERMS,
    VALVE_DIRECTIONS,
    ChannelCalibration,
    Delays,
    Leak,
    PulseCoefficients,
    Range,
    flow_rates,
)
from softhand_common.documents.output_file import write_file
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import Bounds, DocumentError, Node, read_document
from softhand_model.gas import AMBIENT_PRESSURE

SHIPPED_CALIBRATION = (
    Path(str(resources.files("pneumaticbox_driver"))) / "data" / "calibration.yaml"
)
FORMAT = "pneumaticbox-calibration/2"
OLD_FORMAT = "pneumaticbox-calibration/1"
FILE_KEYS = ("format", "box", "date", "version", "ambient", "volume", "outlets")
PER_DIRECTION = ("residual", "jitter", "delays", "covariance")
MOST_OUTLET, MOST_PULSES = 64, 10**9
AMBIENT_BOUNDS, PRESSURE_BOUNDS = Bounds(1e4, 2e5, "Pa"), Bounds(-1e6, 1e8, "Pa")
VOLUME_BOUNDS, DELAY_BOUNDS = Bounds(1e-9, 10.0, "m3"), Bounds(0.0, 1.0, "s")
LARGEST_TERM = 1.0  # of equation 4.1 in SI units: a pulse moves milligrams
RANGE_MARGIN = 5e3  # around the calibrated range: cycle of the compressor, droop, noise [Pa]


@dataclass(frozen=True)
class BoxNote:
    """Content of a calibration file besides the outlets.

    `box` is the name of the box, `date` that of the calibration (ISO 8601), `version` that of this
    package, `ambient` the absolute ambient pressure [Pa], `volume` that on each outlet [m3].
    """

    box: str
    date: str
    version: str
    ambient: float
    volume: float


def save_calibration(
    path: Path,
    box: str,
    channels: Sequence[ChannelCalibration],
    volume: float,
    ambient: float = AMBIENT_PRESSURE,
    date: datetime | None = None,
) -> None:
    """Write the calibrations of a box's channels.

    Args:
        path: file to write.
        box: name of the box.
        channels: calibrations, one per channel; outlets that are unknown are numbered 1, 2 ... in
            order.
        volume: volume on each outlet [m3].
        ambient: absolute ambient pressure [Pa].
        date: date of the calibration; None: now.

    Raises:
        UnwritableFile: the file cannot be written; an earlier one is unchanged.
    """
    made = datetime.now(UTC) if date is None else date
    content = {
        "format": FORMAT,
        "box": box,
        "date": made.isoformat(timespec="seconds"),
        "version": package_version(),
        "ambient": ambient,
        "volume": volume,
        "outlets": [_content(k, channel) for k, channel in enumerate(channels, start=1)],
    }
    head = "# Equation 4.1 per outlet of the box; written by `calibrate`. SI units.\n"
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
    write_file(path, head + text)


def package_version() -> str:
    """Version of the driver's package; "unknown" if it is not installed."""
    try:
        return metadata.version("pneumaticbox_driver")
    except metadata.PackageNotFoundError:
        return "unknown"


def _content(place: int, channel: ChannelCalibration) -> dict[str, Any]:
    content: dict[str, Any] = {"outlet": channel.outlet or place, "points": channel.points}
    for direction in VALVE_DIRECTIONS:
        fit = getattr(channel, direction)
        content[direction] = {
            **{
                name: _rounded(getattr(fit, name))
                for name in (*EQUATION_TERMS, "residual", "jitter")
            },
            "delays": _listed(fit.delays),
            "covariance": [_listed(row) for row in fit.covariance.tolist()],
        }
    content["leak"] = {
        "conductance": _rounded(channel.leak.conductance),
        "error": _rounded(channel.leak.error),
    }
    content["supply_range"] = _listed(channel.supply_range)
    content["pressure_range"] = _listed(channel.pressure_range)
    return content


def _rounded(value: float) -> float:
    return float(f"{value:.8e}")


def _listed(values: Iterable[float]) -> list[float]:
    return [_rounded(value) for value in values]


def load_calibration(
    path: str | Path | None, channels: int, outlets: Sequence[int] | None = None
) -> list[ChannelCalibration]:
    """Read the calibrations of the outlets that channels use.

    Args:
        path: file written by `save_calibration`; None for the shipped one of the simulated box.
        channels: number of channels.
        outlets: number of each channel's outlet, from 1; None for 1 to `channels`.

    Raises:
        ValueError: the file cannot be read, is of another format, has missing or wrong keys, or
            lacks an outlet; the message names file, key, what was expected and what was found.
    """
    wanted = list(range(1, channels + 1)) if outlets is None else list(outlets)
    if len(wanted) != channels:
        raise ValueError(
            f"outlets must have {channels} entries, one per channel, got {len(wanted)}"
        )
    listing = _read(path)["outlets"]
    nodes = _by_outlet(listing)
    lacking = [outlet for outlet in wanted if outlet not in nodes]
    if lacking:
        raise listing.error(f"outlet {lacking[0]}", listed(nodes))
    return [_read_channel(outlet, nodes[outlet]) for outlet in wanted]


def _by_outlet(listing: Node) -> dict[int, Node]:
    nodes: dict[int, Node] = {}
    for node in listing.items():
        if "outlet" not in node.mapping():
            raise node.error("a mapping with the key outlet")
        number = node.mapping()["outlet"]
        if number.whole(1, MOST_OUTLET) in nodes:
            raise number.error("every outlet once")
        nodes[number.value] = node
    return nodes


def load_box_note(path: str | Path | None) -> BoxNote:
    """Read the entries of a calibration file about its box; raises as `load_calibration`."""
    content = _read(path)
    texts = {name: content[name].text() for name in ("box", "date", "version")}
    return BoxNote(
        ambient=content["ambient"].within(AMBIENT_BOUNDS),
        volume=content["volume"].within(VOLUME_BOUNDS),
        **texts,
    )


def _read(path: str | Path | None) -> dict[str, Node]:
    source = SHIPPED_CALIBRATION if path is None else Path(path)
    document = read_document(source)
    given = document.mapping().get("format")
    if given is not None and given.value == OLD_FORMAT:
        raise DocumentError(
            f"{given.place}: expected {FORMAT}, got {OLD_FORMAT}, which has no uncertainties: "
            "make a new file with the command `calibrate --output FILE`"
        )
    if given is not None:
        given.choice([FORMAT])
    return document.fields(FILE_KEYS)


def _read_channel(outlet: int, node: Node) -> ChannelCalibration:
    content = node.fields(
        ["outlet", "points", *VALVE_DIRECTIONS, "leak", "supply_range", "pressure_range"]
    )
    leak = content["leak"].fields(["conductance", "error"])
    return ChannelCalibration(
        points=content["points"].whole(0, MOST_PULSES),
        leak=Leak(leak["conductance"].number(0.0, 1.0), leak["error"].number(0.0, 1.0)),
        supply_range=_read_range(content["supply_range"]),
        pressure_range=_read_range(content["pressure_range"]),
        outlet=outlet,
        **{direction: _read_direction(content[direction]) for direction in VALVE_DIRECTIONS},
    )


def _read_direction(node: Node) -> PulseCoefficients:
    content = node.fields([*EQUATION_TERMS, *PER_DIRECTION])
    rows = content["covariance"].items()
    if len(rows) != len(EQUATION_TERMS):
        raise content["covariance"].error(f"{len(EQUATION_TERMS)} rows")
    return PulseCoefficients(
        **{term: content[term].number(-LARGEST_TERM, LARGEST_TERM) for term in EQUATION_TERMS},
        residual=content["residual"].number(0.0, LARGEST_TERM),
        jitter=content["jitter"].within(DELAY_BOUNDS),
        delays=_delays(content["delays"]),
        covariance=_covariance(content["covariance"], rows),
    )


def _delays(node: Node) -> Delays:
    opening, closing = node.vector(2, DELAY_BOUNDS)
    return opening, closing


def _covariance(node: Node, rows: list[Node]) -> np.ndarray:
    found = np.array([row.vector(len(EQUATION_TERMS)) for row in rows])
    if np.any(np.diag(found) < 0.0):
        raise node.error(
            "a covariance matrix with variances of 0 or more on its diagonal",
            str(np.diag(found).tolist()),
        )
    return found


def _read_range(node: Node) -> Range:
    low, high = node.vector(2, PRESSURE_BOUNDS)
    if low > high:
        raise node.error("[smallest, largest]")
    return low, high


def check_calibration(
    channels: Sequence[str],
    calibrations: Sequence[ChannelCalibration],
    box: str = "",
    expected_box: str = "",
    supply: float | None = None,
    pressures: Sequence[float] | None = None,
) -> list[str]:
    """Check whether a calibration fits its use.

    Args:
        channels: names of the channels.
        calibrations: one per channel.
        box: name of the box in the calibration's file.
        expected_box: name of the user's box; "": any name is accepted.
        supply: present gauge supply pressure [Pa]; None: not checked.
        pressures: present gauge pressures of the channels (n,) [Pa]; None: not checked.

    Returns:
        Warnings, none if the calibration fits.
    """
    warnings = _shared(channels, calibrations)
    if expected_box and box != expected_box:
        warnings.append(f"calibration is of the box {box!r}, not of {expected_box!r}")
    for k, (name, calibration) in enumerate(zip(channels, calibrations, strict=True)):
        warnings += _negative_flow(name, calibration)
        if supply is not None:
            warnings += _outside(f"channel {name}: supply", supply, calibration.supply_range)
        if pressures is not None:
            here = f"channel {name}: pressure"
            warnings += _outside(here, pressures[k], calibration.pressure_range)
    return warnings


def _shared(channels: Sequence[str], calibrations: Sequence[ChannelCalibration]) -> list[str]:
    terms = [(c.inflate.as_array().tolist(), c.deflate.as_array().tolist()) for c in calibrations]
    named = zip(channels, terms, strict=True)
    shared = [
        f"channels {first} and {second} share one calibration: their estimates drift faster "
        "than with their own"
        for (first, one), (second, other) in combinations(named, 2)
        if one == other
    ]
    if len(shared) > 1:
        return [f"{shared[0]} (and {len(shared) - 1} more such pairs)"]
    return shared


def _negative_flow(name: str, calibration: ChannelCalibration) -> list[str]:
    low, high = (p + AMBIENT_PRESSURE for p in _within(calibration.pressure_range))
    supply = np.array([p + AMBIENT_PRESSURE for p in calibration.supply_range])
    channel = np.array([low, high])
    ends = {"inflate": (supply, channel[::-1]), "deflate": (channel, np.full(2, AMBIENT_PRESSURE))}
    return [
        f"channel {name}: coefficients of {direction} give a negative flow: calibrate anew"
        for direction, (upstream, downstream) in ends.items()
        if (_flow(getattr(calibration, direction), upstream, downstream) < 0).any()
    ]


def _within(pressure_range: Range) -> Range:
    # a deflation ends at ambient pressure: nothing flows there
    low, high = pressure_range
    return max(low, 1e3), max(high, 1e3)


def _flow(
    coefficients: PulseCoefficients, upstream: np.ndarray, downstream: np.ndarray
) -> np.ndarray:
    friction, injector = flow_rates(upstream, downstream)
    return coefficients.friction * friction + coefficients.injector * injector


def _outside(what: str, value: float, covered: Range) -> list[str]:
    low, high = covered
    if low - RANGE_MARGIN <= value <= high + RANGE_MARGIN:
        return []
    kilo = [f"{p / 1e3:.0f}" for p in (value, low, high)]
    return [f"{what} of {kilo[0]} kPa is outside of the {kilo[1]} to {kilo[2]} kPa calibrated"]
