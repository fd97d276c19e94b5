"""Measurement sets made by the model itself with one effect sealed in: for demonstration.

The lab's tests do not use them (they would test the lab with its own code); the demonstration and a
person who wants to try the lab do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model_lab.candidates import inapplicable
from model_lab.forward import Forward
from model_lab.measurement import OUTPUTS, MeasurementSet, Run, Specimen
from model_lab.protocols import BANK
from model_lab.seal import seal
from model_lab.set_writing import write_set
from softhand_model.effects import Effect, effect_classes

Array = NDArray[np.float64]

EXPERIMENTS = ("free_bending", "blocked_tip", "uniaxial")
DURATION = 24.0  # [s] of a run
SAMPLES = 200
PEAKS = {"free_bending": 45e3, "blocked_tip": 45e3, "uniaxial": 2.0}  # [Pa], or stretch above 1
SCATTER = 0.006  # of a whole run, relative
NOISE = 0.006  # of the largest output
VISIBLE = 4.0  # times the noise that the effect changes the readings at least, in the mean square
TRIES = 60
SPECIMENS = {
    "thin": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.0025, "side_wall": 0.0025},
    "thick": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.004, "side_wall": 0.0025},
}
SHARED = {"shear_modulus": 67e3, "mass": 0.035}
BAR = {"gauge_length": 0.033, "shear_modulus": 67e3}
SETTINGS = (  # temperature [K] and mount of each protocol in turn
    (293.15, "bending_plane_level"),
    (293.15, "base_up"),
    (313.15, "bending_plane_level"),
)


@dataclass(frozen=True)
class Synthesised:
    """A set and what was hidden in it."""

    data: MeasurementSet
    truth: dict[str, Any]


def synthesize(experiment: str, seed: int, hide: bool) -> Synthesised:
    """A set of two repeats of six protocols, with one random effect if `hide`.

    Raises ValueError for an experiment that is not among EXPERIMENTS.
    """
    if experiment not in EXPERIMENTS:
        raise ValueError(
            f"experiment: expected one of {', '.join(EXPERIMENTS)} to synthesize, got {experiment}"
        )
    random = np.random.default_rng(seed)
    empty = _empty_set(experiment)
    scale = float(random.uniform(0.93, 1.07))
    effect = _hidden_effect(empty, random) if hide else None
    chosen = () if effect is None else (effect,)
    true = _predicted(empty, chosen, scale)
    spread = NOISE * float(np.abs(true).max())
    measured = _measured(empty, true, spread, random)
    truth = {
        "effects": [{"name": effect.name, "parameters": dict(effect.values)} for effect in chosen],
        "modulus_scale": scale,
        "noise": spread,
        "seed": seed,
    }
    return Synthesised(measured, truth)


def write_synthesised(made: Synthesised, folder: Path, force: bool = False) -> None:
    """Write the set and, beside it, the sealed truth."""
    write_set(made.data, folder, force)
    seal(folder, made.truth)


def _hidden_effect(empty: MeasurementSet, random: np.random.Generator) -> Effect:
    """An effect whose change of the readings is well above the noise and unlike the calibration."""
    classes = [
        effect
        for effect in effect_classes().values()
        if inapplicable(effect, empty, "pneuflex") is None
    ]
    base = _predicted(empty, (), 1.0)
    like_modulus = _predicted(empty, (), 1.05) - base
    noise = np.hypot(SCATTER, NOISE) * np.abs(base).max()
    for _ in range(TRIES):
        effect = _drawn(classes[random.integers(len(classes))], random)
        change = _predicted(empty, (effect,), 1.0) - base
        change = change - like_modulus * (change @ like_modulus) / (like_modulus @ like_modulus)
        if np.sqrt(np.mean(change**2)) > VISIBLE * noise:
            return effect
    raise RuntimeError(f"no visible effect in {TRIES} tries for {empty.experiment}")


def _drawn(effect: type[Effect], random: np.random.Generator) -> Effect:
    values = {}
    for parameter in effect.parameters:
        low, high = parameter.typical or (parameter.low, parameter.high)
        share = random.uniform()
        values[parameter.name] = float(
            low * (high / low) ** share if parameter.logarithmic else low + share * (high - low)
        )
    return effect(**values)


def _predicted(data: MeasurementSet, effects: Sequence[Effect], scale: float) -> Array:
    forward = Forward(data, "pneuflex", (), tuple(effects))
    return forward.predict(np.full((1, len(forward.parameters)), scale))[0]


def _empty_set(experiment: str) -> MeasurementSet:
    """The set before anything is measured: outputs are zero."""
    runs = []
    specimens: dict[str, Specimen] = {}
    for repeat in range(2):
        for order, protocol in enumerate(BANK[:6]):
            warm, mount = SETTINGS[order % len(SETTINGS)]
            specimen = _specimen(experiment, order, mount)
            specimens[specimen.name] = specimen
            duration = DURATION * (1.0, 1.0, 0.5, 0.5, 1.0, 2.0)[order]
            time, course = protocol.course(duration, PEAKS[experiment], SAMPLES)
            columns = {"time": time, **_driving(experiment, course)}
            columns[OUTPUTS[experiment][0]] = np.zeros(SAMPLES)
            name = f"r{order + 1}{'ab'[repeat]}"
            runs.append(Run(name, specimen.name, protocol.name, warm, columns))
    title = f"synthesised {experiment.replace('_', ' ')}"
    return MeasurementSet(experiment, title, specimens, tuple(runs))


def _driving(experiment: str, course: Array) -> dict[str, Array]:
    return {"stretch": 1.0 + course} if experiment == "uniaxial" else {"pressure": course}


def _specimen(experiment: str, order: int, mount: str) -> Specimen:
    if experiment == "uniaxial":
        return Specimen("bar", BAR, batch="A")
    kind = "thick" if order % 2 else "thin"
    if experiment == "blocked_tip":
        return Specimen(kind, {**SPECIMENS[kind], **SHARED}, batch="A")
    name = kind if mount == "bending_plane_level" else f"{kind}_{mount}"
    return Specimen(name, {**SPECIMENS[kind], **SHARED}, mount, "A")


def _measured(
    empty: MeasurementSet, true: Array, spread: float, random: np.random.Generator
) -> MeasurementSet:
    runs, start = [], 0
    for run in empty.runs:
        part = true[start : start + run.samples] * (1.0 + SCATTER * random.standard_normal())
        start += run.samples
        part = part + spread * random.standard_normal(run.samples)
        runs.append(replace(run, columns={**run.columns, empty.outputs[0]: part}))
    return replace(empty, runs=tuple(runs), noise={empty.outputs[0]: spread})
