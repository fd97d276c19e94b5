"""Calibration of equation 4.1: what is known of a channel after its test pulses (section 4.4.2)."""

from collections.abc import Sequence
from dataclasses import replace

from pneumaticbox_driver.calibration.file import (
    BoxNote,
    check_calibration,
    load_box_note,
    load_calibration,
    save_calibration,
)
from pneumaticbox_driver.calibration.regression import (
    Pulse,
    PulseFit,
    fit_pulses,
    naive_mass,
    regressors,
)
from pneumaticbox_driver.observer.coefficients import ChannelCalibration, Leak, as_matrix
from softhand_model.gas import AMBIENT_PRESSURE

__all__ = [
    "BoxNote",
    "ChannelCalibration",
    "Leak",
    "Pulse",
    "check_calibration",
    "fit_channel",
    "fit_pulses",
    "load_box_note",
    "load_calibration",
    "naive_mass",
    "regressors",
    "save_calibration",
]


def fit_channel(
    pulses: Sequence[Pulse], leak: Leak | None = None, outlet: int = 0
) -> ChannelCalibration:
    """Fit both directions of a channel.

    Args:
        pulses: recorded pulses of both directions.
        leak: of the channel; what it took during a pulse is put back into the pulse's mass.
        outlet: of the box, counted from 1; 0 if unknown.

    Raises:
        ValueError: as `fit_pulses` does.
    """
    leak = Leak() if leak is None else leak
    tight = [_without_leak(pulse, leak.conductance) for pulse in pulses]
    up, down = (_of_direction(tight, inflating) for inflating in (True, False))
    supplies = [p.pressure_in - AMBIENT_PRESSURE for p in pulses if p.inflating]
    gauges = [(p.pressure_out if p.inflating else p.pressure_in) - AMBIENT_PRESSURE for p in pulses]
    return ChannelCalibration(
        inflate=up.coefficients,
        deflate=down.coefficients,
        residual_inflate=up.residual,
        residual_deflate=down.residual,
        points=len(pulses),
        covariance_inflate=as_matrix(up.covariance),
        covariance_deflate=as_matrix(down.covariance),
        jitter_inflate=up.jitter,
        jitter_deflate=down.jitter,
        delays_inflate=up.delays,
        delays_deflate=down.delays,
        leak=leak,
        supply_range=(float(min(supplies)), float(max(supplies))),
        pressure_range=(float(min(gauges)), float(max(gauges))),
        outlet=outlet,
    )


def _of_direction(pulses: Sequence[Pulse], inflating: bool) -> PulseFit:
    return fit_pulses([pulse for pulse in pulses if pulse.inflating == inflating])


def _without_leak(pulse: Pulse, conductance: float) -> Pulse:
    lost = conductance * pulse.exposure
    return replace(pulse, mass=pulse.mass + (lost if pulse.inflating else -lost))
