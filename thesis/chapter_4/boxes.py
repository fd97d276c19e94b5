"""Simulated boxes, their calibration as a user would do it, and the limits of their valves: mass of
the smallest pulse, flow of an open inlet.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.calibration.recording import (
    PulseDurations,
    PulseRanges,
    Sample,
    record_pulses,
)
from pneumaticbox_driver.calibration.regression import Pulse
from pneumaticbox_driver.calibration.run import CalibrationPlan, CalibrationRun
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics, load_pneumatics
from thesis.frame import Array, Progress

OUTLETS = "abcdefgh"
PERIOD = 0.002  # of the sensor samples [s]
BOTTLE = 0.5e-3  # of section 4.4.3 [m3]
REGULATING = 3.0  # for the reservoir to follow the regulator [s]
SUPPLIES = (260e3, 320e3)  # of section 4.4.3, gauge [Pa]
WORKING = 25e3  # gauge pressure in the channels, about a finger's [Pa]
SETTLING = 0.75  # after a test pulse: 10 to 30 min for 400 to 1600 points (section 4.4.2) [s]
WAITING = 0.5  # after a pulse, so that its dead volume has emptied, and the regulator rests [s]
OPEN = 0.5  # of the pulse that the flow is taken from [s]
SETTLED = 0.1  # of it, before the flow is steady [s]
AVERAGED = 5  # pulses of a direction


def box_of(seed: int, preset: str = "pneumaticbox") -> Pneumatics:
    """Constants of a box by its number; 0 is the preset, others are drawn from the tolerances."""
    constants = load_pneumatics(preset)
    return replace(constants, box_seed=constants.box_seed + seed)


def record(
    box: Pneumatics,
    channels: int,
    points: int,
    supplies: Sequence[float],
    seed: int,
    progress: Progress,
) -> list[list[Pulse]]:
    """Record test pulses of Algorithm 1 on bottles, all channels at once.

    Args:
        box: constants of the plant.
        channels: number of outlets.
        points: pulses per channel, both directions and all supplies together.
        supplies: gauge supply pressures, one after the other [Pa].
        seed: of the pulses and the noise.
        progress: is told.

    Returns:
        The pulses per channel.

    Raises:
        ValueError: fewer points than an inflation and a deflation at each supply pressure.
    """
    cycles = points // (2 * len(supplies))
    if cycles < 1:
        raise ValueError(f"points must be at least {2 * len(supplies)}, got {points}")
    pulses: list[list[Pulse]] = [[] for _ in range(channels)]
    for level, supply in enumerate(supplies):
        stream = 1000 * seed + level
        rig = EmbeddedRig(OUTLETS[:channels], np.full(channels, BOTTLE), box, stream)
        rig.plant.set_supply(supply)
        recorded = _recorded(rig, PulseDurations(PulseRanges(), channels, stream), channels, cycles)
        for channel, more in zip(pulses, recorded, strict=True):
            channel += more
        progress("test pulses", (level + 1) / len(supplies))
    return pulses


def _recorded(
    rig: EmbeddedRig, durations: PulseDurations, channels: int, cycles: int
) -> list[list[Pulse]]:
    recording = record_pulses(durations, channels, cycles, BOTTLE, SETTLING)
    valves = next(recording)
    while True:
        rig.command(valves)
        readings = rig.advance(PERIOD)
        try:
            valves = recording.send(Sample.of(rig.time, readings))
        except StopIteration as end:
            return list(end.value)


def calibrated(
    box: Pneumatics,
    channels: int,
    points: int,
    seed: int,
    progress: Progress,
    supplies: Sequence[float] = SUPPLIES,
    pulses: PulseRanges | None = None,
) -> list[ChannelCalibration]:
    """Calibrate a box on bottles as a user does, changing the supply pressure when asked to.

    The bottles are known to be tight: there is no leak test.

    Args:
        box: constants of the plant.
        channels: number of outlets.
        points: pulses per channel, both directions and all supplies together.
        seed: of the pulses and the noise.
        progress: called with the current activity and the share done.
        supplies: gauge supply pressures, one after the other [Pa].
        pulses: ranges of their durations; None for the driver's.

    Raises:
        ValueError: too few points, or pulses that do not determine the coefficients.
    """
    ranges = pulses or PulseRanges()
    plan = CalibrationPlan(points, len(supplies), ranges, settling=SETTLING, leak_test=0.0)
    run = CalibrationRun(OUTLETS[:channels], np.full(channels, BOTTLE), plan, seed)
    rig = EmbeddedRig(OUTLETS[:channels], np.full(channels, BOTTLE), box, seed)
    for supply in supplies:
        rig.plant.set_supply(supply)
        _play(rig, run, REGULATING)
        if run.state == "waiting":
            run.next()
        while run.state == "running":
            _play(rig, run, PERIOD)
            progress("calibration", run.progress)
    return run.result


def _play(rig: EmbeddedRig, run: CalibrationRun, duration: float) -> None:
    """Answer the run's samples for a time [s]; a run that waits keeps the valves closed."""
    for _ in range(round(duration / PERIOD)):
        readings = rig.advance(PERIOD)
        rig.command(run.on_sample(Sample.of(rig.time, readings)))


def smallest_steps(constants: Pneumatics, channels: int, pulse: float, seed: int) -> Array:
    """Mass that pulses move on bottles at working pressure, by the plant's truth.

    Args:
        constants: of the plant.
        channels: number of outlets.
        pulse: duration of the electrical command [s].
        seed: of the jitter.

    Returns:
        What an inflating pulse brings and what a deflating one takes (2, channels) [kg].
    """
    rig = _at_work(constants, channels, seed)
    moved = np.zeros((2, channels))
    for _ in range(AVERAGED):
        for row, direction in enumerate((1, -1)):
            before = rig.mass
            _hold(rig, direction, pulse)
            _hold(rig, 0, WAITING)
            moved[row] += direction * (rig.mass - before)
    return moved / AVERAGED


def inlet_flows(constants: Pneumatics, channels: int, seed: int) -> Array:
    """Steady mass flow into bottles at working pressure through open inlets (channels,) [kg/s].

    One inlet is open at a time: with several, the regulator's pressure would drop.
    """
    flows = np.zeros(channels)
    for channel in range(channels):
        rig = _at_work(constants, channels, seed)
        alone = np.zeros(channels)
        alone[channel] = 1
        _hold(rig, alone, SETTLED)
        before = rig.mass
        _hold(rig, alone, OPEN - SETTLED)
        flows[channel] = (rig.mass - before)[channel] / (OPEN - SETTLED)
    return flows


def _at_work(constants: Pneumatics, channels: int, seed: int) -> EmbeddedRig:
    rig = EmbeddedRig(OUTLETS[:channels], np.full(channels, BOTTLE), constants, seed)
    rig.plant.fill(rig.plant.mass + air_mass(WORKING, BOTTLE))
    _hold(rig, 0, WAITING)
    return rig


def _hold(rig: EmbeddedRig, valves: Array | int, duration: float) -> None:
    """Command valves for a time [s]."""
    for _ in range(round(duration / PERIOD)):
        rig.command(np.broadcast_to(np.asarray(valves), (len(rig.mass),)))
        rig.advance(PERIOD)
