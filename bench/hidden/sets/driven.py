"""Making one measurement set with hidden laws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.hidden.design import DESIGNS, DRIVES, SECTIONS, ExtraRun, Scene, extended
from bench.hidden.laws import (  # noqa: F401  (they register)
    catalogue,
    curves,
    other_forms,
    outside,
    reserved,
)
from bench.hidden.laws.registry import LAWS, build
from bench.hidden.measure import BaseFit, Shown, floor_of, measure, mode_of, strength_for
from bench.hidden.sets import recording
from bench.hidden.sets.pulses import make_pulse_set
from bench.hidden.sets.stretches import make_rubber_set
from bench.hidden.sets.torques import make_torque_set
from bench.hidden.sets.writing import write_set

Array = np.ndarray
UNITS = {
    "free_bending": {"time": "s", "pressure": "kPa", "tip_angle": "deg"},
    "blocked_tip": {"time": "s", "pressure": "kPa", "tip_force": "N"},
    "uniaxial": {"time": "s", "stretch": "", "stress": "kPa"},
}
TITLES = {
    "free_bending": "tip angle of a finger",
    "blocked_tip": "force of a blocked finger",
    "uniaxial": "tension of silicone strips",
}
PEAKS = {"free_bending": (40e3, 50e3), "blocked_tip": (40e3, 50e3), "uniaxial": (0.8, 1.6)}


@dataclass(frozen=True)
class Options:
    """How a set is measured.

    noise: sensor noise over full scale. scatter: relative, from run to run. ratio: error before
    over noise floor that each law is given (None: parameters must be given or are at their
    strongest). design, drives: of `bench.hidden.design`. samples: a run (the total of twelve such
    runs is kept when a design has more). correlation: of the noise from sample to sample. jitter:
    of the peak pressure from repeat to repeat, relative. adjacent: repeats follow one another at
    once. wild: share of the samples that are anything. output_steps, drive_steps: of the sensors
    over their range, 0 without end. drive_rate: readings of the drive a sample, on a clock of their
    own, of which the table has the latest; 0: read with the output.
    extra: runs behind those of the design, which have no part in the laws' strength.
    """

    noise: float = 0.006
    scatter: float = 0.006
    ratio: float | None = None
    design: str = "standard"
    drives: str = "standard"
    runs: int = 12
    samples: int = 200
    repeats: int = 2
    with_time: bool = True
    with_noise: bool = True
    correlation: float = 0.0
    jitter: float = 0.0
    adjacent: bool = False
    wild: float = 0.0
    output_steps: int = 0
    drive_steps: int = 0
    drive_rate: float = 0.0
    extra: tuple[ExtraRun, ...] = ()


def make_set(
    folder: Path,
    experiment: str,
    hidden: list[tuple[str, dict[str, float]]],
    *,
    seed: int,
    **options: Any,
) -> dict[str, Any]:
    """Write a measurement set with hidden laws and return the truth.

    hidden: names of `LAWS` with parameters; those left out are drawn, and the law's knob is set
    so that the base model's error is `ratio` times the noise floor. options: fields of `Options`.
    truth: hidden (names and parameters), modulus_scale, floor, noise (SI), ratio (error before
    over floor, together), ratios (each alone), reached (whether each ratio was).
    """
    chosen = Options(**options)
    apart = {
        "valve_pulse": make_pulse_set,
        "base_torque": make_torque_set,
        "rubber": make_rubber_set,
    }
    if experiment in apart:
        return apart[experiment](
            Path(folder),
            hidden,
            seed=seed,
            noise=chosen.noise,
            scatter=chosen.scatter,
            ratio=chosen.ratio,
            runs=chosen.runs,
            samples=chosen.samples,
            repeats=chosen.repeats,
            with_noise=chosen.with_noise,
            adjacent=chosen.adjacent,
        )
    rng = np.random.default_rng(seed)
    scene = plan(experiment, chosen, rng)
    scale = float(rng.uniform(0.92, 1.08))
    completed = [(name, LAWS[name].complete(given, rng)) for name, given in hidden]
    entries, ratios = _tune(experiment, scene, completed, hidden, scale, chosen)
    scene = extended(scene, chosen.extra)
    truth = _measured(Path(folder), experiment, scene, entries, scale, chosen, rng)
    return truth | {"ratios": ratios, "hidden": [{"name": n, "parameters": p} for n, p in entries]}


def plan(experiment: str, chosen: Options, rng: np.random.Generator) -> Scene:
    """Specimens and runs of a set."""
    drives = DRIVES[chosen.drives](rng)[: max(1, chosen.runs // chosen.repeats)]
    specimens, runs = DESIGNS[chosen.design](rng, drives, chosen.repeats)
    if chosen.adjacent:
        runs = sorted(runs, key=lambda run: (run.specimen, run.temperature, run.protocol.name))
    blocked = experiment == "blocked_tip"
    sections = 10 if blocked else SECTIONS.get(chosen.design, 1)
    samples = min(chosen.samples, max(60, chosen.runs * chosen.samples // len(runs)))
    peak = float(rng.uniform(*PEAKS[experiment]))
    if experiment == "uniaxial":
        specimens = {name: _strip(entry) for name, entry in specimens.items()}
    return Scene(specimens, tuple(runs), samples, peak, sections, blocked, np.ones(len(runs)))


def _strip(entry: dict[str, Any]) -> dict[str, Any]:
    return entry | {"length": 0.05, "height": 0.006, "width": 0.01}


def _tune(
    experiment: str,
    scene: Scene,
    completed: list[tuple[str, dict[str, float]]],
    hidden: list[tuple[str, dict[str, float]]],
    scale: float,
    chosen: Options,
) -> tuple[list[tuple[str, dict[str, float]]], list[float]]:
    """Knobs that were not given, set for the ratio; and the ratio of each law alone."""
    entries, ratios = [], []
    for (name, values), (_, given) in zip(completed, hidden, strict=True):
        knob = LAWS[name].knob
        if chosen.ratio is not None and knob is not None and knob[0] not in given:
            values, reached = strength_for(
                experiment, scene, (name, values), scale, chosen.ratio, chosen.noise, chosen.scatter
            )
            ratios.append(reached)
        entries.append((name, values))
    return entries, ratios


def _measured(
    folder: Path,
    experiment: str,
    scene: Scene,
    entries: list[tuple[str, dict[str, float]]],
    scale: float,
    chosen: Options,
    rng: np.random.Generator,
) -> dict[str, Any]:
    """Measure with scatter and noise, write, and tell what the folder does not."""
    clean = measure(experiment, scene, build(entries, scale, mode_of(experiment)), fine=False)
    misfit = BaseFit(experiment, scene, clean.drive).misfit(clean.output)
    floor = floor_of(clean, chosen.noise, chosen.scatter)
    scattered, gains = _scattered(scene, chosen, rng)
    shown = measure(experiment, scattered, build(entries, scale, mode_of(experiment)))
    sigma = chosen.noise * float(np.abs(clean.output).max())
    noise = sigma * _noise(shown.output.shape, chosen.correlation, rng)
    output = shown.output * gains[:, None] + noise
    if chosen.drive_rate:
        drive = recording.latest(shown.time, shown.drive, chosen.drive_rate, rng)
        shown = replace(shown, drive=drive)
    if chosen.wild:
        output = recording.gone_wild(output, chosen.wild, rng)
    output = recording.in_steps(output, chosen.output_steps)
    shown = replace(shown, drive=recording.in_steps(shown.drive, chosen.drive_steps))
    _write(folder, experiment, scene, shown, output, sigma, chosen)
    return {
        "experiment": experiment,
        "modulus_scale": scale,
        "noise": sigma,
        "floor": floor,
        "ratio": float(np.hypot(misfit, floor) / floor),
    }


def _scattered(scene: Scene, chosen: Options, rng: np.random.Generator) -> tuple[Scene, Array]:
    """Scatter from run to run: of the modulus in one half of the sets, of the reading in the other.

    The peak may jitter as well.
    """
    gains = 1 + chosen.scatter * rng.standard_normal(len(scene.runs))
    peaks = 1 + chosen.jitter * rng.standard_normal(len(scene.runs))
    pairs = zip(scene.runs, peaks, strict=True)
    runs = [
        replace(run, protocol=replace(run.protocol, peak=run.protocol.peak * factor))
        for run, factor in pairs
    ]
    if rng.random() < 0.5:
        return replace(scene, runs=tuple(runs), gains=gains), np.ones_like(gains)
    return replace(scene, runs=tuple(runs)), gains


def _noise(shape: tuple[int, int], correlation: float, rng: np.random.Generator) -> Array:
    """Unit noise, white or with a correlation from sample to sample."""
    noise = rng.standard_normal(shape)
    for k in range(1, shape[1] if correlation else 0):
        fresh = np.sqrt(1 - correlation**2) * noise[:, k]
        noise[:, k] = correlation * noise[:, k - 1] + fresh
    return noise


def _write(
    folder: Path,
    experiment: str,
    scene: Scene,
    shown: Shown,
    output: Array,
    sigma: float,
    chosen: Options,
) -> None:
    units = dict(UNITS[experiment])
    time, drive, value = units
    if not chosen.with_time:
        del units[time]
    runs = {}
    for k, run in enumerate(scene.runs):
        entry: dict[str, Any] = {"specimen": run.specimen, "temperature": run.temperature}
        entry["protocol"] = run.protocol.name
        if run.virgin:
            entry["virgin"] = True
        columns = {time: shown.time[k], drive: shown.drive[k], value: output[k]}
        runs[f"r{k + 1:02d}"] = (entry, {name: columns[name] for name in units})
    head = {"experiment": experiment, "title": TITLES[experiment], "specimens": scene.specimens}
    write_set(folder, head, units, {value: sigma} if chosen.with_noise else None, runs)
