"""Measures one group of figures for one seed."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from softhand_model.pneumatics import Pneumatics
from softhand_model.pneumatics.parameters import DEFAULT
from thesis.chapter_4 import MG, pulse_error, six_channels, supply_rejection
from thesis.chapter_4.boxes import box_of, calibrated
from thesis.chapter_4.finger_posture import Fingers, on_fingers
from thesis.chapter_4.rig_run import Sine, final_drift
from thesis.frame import Job, Report

OFFSET = 0.014 * 250e3  # the whole accuracy class of a channel's sensor [Pa]
NO_ERROR = 1e-9  # of full scale


@dataclass(frozen=True)
class Size:
    """How much is measured: pulses, channels, runs, time of sines and of a process [s]."""

    points: int = 100
    tests: int = 200
    channels: int = 8
    duration: float = 60.0
    watched: float = 20.0
    runs: int = 3


def measure(group: str, seed: int, size: Size) -> list[float]:
    """Values of a group of `figures.GROUPS`, in the order of its figures."""
    return MEASURES[group](seed, size)


def quiet(what: str, share: float) -> None:
    """Progress that nobody hears."""


def reported(experiment: Any, given: Any) -> Report:
    """Report of an experiment of chapter 4 on the simulator's box, with these parameters."""
    box = box_of(given.seed, DEFAULT)
    return experiment.report(experiment.on_box(box, given, Job(Path(), quiet)), given)


def pulses(seed: int, size: Size) -> list[float]:
    """Errors of single pulses, over the baseline's and over the noise of the ground truth."""
    given = pulse_error.Parameters(seed=seed, tests=size.tests, channels=size.channels)
    found = reported(pulse_error, given)
    return [
        found["deflation: baseline / full model"],
        found["deflation: full model / noise"],
        found["inflation: full model / noise"],
    ]


def sine(seed: int, size: Size) -> list[float]:
    """Drift and tracking of all channels with own and with shared calibrations."""
    given = six_channels.Parameters(
        seed=seed, points=size.points, channels=size.channels, duration=size.duration
    )
    found = reported(six_channels, given)
    return [
        found["final drift, worst channel, by the sensors"],
        found["final drift, worst channel, true"],
        found["mean tracking error, shared / own"],
        found["the driver warns of a shared calibration"],
    ]


def finger(seed: int, size: Size) -> list[float]:
    """Drift of four fingers with drift correction, sensors off by their class, tared once.

    At the end the fingers rest at a target: what counts is the last sample, corrected as the
    driver would at a known posture.
    """
    box = exact_sensors(box_of(seed, DEFAULT))
    own = calibrated(box_of(seed, DEFAULT), 4, size.points, seed, quiet)
    wave = Sine(duration=size.duration, mean=10e-6, amplitude=6e-6, period=6.0, fill=4.0)
    offset = OFFSET if seed % 2 == 0 else -OFFSET
    run = on_fingers(Fingers(4), box, own, seed, drift_correction=True, sensor_offset=offset)
    return [float(np.abs(final_drift(run.follow(wave, quiet))).max()) / MG]


def exact_sensors(box: Pneumatics) -> Pneumatics:
    """The box without errors of the channels' sensors: the offset that is added is all of them."""
    return replace(box, channel_sensor=replace(box.channel_sensor, accuracy=NO_ERROR))


def supply(seed: int, size: Size) -> list[float]:
    """Size of the change of the tracking error under a supply that varies [%], of several runs."""
    given = supply_rejection.Parameters(
        seed=seed, channels=size.channels, duration=size.duration, runs=size.runs
    )
    return [abs(reported(supply_rejection, given)["change of the tracking error"])]


def loop(seed: int, size: Size) -> list[float]:
    """Lateness of the driver's loop at 500 Hz above an empty one [ms]."""
    rows = importlib.import_module("bench.driver_loop").run()
    return [row["value"] for row in rows if "lateness above" in row["name"]]


def process(seed: int, size: Size) -> list[float]:
    """CPU time of the driver's process on 8 channels at 500 Hz, over wall time [%]."""
    watched = importlib.import_module("bench.pneumatics.driver_process")
    return [100 * watched.cpu_share(size.watched)]


def faults(seed: int, size: Size) -> list[float]:
    """Share of the injected faults that were survived [%], and how many stayed silent."""
    outcomes = list(importlib.import_module("bench.pneumatics.faults").scenarios(seed))
    survived = [outcome["survived"] for outcome in outcomes]
    silent = [outcome["silent"] for outcome in outcomes]
    return [100.0 * sum(survived) / len(survived), float(sum(silent))]


MEASURES = {
    function.__name__: function
    for function in (pulses, sine, finger, supply, loop, process, faults)
}
