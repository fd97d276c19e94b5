"""Synthesised sets: made by the model itself with one effect sealed in, for demonstration.

They are for the demonstration, and for people who want to try the lab. The tests of the lab do not
use them, as these would test the lab with its own code.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.bench.hand_grasp_set import grasped, hand_grasp_set
from model_lab.bench.hand_motion_set import hand_motion_set, moved_hand
from model_lab.bench.hand_press_set import hand_press_set, pressed_hand
from model_lab.bench.layouts import driven_set, hand_pose_set, held_tip_set, pulse_set
from model_lab.experiments.forward import Forward, inapplicable
from model_lab.experiments.valve_pulse import USUAL_CONDUCTANCE
from model_lab.measurements.hands import GRASP, HAND_MOTION, PRESS
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.save import check_folder, set_files
from softhand_common.documents.json_document import json_node
from softhand_common.documents.output_file import write_files
from softhand_common.documents.yaml_document import Node
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.hand import HandEffect, at_places

SEAL = ".seal"
EMPTY: Mapping[str, Callable[[np.random.Generator], MeasurementSet]] = {
    "free_bending": lambda random: driven_set("free_bending"),
    "blocked_tip": lambda random: driven_set("blocked_tip"),
    "uniaxial": lambda random: driven_set("uniaxial"),
    "rubber": lambda random: driven_set("rubber"),
    "valve_pulse": pulse_set,
    "base_torque": lambda random: held_tip_set(),
    "hand_pose": lambda random: hand_pose_set(),
    HAND_MOTION: lambda random: hand_motion_set(),
    PRESS: lambda random: hand_press_set(),
    GRASP: lambda random: hand_grasp_set(random),
}
EXPERIMENTS = tuple(EMPTY)
NOISE = 0.006  # of the largest output, and scatter of a whole run, relative
EFFECT_OVER_NOISE = (
    3.0,
    10.0,
)  # change of the readings by the effect, root mean square, least and most
BATCH_MODULUS_SCALES = (0.93, 1.07)  # calibration, over its nominal value
CALIBRATION_STEP = 1.05  # of the calibration, to see what it takes up
MOST_DRAWS = 100  # effects that are drawn at the most


def sealed(truth: dict[str, Any]) -> str:
    """Encode what was hidden, so that nobody reads it by accident."""
    return base64.b64encode(json.dumps(truth).encode()).decode() + "\n"


def open_seal(folder: Path) -> dict[str, Any]:
    """What was hidden in the synthesised set of a folder.

    Raises ValueError if the file SEAL is missing or cannot be read.
    """
    path = folder / SEAL
    if not path.is_file():
        raise ValueError(
            f"{path}: expected the file that names the hidden effects, got no such file; make the "
            "set with `model-lab synthesize EXPERIMENT --hide`"
        )
    try:
        text = base64.b64decode(path.read_text(encoding="ascii"), validate=False)
    except ValueError as reason:
        raise ValueError(
            f"{path}: expected the file as `model-lab synthesize` wrote it, got {reason}"
        ) from reason
    node = json_node(str(path), text)
    truth = node.fields(["effects", "calibration", "noise", "seed"])
    for effect in truth["effects"].items():
        of_effect = effect.fields(["name", "parameters"], ["where"])
        of_effect["name"].text()
        _check_numbers(of_effect["parameters"])
    _check_numbers(truth["calibration"])
    truth["noise"].number(0.0)
    return dict(node.value)


def _check_numbers(node: Node) -> None:
    """Raise DocumentError unless all entries are numbers, by name, or by name and batch."""
    for child in node.mapping().values():
        if isinstance(child.value, dict):
            _check_numbers(child)
        else:
            child.number()


@dataclass(frozen=True)
class Synthesised:
    """A synthesised set, and what was hidden in it (`truth`)."""

    data: MeasurementSet
    truth: dict[str, Any]


def synthesize(
    experiment: str,
    seed: int,
    hide: bool,
    classes: Mapping[str, type[Effect]] | None = None,
    noise: float = NOISE,
    tell: Tell = tell_nobody,
) -> Synthesised:
    """A set of two repeats of six protocols, with one random effect if `hide`.

    classes: effects from which the hidden effect is drawn, by name; None: the built-in effects.
    noise: standard deviation of the noise of a sample, and of the scatter of whole runs, over the
    largest reading. `truth` of the result has the effects with their parameters, the calibration as
    in a model file, the noise (standard deviation in SI units) and the seed.

    Raises ValueError for an experiment that is not in EXPERIMENTS, for a noise that is not between
    0 and 1, and if none of the effects changes the outputs of the experiment.
    """
    if not 0.0 < noise < 1.0:
        raise ValueError(f"noise: expected a number between 0 and 1, got {noise:g}")
    if experiment not in EMPTY:
        raise ValueError(
            f"experiment to synthesize: expected one of {', '.join(EXPERIMENTS)}, got {experiment}"
        )
    random = np.random.default_rng(seed)
    bench = _Rig(EMPTY[experiment](random), random, noise)
    known = effect_classes() if classes is None else classes
    chosen = (bench.hidden_effect(known, tell),) if hide else ()
    truth = {
        "effects": [_told(effect) for effect in chosen],
        "calibration": bench.calibration,
        "noise": bench.noise,
        "seed": seed,
    }
    return Synthesised(bench.measured(chosen), truth)


def _told(effect: Effect) -> dict[str, Any]:
    """What the seal says of an effect."""
    if isinstance(effect, HandEffect):
        return {"name": effect.kind, "where": dict(effect.where), "parameters": dict(effect.values)}
    return {"name": effect.name, "parameters": dict(effect.values)}


def write_synthesised(made: Synthesised, folder: Path, force: bool = False) -> None:
    """Write the set, and beside it the encoded file SEAL with what was hidden."""
    check_folder(folder, force)
    write_files(set_files(made.data, folder) | {folder / SEAL: sealed(made.truth)})


class _Rig:
    """The simulated rig: its true calibration and its noise."""

    def __init__(self, empty: MeasurementSet, random: np.random.Generator, noise: float) -> None:
        self.empty, self._random, self._scatter = empty, random, noise
        self.calibration = _calibration(empty, random)
        self._base = self._predicted(())
        self.noise = noise * float(np.abs(self._base).max())
        self._floor = float(np.hypot(self.noise, noise * np.sqrt(np.mean(self._base**2))))

    def hidden_effect(self, classes: Mapping[str, type[Effect]], tell: Tell) -> Effect:
        """A random effect whose change of the readings, after the best calibration, is within
        EFFECT_OVER_NOISE times the noise floor.
        """
        able = [
            effect
            for effect in self._at_places(classes).values()
            if effect.physical
            and inapplicable(effect, self.empty, "pneuflex") is None
            and (self.empty.experiment == "rubber" or not effect.refines)
        ]
        given_way = np.linalg.qr(self._nudges())[0]
        order = self._random.permutation(len(able))
        for attempt in range(MOST_DRAWS if able else 0):
            tell("drawing an effect that shows", attempt + 1, MOST_DRAWS)
            effect = self._drawn(able[order[attempt % len(able)]])
            change = self._predicted((effect,)) - self._base
            change = change - given_way @ (given_way.T @ change)
            if (
                EFFECT_OVER_NOISE[0]
                <= np.sqrt(np.mean(change**2)) / self._floor
                <= EFFECT_OVER_NOISE[1]
            ):
                return effect
        raise ValueError(
            f"effects: expected one that changes the outputs of {self.empty.experiment} more than "
            f"noise does, got {', '.join(sorted(classes)) or 'none'}; try a smaller --noise"
        )

    def _at_places(self, classes: Mapping[str, type[Effect]]) -> Mapping[str, type[Effect]]:
        empty = self.empty
        return at_places(empty.hand, classes, empty.markers) if empty.of_hand else classes

    def measured(self, effects: Sequence[Effect]) -> MeasurementSet:
        """The set with its outputs: the model with these effects, scatter of runs and noise."""
        true = self._true(effects)
        runs = []
        for index, run in enumerate(self.empty.runs):
            factor = 1.0 + self._scatter * self._random.standard_normal()
            columns = dict(run.columns)
            parts = self.empty.table.of_run(true, index)
            scales = self.empty.output_scales
            for output, part, scale in zip(self.empty.outputs, parts, scales, strict=True):
                noise = self.noise * self._random.standard_normal(run.samples)
                columns[output] = (factor * part + noise) / scale
            runs.append(replace(run, columns=columns))
        levels = (self.noise / self.empty.output_scales).tolist()
        stated = dict(zip(self.empty.outputs, levels, strict=True))
        return replace(self.empty, runs=tuple(runs), noise=stated)

    def _true(self, effects: Sequence[Effect]) -> Array:
        """What the rig does (samples,): what the model predicts; hands in motion,
        pressed ones and those that grasp are followed in shorter steps, and cut otherwise.
        """
        made = {HAND_MOTION: moved_hand, PRESS: pressed_hand, GRASP: grasped}.get(
            self.empty.experiment
        )
        if made is None:
            return self._predicted(effects)
        (scale,) = self.calibration["modulus_scale"].values()
        return made(self.empty, scale, tuple(effects))

    def _predicted(
        self, effects: Sequence[Effect], calibration: Mapping[str, Any] | None = None
    ) -> Array:
        """What the model predicts (samples,)."""
        known = self.calibration if calibration is None else calibration
        forward = Forward(self.empty, "pneuflex", (), tuple(effects), known, False)
        return forward.predict(np.zeros((1, 0)))[0]

    def _nudges(self) -> Array:
        """Change of the predictions (samples, k) with each number of the calibration."""
        columns = []
        for name, entry in self.calibration.items():
            moved = (
                {key: CALIBRATION_STEP * value for key, value in entry.items()}
                if isinstance(entry, Mapping)
                else CALIBRATION_STEP * entry
            )
            columns.append(self._predicted((), {**self.calibration, name: moved}) - self._base)
        return np.transpose(columns)

    def _drawn(self, effect: type[Effect]) -> Effect:
        """The effect with parameters drawn from their usual ranges."""
        values = {}
        for parameter in effect.parameters:
            low, high = parameter.typical or (parameter.low, parameter.high)
            share = self._random.uniform()
            values[parameter.name] = float(
                low * (high / low) ** share if parameter.logarithmic else low + share * (high - low)
            )
        return effect(**values)


def _calibration(empty: MeasurementSet, random: np.random.Generator) -> dict[str, Any]:
    """A true calibration, as a model file holds it."""
    if empty.experiment == "valve_pulse":
        return {
            name: value * float(random.uniform(*BATCH_MODULUS_SCALES))
            for name, value in USUAL_CONDUCTANCE.items()
        }
    return {"modulus_scale": {"A": float(random.uniform(*BATCH_MODULUS_SCALES))}}
