"""Does a calibration fit the box and what it is used for: warnings for the user."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from pneumaticbox_driver.channel_calibration import ChannelCalibration, Range
from pneumaticbox_driver.flow_model import PulseCoefficients, flow_rates
from softhand_model.gas import AMBIENT_PRESSURE

MARGIN = 5e3  # of pressures beyond what was calibrated: compressor's cycle, droop, noise [Pa]


def check_calibration(
    channels: Sequence[str],
    calibrations: Sequence[ChannelCalibration],
    box: str = "",
    expected_box: str = "",
    supply: float | None = None,
    pressures: Sequence[float] | None = None,
) -> list[str]:
    """Say what speaks against the use of a calibration.

    Args:
        channels: names.
        calibrations: one a channel.
        box: name of the box in the calibration's file.
        expected_box: name that the user gave to this box; "" for any.
        supply: present gauge supply pressure [Pa]; None leaves it unchecked.
        pressures: present gauge pressures of the channels (n,) [Pa]; None likewise.

    Returns:
        Sentences, none if all is well.
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
    named = zip(channels, calibrations, strict=True)
    shared = [
        f"channels {first} and {second} share one calibration: their estimates drift faster "
        "than with their own"
        for (first, one), (second, other) in combinations(named, 2)
        if (one.inflate, one.deflate) == (other.inflate, other.deflate)
    ]
    if len(shared) > 1:
        return [f"{shared[0]} (and {len(shared) - 1} more such pairs)"]
    return shared


def _negative_flow(name: str, calibration: ChannelCalibration) -> list[str]:
    low, high = (p + AMBIENT_PRESSURE for p in _within(calibration.pressure_range))
    supply = np.array([p + AMBIENT_PRESSURE for p in calibration.supply_range])
    channel = np.array([low, high])
    ends = {
        "inflate": (supply, channel[::-1]),
        "deflate": (channel, np.full(2, AMBIENT_PRESSURE)),
    }
    return [
        f"channel {name}: coefficients of {direction} give a negative flow: calibrate anew"
        for direction, (upstream, downstream) in ends.items()
        if (_flow(getattr(calibration, direction), upstream, downstream) < 0).any()
    ]


def _within(pressure_range: Range) -> Range:
    # a deflation ends at ambient pressure: nothing flows there
    low, high = pressure_range
    return max(low, 1e3), max(high, 1e3)


def _flow(coefficients: PulseCoefficients, upstream: np.ndarray, downstream: np.ndarray):
    friction, injector = flow_rates(upstream, downstream)
    return coefficients.friction * friction + coefficients.injector * injector


def _outside(what: str, value: float, covered: Range) -> list[str]:
    low, high = covered
    if low - MARGIN <= value <= high + MARGIN:
        return []
    kilo = [f"{p / 1e3:.0f}" for p in (value, low, high)]
    return [f"{what} of {kilo[0]} kPa is outside of the {kilo[1]} to {kilo[2]} kPa calibrated"]
