"""Command: a short calibration of the pretended box, written to a file.

    python -m pneumaticbox_driver.calibrate --output calibration.yaml

The file that is shipped is made by this command with its defaults.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedBench
from pneumaticbox_driver.calibration import (
    ChannelCalibration,
    Pulse,
    fit_channel,
    save_calibration,
)
from pneumaticbox_driver.recording import Sample, record_pulses
from pneumaticbox_driver.see_saw import SeeSaw, SeeSawPlan

OUTLETS = "abcdefgh"
PERIOD = 0.002  # of the sensor samples [s]
BOTTLE = 0.5e-3  # reference volume of the thesis [m3]
SUPPLIES = (260e3, 320e3)  # gauge, section 4.4.3 [Pa]


def calibrate(
    cycles: int,
    seed: int = 0,
    channels: int = len(OUTLETS),
    volume: float = BOTTLE,
    supplies: Sequence[float] = SUPPLIES,
) -> list[ChannelCalibration]:
    """Calibrate the pretended box's channels, all at once, on bottles of the same volume.

    Args:
        cycles: pulses per channel, direction and supply pressure.
        seed: of the pulses and of the bench's noise.
        channels: number of outlets.
        volume: of the bottles [m3].
        supplies: gauge supply pressures, one after the other [Pa].

    Raises:
        ValueError: the recorded pulses do not determine the coefficients.
    """
    pulses: list[list[Pulse]] = [[] for _ in range(channels)]
    for level, supply in enumerate(supplies):
        recorded = record_on_bench(cycles, 1000 * seed + level, channels, volume, supply)
        for channel, more in zip(pulses, recorded, strict=True):
            channel += more
    return [fit_channel(channel) for channel in pulses]


def record_on_bench(
    cycles: int, seed: int, channels: int, volume: float, supply: float
) -> list[list[Pulse]]:
    """Record test pulses of the pretended box on bottles, at one gauge supply pressure [Pa].

    Args:
        cycles: pulses per channel and direction.
        seed: of the pulses and of the bench's noise.
        channels: number of outlets.
        volume: of the bottles [m3].
        supply: gauge supply pressure [Pa].

    Returns:
        The pulses per channel.
    """
    bench = EmbeddedBench(OUTLETS[:channels], np.full(channels, volume), seed=seed)
    bench.plant.set_supply(supply)
    recording = record_pulses(SeeSaw(SeeSawPlan(), channels, seed), channels, cycles, volume)
    valves = next(recording)
    while True:
        bench.command(valves)
        pressures = bench.advance(PERIOD)
        try:
            valves = recording.send(Sample(bench.time, pressures[:-1], float(pressures[-1])))
        except StopIteration as end:
            return list(end.value)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(prog="calibrate", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("calibration.yaml"))
    parser.add_argument("--cycles", type=int, default=60, help="pulses per direction and supply")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--force", action="store_true", help="overwrite the output")
    given = parser.parse_args(arguments)
    if given.output.exists() and not given.force:
        print(f"calibrate: {given.output} exists; --force overwrites it", file=sys.stderr)
        return 2
    try:
        channels = calibrate(given.cycles, given.seed)
        save_calibration(given.output, "pretended box of softhand_model", channels)
    except (ValueError, OSError) as error:
        print(f"calibrate: {error}", file=sys.stderr)
        return 1
    for outlet, channel in enumerate(channels, start=1):
        up, down = 1e6 * channel.residual_inflate, 1e6 * channel.residual_deflate
        print(f"outlet {outlet}: residual {up:.3f} mg inflating, {down:.3f} mg deflating")
    return 0


if __name__ == "__main__":
    sys.exit(main())
