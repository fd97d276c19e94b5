"""Pretended boxes of the experiments: which one, and its calibration as a user would make it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.calibration import ChannelCalibration, Pulse, fit_channel
from pneumaticbox_driver.experiments.report import Progress
from pneumaticbox_driver.recording import Sample, record_pulses
from pneumaticbox_driver.see_saw import SeeSaw, SeeSawPlan
from softhand_model.pneumatics import Pneumatics, load_pneumatics

OUTLETS = "abcdefgh"
PERIOD = 0.002  # of the sensor samples [s]
BOTTLE = 0.5e-3  # of section 4.4.3 [m3]
SUPPLIES = (260e3, 320e3)  # of section 4.4.3, gauge [Pa]


def box_of(seed: int, constants: Pneumatics | None = None) -> Pneumatics:
    """Constants of box number `seed`; 0 is the one that is shipped, others have other tolerances.

    Args:
        seed: number of the box.
        constants: with which to start; None for those that are shipped.
    """
    constants = load_pneumatics() if constants is None else constants
    return replace(constants, box_seed=constants.box_seed + seed)


def record(
    box: Pneumatics,
    channels: int,
    points: int,
    supplies: Sequence[float],
    seed: int,
    progress: Progress,
    plan: SeeSawPlan | None = None,
    volume: float = BOTTLE,
) -> list[list[Pulse]]:
    """Record test pulses of Algorithm 1 on bottles, all channels at once.

    Args:
        box: constants of the plant.
        channels: number of outlets.
        points: pulses per channel, both directions and all supplies together.
        supplies: gauge supply pressures, one after the other [Pa].
        seed: of the pulses and the noise.
        progress: is told.
        plan: ranges of the pulses.
        volume: of the bottles [m3].

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
        bench = EmbeddedBench(OUTLETS[:channels], np.full(channels, volume), box, stream)
        bench.plant.set_supply(supply)
        see_saw = SeeSaw(plan or SeeSawPlan(), channels, stream)
        for channel, more in zip(
            pulses, _recorded(bench, see_saw, channels, cycles, volume), strict=True
        ):
            channel += more
        progress("test pulses", (level + 1) / len(supplies))
    return pulses


def _recorded(
    bench: EmbeddedBench, see_saw: SeeSaw, channels: int, cycles: int, volume: float
) -> list[list[Pulse]]:
    recording = record_pulses(see_saw, channels, cycles, volume)
    valves = next(recording)
    while True:
        bench.command(valves)
        pressures = bench.advance(PERIOD)
        try:
            valves = recording.send(Sample(bench.time, pressures[:-1], float(pressures[-1])))
        except StopIteration as end:
            return list(end.value)


def calibrated(
    box: Pneumatics,
    channels: int,
    points: int,
    seed: int,
    progress: Progress,
    supplies: Sequence[float] = SUPPLIES,
    plan: SeeSawPlan | None = None,
) -> list[ChannelCalibration]:
    """Calibrate a box on bottles; arguments and errors as of `record` and `fit_channel`."""
    recorded = record(box, channels, points, supplies, seed, progress, plan)
    return [fit_channel(pulses) for pulses in recorded]
