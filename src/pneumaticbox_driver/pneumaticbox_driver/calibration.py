"""Calibration of equation 4.1: regression over recorded pulses, and its file (section 4.4.2)."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from pneumaticbox_driver.flow_model import TERMS, PulseCoefficients
from softhand_model.document import Node, read_document

Floats = NDArray[np.float64]
SHIPPED = Path(str(resources.files("pneumaticbox_driver"))) / "data" / "calibration.yaml"
FORMAT = "pneumaticbox-calibration/1"
DIRECTIONS = ("inflate", "deflate")
CONDITION_LIMIT = 1e4  # of the scaled design; beyond it the coefficients are noise


@dataclass(frozen=True)
class Pulse:
    """One recorded test pulse; `mass` [kg] is positive from p_in to p_out.

    `friction` and `injector` are the integrals of equation 4.1 [Pa s], `pressure_in` and
    `pressure_out` absolute at switch-on [Pa], `duration` that of the electrical command [s].
    """

    inflating: bool
    duration: float
    friction: float
    injector: float
    pressure_in: float
    pressure_out: float
    mass: float


@dataclass(frozen=True)
class ChannelCalibration:
    """Coefficients of one channel with the RMS residual of each direction [kg] and the points."""

    inflate: PulseCoefficients
    deflate: PulseCoefficients
    residual_inflate: float
    residual_deflate: float
    points: int


def regressors(pulses: Sequence[Pulse]) -> Floats:
    """Design matrix of equation 4.1, columns in the order of `TERMS` (pulses, 5)."""
    return np.array(
        [
            [1.0, pulse.friction, pulse.injector, pulse.pressure_in, pulse.pressure_out]
            for pulse in pulses
        ]
    )


def fit_pulses(pulses: Sequence[Pulse]) -> tuple[PulseCoefficients, float]:
    """Fit the coefficients of one direction by linear regression.

    ERRATUM: for deflation the outlet's column is left out, it is collinear with the bias.

    Args:
        pulses: recorded pulses, all of one direction.

    Returns:
        The coefficients and the RMS residual [kg].

    Raises:
        ValueError: both directions mixed, too few pulses, or a design that leaves terms
            undetermined; the message names them.
    """
    directions = {pulse.inflating for pulse in pulses}
    if len(directions) != 1:
        raise ValueError(f"pulses must be of one direction, got {len(directions)} directions")
    terms = TERMS if directions == {True} else TERMS[:-1]
    design = regressors(pulses)[:, : len(terms)]
    mass = np.array([pulse.mass for pulse in pulses])
    if len(pulses) <= len(terms):
        raise ValueError(f"pulses must be more than {len(terms)}, got {len(pulses)}")
    scale = np.sqrt(np.mean(design**2, axis=0))
    _refuse_singular(design / scale, terms)
    solution = np.linalg.lstsq(design / scale, mass, rcond=None)[0]
    residual = mass - design @ (solution / scale)
    values = dict(zip(terms, (solution / scale).tolist(), strict=True))
    return PulseCoefficients(**values), float(np.sqrt(np.mean(residual**2)))


def _refuse_singular(design: Floats, terms: Sequence[str]) -> None:
    _, singular, directions = np.linalg.svd(design, full_matrices=False)
    if singular[-1] * CONDITION_LIMIT > singular[0]:
        return
    weight = np.abs(directions[-1])
    named = [term for term, w in zip(terms, weight, strict=True) if w > 0.1 * weight.max()]
    raise ValueError(
        f"pulses do not tell {' from '.join(named)}: vary supply, channel pressure and duration"
    )


def fit_channel(pulses: Sequence[Pulse]) -> ChannelCalibration:
    """Fit both directions of a channel; raises ValueError as `fit_pulses` does."""
    up, residual_up = fit_pulses([p for p in pulses if p.inflating])
    down, residual_down = fit_pulses([p for p in pulses if not p.inflating])
    return ChannelCalibration(up, down, residual_up, residual_down, len(pulses))


def naive_mass(pulses: Sequence[Pulse]) -> Floats:
    """Baseline of section 4.4.3: `c p_in(t_on) dt`, c fitted over the same pulses (pulses,) [kg].

    The pulses must be of one direction.
    """
    product = np.array([pulse.pressure_in * pulse.duration for pulse in pulses])
    mass = np.array([pulse.mass for pulse in pulses])
    return product * (product @ mass) / (product @ product)


def save_calibration(path: Path, box: str, channels: Sequence[ChannelCalibration]) -> None:
    """Write the coefficients of a box's channels, in the order of its outlets."""
    content = {
        "format": FORMAT,
        "box": box,
        "channels": [_channel_content(channel) for channel in channels],
    }
    head = "# Equation 4.1 per outlet of the box; written by `calibrate`. SI units.\n"
    path.write_text(head + yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


def _channel_content(channel: ChannelCalibration) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for direction in DIRECTIONS:
        coefficients = getattr(channel, direction)
        content[direction] = {term: _rounded(getattr(coefficients, term)) for term in TERMS}
        content[f"residual_{direction}"] = _rounded(getattr(channel, f"residual_{direction}"))
    content["points"] = channel.points
    return content


def _rounded(value: float) -> float:
    return float(f"{value:.6e}")


def load_calibration(path: str | Path | None, channels: int) -> list[ChannelCalibration]:
    """Read the coefficients of the first `channels` outlets of a box.

    Args:
        path: file written by `save_calibration`; None for that of the pretended box, which is
            shipped.
        channels: how many outlets are in use.

    Raises:
        ValueError: the file cannot be read, has missing or wrong keys, or fewer outlets than
            asked for; the message names file, key, what was expected and what was found.
    """
    source = SHIPPED if path is None else Path(path)
    content = read_document(source, FORMAT).fields(["format", "box", "channels"])
    listed = content["channels"].items()
    if len(listed) < channels:
        raise content["channels"].error(f"at least {channels} outlets, not {len(listed)}")
    return [_read_channel(node) for node in listed[:channels]]


def _read_channel(node: Node) -> ChannelCalibration:
    residuals = [f"residual_{direction}" for direction in DIRECTIONS]
    content = node.fields([*DIRECTIONS, *residuals, "points"])
    values: dict[str, Any] = {name: content[name].number(low=0.0) for name in residuals}
    for direction in DIRECTIONS:
        terms = content[direction].fields(TERMS)
        values[direction] = PulseCoefficients(**{t: terms[t].number() for t in TERMS})
    return ChannelCalibration(points=int(content["points"].number(low=0.0)), **values)
