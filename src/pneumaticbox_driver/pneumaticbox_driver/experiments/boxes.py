"""Pretended boxes of the experiments: which one, and its calibration as a user would make it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.calibration import ChannelCalibration, Pulse
from pneumaticbox_driver.calibration_plan import CalibrationPlan
from pneumaticbox_driver.calibration_run import CalibrationRun
from pneumaticbox_driver.experiments.report import Progress
from pneumaticbox_driver.recording import Sample, record_pulses
from pneumaticbox_driver.see_saw import SeeSaw, SeeSawPlan
from softhand_model.pneumatics import Pneumatics, load_pneumatics

OUTLETS = "abcdefgh"
PERIOD = 0.002  # of the sensor samples [s]
BOTTLE = 0.5e-3  # of section 4.4.3 [m3]
REGULATING = 3.0  # for the reservoir to follow the regulator [s]
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
        bench = EmbeddedBench(OUTLETS[:channels], np.full(channels, BOTTLE), box, stream)
        bench.plant.set_supply(supply)
        recorded = _recorded(bench, SeeSaw(SeeSawPlan(), channels, stream), channels, cycles)
        for channel, more in zip(pulses, recorded, strict=True):
            channel += more
        progress("test pulses", (level + 1) / len(supplies))
    return pulses


def _recorded(
    bench: EmbeddedBench, see_saw: SeeSaw, channels: int, cycles: int
) -> list[list[Pulse]]:
    recording = record_pulses(see_saw, channels, cycles, BOTTLE)
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
    see_saw: SeeSawPlan | None = None,
) -> list[ChannelCalibration]:
    """Calibrate a box on bottles as a user does, who turns the supply when asked to.

    The bottles are known to be tight: there is no leak test.

    Args:
        box: constants of the plant.
        channels: number of outlets.
        points: pulses per channel, both directions and all supplies together.
        seed: of the pulses and the noise.
        progress: is told.
        supplies: gauge supply pressures, one after the other [Pa].
        see_saw: ranges of the pulses; None for the driver's.

    Raises:
        ValueError: too few points, or pulses that do not determine the coefficients.
    """
    plan = CalibrationPlan(points, len(supplies), see_saw or SeeSawPlan(), leak_test=0.0)
    run = CalibrationRun(OUTLETS[:channels], np.full(channels, BOTTLE), plan, seed)
    bench = EmbeddedBench(OUTLETS[:channels], np.full(channels, BOTTLE), box, seed)
    for supply in supplies:
        bench.plant.set_supply(supply)
        _play(bench, run, REGULATING)
        if run.state == "waiting":
            run.next()
        while run.state == "running":
            _play(bench, run, PERIOD)
            progress("calibration", run.progress)
    return run.result


def _play(bench: EmbeddedBench, run: CalibrationRun, duration: float) -> None:
    """Answer the run's samples for a time [s]; a run that waits keeps the valves closed."""
    for _ in range(round(duration / PERIOD)):
        pressures = bench.advance(PERIOD)
        bench.command(run.on_sample(Sample(bench.time, pressures[:-1], float(pressures[-1]))))
