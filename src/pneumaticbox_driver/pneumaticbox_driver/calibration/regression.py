"""Linear regression of equation 4.1 over test pulses: coefficients with their uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pneumaticbox_driver.arrays import Floats
from pneumaticbox_driver.observer.coefficients import (
    EQUATION_TERMS,
    NOMINAL_DELAYS,
    ChannelCalibration,
    Delays,
    Leak,
    PulseCoefficients,
)
from softhand_model.gas import AMBIENT_PRESSURE

CONDITION_LIMIT = 1e4  # of the scaled design; beyond it the coefficients are noise
REWEIGHTINGS = 4  # the weights have settled by then


@dataclass(frozen=True)
class Pulse:
    """One recorded test pulse; `mass` [kg] is positive from p_in to p_out.

    `friction` and `injector` are the integrals of equation 4.1 [Pa s]. `pressure_in_abs` and
    `pressure_out_abs` are absolute pressures at switch-on, that of the supply at switch-off (see
    `PulseIntegrals`) [Pa]. `duration` is that of the electrical command [s], `noise` the error of
    `mass` by the sensor, one sigma [kg], 0 if unknown, and `exposure` the channel's gauge pressure
    times the time between the two measurements [Pa s], for leaks. `delays` [s] of opening and
    closing are those of the integrals.
    """

    inflating: bool
    duration: float
    friction: float
    injector: float
    pressure_in_abs: float
    pressure_out_abs: float
    mass: float
    noise: float = 0.0
    exposure: float = 0.0
    delays: Delays = NOMINAL_DELAYS


def regressors(pulses: Sequence[Pulse]) -> Floats:
    """Design matrix of equation 4.1, columns in the order of `EQUATION_TERMS` (pulses, 5)."""
    return np.array(
        [
            [1.0, pulse.friction, pulse.injector, pulse.pressure_in_abs, pulse.pressure_out_abs]
            for pulse in pulses
        ]
    )


def fit_channel(
    pulses: Sequence[Pulse], leak: Leak | None = None, outlet: int = 0
) -> ChannelCalibration:
    """Fit both directions of a channel.

    Args:
        pulses: recorded pulses of both directions.
        leak: leak of the channel; the air that leaked during a pulse is added to the pulse's mass.
        outlet: outlet of the box, counted from 1; 0 if unknown.

    Raises:
        ValueError: as `fit_pulses` does.
    """
    leak = Leak() if leak is None else leak
    tight = [_without_leak(pulse, leak.conductance) for pulse in pulses]
    up, down = (_of_direction(tight, inflating) for inflating in (True, False))
    supplies = [p.pressure_in_abs - AMBIENT_PRESSURE for p in pulses if p.inflating]
    gauges = [
        (p.pressure_out_abs if p.inflating else p.pressure_in_abs) - AMBIENT_PRESSURE
        for p in pulses
    ]
    return ChannelCalibration(
        up,
        down,
        points=len(pulses),
        leak=leak,
        supply_range=(float(min(supplies)), float(max(supplies))),
        pressure_range=(float(min(gauges)), float(max(gauges))),
        outlet=outlet,
    )


def _of_direction(pulses: Sequence[Pulse], inflating: bool) -> PulseCoefficients:
    return fit_pulses([pulse for pulse in pulses if pulse.inflating == inflating])


def _without_leak(pulse: Pulse, conductance: float) -> Pulse:
    lost = conductance * pulse.exposure
    return replace(pulse, mass=pulse.mass + (lost if pulse.inflating else -lost))


def fit_pulses(pulses: Sequence[Pulse]) -> PulseCoefficients:
    """Fit the coefficients of one direction by weighted linear regression.

    The weight of a pulse follows from its noise: that of the sensor, which is known, that of the
    valve's delays, which grows with the flow, and the error of equation 4.1, which grows with the
    mass. The latter two are estimated from the residuals. Short pulses, the most frequent ones in
    control, thus have a larger weight than the long ones that move a channel through its range.

    ERRATUM: for deflation the outlet's column is left out, as it is collinear with the bias.

    Args:
        pulses: recorded pulses, all of one direction.

    Raises:
        ValueError: both directions mixed, too few pulses, or terms that the pulses do not
            determine; the message names them.
    """
    directions = {pulse.inflating for pulse in pulses}
    if len(directions) != 1:
        raise ValueError(f"pulses must be of one direction, got {len(directions)} directions")
    terms = EQUATION_TERMS if directions == {True} else EQUATION_TERMS[:-1]
    design = regressors(pulses)[:, : len(terms)]
    mass = np.array([pulse.mass for pulse in pulses])
    if len(pulses) <= len(terms):
        raise ValueError(f"pulses must be more than {len(terms)}, got {len(pulses)}")
    scale = np.sqrt(np.mean(design**2, axis=0))
    refuse_singular(design / scale, terms)
    noise = PulseNoise(pulses, len(terms))
    sigma, solution = noise.sigma, np.zeros(len(terms))
    for _ in range(REWEIGHTINGS):
        solution, inverse = _weighted(design / scale, mass, sigma)
        residual = mass - design @ (solution / scale)
        sigma = noise.update(residual)
    # the noise is known up to a factor, which follows from the residuals
    spread = float(np.sum((residual / sigma) ** 2)) / (len(pulses) - len(terms))
    covariance = np.zeros((len(EQUATION_TERMS), len(EQUATION_TERMS)))
    covariance[: len(terms), : len(terms)] = spread * inverse / np.outer(scale, scale)
    found = dict(zip(terms, (solution / scale).tolist(), strict=True))
    opening, closing = np.mean([pulse.delays for pulse in pulses], axis=0).tolist()
    return PulseCoefficients(
        **found,
        residual=float(np.sqrt(np.mean(residual**2))),
        jitter=noise.jitter,
        delays=(opening, closing),
        covariance=covariance,
    )


def _weighted(design: Floats, mass: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """Solution (k,) and `(X^T W X)^-1` (k, k) of a regression with noise sigma (pulses,)."""
    orthogonal, triangle = np.linalg.qr(design / sigma[:, None])
    solution = np.linalg.solve(triangle, orthogonal.T @ (mass / sigma))
    root = np.linalg.inv(triangle)
    return solution, root @ root.T


class PulseNoise:
    """Standard deviations of the masses of pulses, as `fit_pulses` describes them.

    `sigma` (pulses,) [kg] is the present estimate and `jitter` [s] that of the delays.

    Args:
        pulses: pulses of one direction.
        parameters: number of coefficients that are fitted to these pulses.
    """

    def __init__(self, pulses: Sequence[Pulse], parameters: int) -> None:
        mass = np.array([pulse.mass for pulse in pulses])
        duration = np.array([pulse.duration for pulse in pulses])
        self._sensor = np.array([pulse.noise for pulse in pulses]) ** 2
        self._growing = np.column_stack([(mass / duration) ** 2, mass**2])
        self._freedom = len(pulses) / (len(pulses) - parameters)
        known = self._sensor.all()
        self.sigma: Floats = np.sqrt(self._sensor) if known else np.ones(len(pulses))
        self.jitter = 0.0

    def update(self, residual: Floats) -> Floats:
        """Estimate sigma (pulses,) [kg] from the residuals (pulses,) [kg]."""
        if not self._sensor.all():
            return self.sigma
        # the scatter of a squared residual is proportional to its mean: relative least squares
        weight = 1 / self.sigma**2
        surplus = self._freedom * residual**2 - self._sensor
        shares = _shares(self._growing * weight[:, None], surplus * weight)
        self.jitter = float(np.sqrt(shares[0]))
        self.sigma = np.sqrt(self._sensor + self._growing @ shares)
        return self.sigma


def _shares(columns: Floats, target: Floats) -> Floats:
    """Nonnegative least squares with two columns (rows, 2); returns (2,)."""
    both = np.linalg.lstsq(columns, target, rcond=None)[0]
    if (both >= 0).all():
        return np.asarray(both)
    alone = np.maximum(columns.T @ target, 0.0) / np.sum(columns**2, axis=0)
    # the column that explains more is kept
    alone[int(np.argmin(alone * (columns.T @ target)))] = 0.0
    return np.asarray(alone)


def refuse_singular(design: Floats, terms: Sequence[str]) -> None:
    """Raise ValueError, naming the terms, if a scaled design (pulses, k) is nearly singular."""
    _, singular, directions = np.linalg.svd(design, full_matrices=False)
    if singular[-1] * CONDITION_LIMIT > singular[0]:
        return
    weight = np.abs(directions[-1])
    named = [term for term, w in zip(terms, weight, strict=True) if w > 0.1 * weight.max()]
    raise ValueError(
        f"pulses do not separate {' from '.join(named)}: vary supply, channel pressure and duration"
    )
