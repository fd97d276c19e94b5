"""Both engines on the same hands: natural frequencies in MuJoCo, speed.

Every row is also printed as soon as it is known.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

from bench.row import at_least, stated
from bench.sim.motion import (
    FINE,
    PARTS,
    RING_TIME,
    SEGMENTS,
    first_mode,
    kept_at,
    let_go,
    recurrent_frequency,
    weightless,
)
from bench.sim.mujoco_hand import OURS, grasp
from pneuflex_sim.engines import MUJOCO, PYBULLET
from softhand_trials.trials import TrialSettings, run_trial

Array = NDArray[np.float64]

FREQUENCY_TARGETS = {0.001: 0.97, 0.002: 0.95, 0.005: 0.9, 0.010: 0.85}  # over 0.1 ms, by step [s]
PLAIN_TARGET, PYBULLET_TARGET = 0.9, 0.55  # speed over plain MuJoCo, and over engine mujoco
SPEED_STEP, SPEED_SEEDS = 0.001, 3  # step [s]
RATE_TARGETS = {PYBULLET: 8000.0, MUJOCO: 12000.0}  # grasps a core-hour
RATE_REFERENCE, RATE_STEPS = 0.001, (0.002, 0.005, 0.010)  # [s]
RATE_SEEDS, RATE_AGREEING = 20, 0.95
RATE_OFFSET = 0.030  # [m] largest shift of the object, at which some grasps fail
PLAIN = "MuJoCo, discrete, elliptic"
FINEST_BIN = 0.02  # [Hz] of a spectrum that is padded with zeros


# ------------------------------------------------------------------ frequency
def swing(hand: str, body: str, step: float, springs_alone: bool) -> tuple[float, Array, Array]:
    """A body of a hand let go in its first mode in MuJoCo: the closed form's natural frequency [Hz]
    of springs without gas, share of the mode (k,) and its speed (k,). Valves are closed, or the
    pressure is kept where springs act alone.
    """
    simulation = weightless(hand=hand, step=step, segments=SEGMENTS, engine=MUJOCO)
    exact, mode, weights = first_mode(simulation, body)
    let_go(simulation, mode)
    simulation.set_air_masses(np.zeros(len(simulation.channels)))
    update = kept_at(simulation, 0.0) if springs_alone else simulation._update_air
    seen = [(np.sum(weights * mode), 0.0)]
    with mock.patch.object(simulation, "_update_air", update):
        while simulation.time < RING_TIME - 0.5 * step:
            simulation.step()
            moving = simulation.bodies
            seen.append((np.sum(weights * moving.rotations), np.sum(weights * moving.v)))
    simulation.close()
    shares, speeds = np.array(seen).T
    return exact, shares, speeds


def spectral_frequency(speeds: Array, step: float) -> float:
    """Natural frequency [Hz] of a damped swing (k,) from rest, by its speed: where frequency times
    the speed's spectrum peaks, whatever the damping.
    """
    padded = int(1.0 / (FINEST_BIN * step))
    frequencies = np.fft.rfftfreq(padded, step)
    spectrum = frequencies * np.abs(np.fft.rfft(speeds, padded))
    band = frequencies < 0.25 / step
    return float(frequencies[np.argmax(np.where(band, spectrum, 0.0))])


def frequencies() -> Iterator[dict[str, Any]]:
    """Frequencies with closed valves over those at the fine step; and of springs alone over the
    closed form, by the recurrence and by the spectrum.
    """
    for name, part in PARTS.items():
        fine = recurrent_frequency(swing(*part, FINE, springs_alone=False)[1], FINE)
        for step, least in FREQUENCY_TARGETS.items():
            label = f"engine mujoco, {name}, {1e3 * step:g} ms: frequency"
            found = recurrent_frequency(swing(*part, step, springs_alone=False)[1], step)
            yield at_least(f"{label} over that at 0.1 ms", found / fine, "", least)
            exact, shares, speeds = swing(*part, step, springs_alone=True)
            alone = f"{label} of springs alone over closed form"
            yield stated(f"{alone}, recurrence", recurrent_frequency(shares, step) / exact, "")
            yield stated(f"{alone}, spectrum", spectral_frequency(speeds, step) / exact, "")


# ------------------------------------------------------------------ speed
def speeds(small: bool) -> Iterator[dict[str, Any]]:
    """Real-time factors of the same grasps, in turn."""
    for engine in (OURS, PLAIN):
        grasp(engine, 0, 0.01)  # compile
    runs = [
        {engine: grasp(engine, seed, SPEED_STEP).times for engine in (OURS, PLAIN)}
        for seed in range(1 if small else SPEED_SEEDS)
    ]
    plain = statistics.median(run[PLAIN].share() for run in runs)
    yield at_least("engine mujoco, 1 ms: speed over its mj_step alone", plain, "", PLAIN_TARGET)
    ratio = statistics.median(run[OURS].factor(1.0) / run[PLAIN].factor(1.0) for run in runs)
    yield at_least("engine pybullet over mujoco, 1 ms: speed", ratio, "", PYBULLET_TARGET)


def rates(small: bool) -> Iterator[dict[str, Any]]:
    """Grasps a core-hour at the largest step whose verdicts are those of 1 ms."""
    for engine, least in RATE_TARGETS.items():
        settings = TrialSettings(
            options=("lower_and_release",), offset=RATE_OFFSET, engine=engine, early_end=True
        )
        reference, _ = batch(replace(settings, step=RATE_REFERENCE), small)
        best = 0.0
        for step in RATE_STEPS:
            found, rate = batch(replace(settings, step=step), small)
            agreeing = float(np.mean(np.equal(found, reference)))
            name = f"engine {engine}, {1e3 * step:g} ms"
            yield stated(f"{name}: verdicts as at 1 ms, {sum(reference)} gripped", agreeing, "")
            yield stated(f"{name}: grasps a core-hour", rate, "")
            best = max(best, rate if agreeing >= RATE_AGREEING else 0.0)
        name = f"engine {engine}: grasps a core-hour at a step that agrees with 1 ms"
        yield at_least(name, best, "", least)


def batch(settings: TrialSettings, small: bool) -> tuple[list[bool], float]:
    """Whether each seed is gripped, and grasps an hour of CPU time."""
    run_trial(0, settings)  # compile
    begin, seeds = time.process_time(), 4 if small else RATE_SEEDS
    found = [run_trial(seed, settings).result.gripped for seed in range(seeds)]
    return found, 3600.0 * seeds / (time.process_time() - begin)


def rows(small: bool) -> list[dict[str, Any]]:
    """All rows."""
    found = []
    for part in (frequencies(), speeds(small), rates(small)):
        for row in part:
            print(f"{row['name']}: {row['value']:.4g} {row['target'] or ''}", flush=True)
            found.append(row)
    return found
