"""The command `softhand calibrate`: coefficients of the simulated box, written to a file.

    softhand calibrate --output calibration.yaml

The shipped file was made by this command with its defaults.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.calibration.file import save_calibration
from pneumaticbox_driver.calibration.recording import (
    PulseDurations,
    PulseRanges,
    Sample,
    record_pulses,
)
from pneumaticbox_driver.calibration.regression import Pulse
from pneumaticbox_driver.calibration.run import CalibrationPlan, CalibrationRun
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from softhand_common.progress import Progress
from softhand_model.pneumatics import Pneumatics, load_pneumatics

OUTLETS = "abcdefgh"
SAMPLE_PERIOD = 0.002  # of the sensor samples [s]
BOTTLE = 0.5e-3  # reference volume of the thesis [m3]
SUPPLY_PRESSURES = (260e3, 320e3)  # gauge, section 4.4.3 [Pa]
SIMULATED_BOX = "simulated box of softhand_model"


def calibrate(
    points: int = CalibrationPlan.points,
    seed: int = 0,
    channels: int = len(OUTLETS),
    volume: float = BOTTLE,
    supplies: Sequence[float] = SUPPLY_PRESSURES,
    parameters: Pneumatics | None = None,
    progress: Callable[[float, str], None] | None = None,
    leak_test: float = CalibrationPlan.leak_test,
) -> list[ChannelCalibration]:
    """Calibrate the channels of the simulated box together, on bottles of the same volume.

    Args:
        points: pulses per channel, both directions and all supply pressures together.
        seed: seed of the pulses and of the rig's noise.
        channels: number of outlets.
        volume: volume of the bottles [m3].
        supplies: gauge supply pressures, one after the other [Pa].
        parameters: constants of the box; None for the shipped ones.
        progress: called with the finished share (0 to 1) and a sentence.
        leak_test: duration of the leak test at the end [s]; 0 for none.

    Raises:
        ValueError: the plan cannot be carried out, or the pulses do not determine the coefficients.
    """
    names = OUTLETS[:channels]
    plan = CalibrationPlan(points, len(supplies), leak_test=leak_test)
    run = CalibrationRun(tuple(names), np.full(channels, volume), plan, seed)
    rig = EmbeddedRig(names, np.full(channels, volume), parameters, seed)
    left = list(supplies)
    rig.plant.set_supply(left.pop(0))
    valves, reported = np.zeros(channels, dtype=np.int8), ""
    while run.under_way:
        rig.command(valves)
        valves = run.on_sample(_next_sample(rig))
        if run.state == "waiting":
            _turn_supply(rig, run, left.pop(0))
        if progress is not None and run.message != reported:
            progress(run.progress, run.message)
            reported = run.message
    if run.state == "failed":
        raise ValueError(run.message)
    return run.result


def _next_sample(rig: EmbeddedRig) -> Sample:
    readings = rig.advance(SAMPLE_PERIOD)
    return Sample.of(rig.time, readings)


def _turn_supply(rig: EmbeddedRig, run: CalibrationRun, supply: float) -> None:
    """Set the regulator, let the reservoir settle, and continue the run."""
    rig.plant.set_supply(supply)
    for _ in range(round(3.0 / SAMPLE_PERIOD)):
        rig.command(np.zeros(len(run.channels)))
        run.on_sample(_next_sample(rig))
    run.next()


def record_on_rig(
    cycles: int, seed: int, channels: int, volume: float, supply: float
) -> list[list[Pulse]]:
    """Record test pulses of the simulated box on bottles, at one gauge supply pressure [Pa].

    Args:
        cycles: pulses per channel and direction.
        seed: seed of the pulses and of the rig's noise.
        channels: number of outlets.
        volume: volume of the bottles [m3].
        supply: gauge supply pressure [Pa].

    Returns:
        The pulses per channel.
    """
    rig = EmbeddedRig(OUTLETS[:channels], np.full(channels, volume), seed=seed)
    rig.plant.set_supply(supply)
    recording = record_pulses(
        PulseDurations(PulseRanges(), channels, seed), channels, cycles, volume
    )
    valves = next(recording)
    while True:
        rig.command(valves)
        try:
            valves = recording.send(_next_sample(rig))
        except StopIteration as end:
            return list(end.value)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    given = _parser().parse_args(arguments)
    if given.output.exists() and not given.force:
        print(f"softhand calibrate: {given.output} exists; --force overwrites it", file=sys.stderr)
        return 2
    try:
        with Progress("softhand calibrate", unit=" %") as progress:
            channels = calibrate(
                given.points,
                given.seed,
                given.outlets,
                given.volume,
                given.supplies,
                load_pneumatics(given.pneumatics),
                lambda share, message: progress(message, round(100 * share), 100),
            )
        save_calibration(given.output, given.box, channels, given.volume)
    except (ValueError, OSError) as error:
        print(f"softhand calibrate: {error}", file=sys.stderr)
        return 1
    for channel in channels:
        print(_summary(channel))
    return 0


def _summary(channel: ChannelCalibration) -> str:
    up, down = 1e6 * channel.inflate.residual, 1e6 * channel.deflate.residual
    leak = channel.leak.conductance
    return f"outlet {channel.outlet}: residual {up:.3f} mg inflating, {down:.3f} mg deflating; " + (
        f"leak {leak:.1e} kg/(s Pa)" if leak else "tight"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="softhand calibrate", description=(__doc__ or "").splitlines()[0]
    )
    add = parser.add_argument
    add("--output", type=Path, default=Path("calibration.yaml"), help="file to write")
    add("--force", action="store_true", help="overwrite the output")
    add(
        "--points",
        type=int,
        default=CalibrationPlan.points,
        help="pulses per outlet, both directions and all supplies together (%(default)s)",
    )
    add(
        "--supplies",
        type=float,
        nargs="+",
        default=list(SUPPLY_PRESSURES),
        metavar="PA",
        help="gauge supply pressures [Pa] (260e3 320e3)",
    )
    add("--volume", type=float, default=BOTTLE, help="volume of each bottle [m3] (%(default)s)")
    add(
        "--outlets",
        "--channels",
        type=int,
        default=len(OUTLETS),
        choices=range(1, len(OUTLETS) + 1),
        help="how many outlets, from the first on (%(default)s)",
    )
    add("--pneumatics", help="YAML file of the box, or pneumaticbox or ideal (ideal)")
    add("--box", default=SIMULATED_BOX, help="name of the box in the file (%(default)s)")
    add("--seed", type=int, default=0, help="draws durations and noise (%(default)s)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
