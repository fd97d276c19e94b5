"""The lab's story of a hand: something is changed in one place of a simulated hand, which the lab
finds from a recording, adds to the model, and gives back to the simulator.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np

from model_lab.comparison.add import write_model
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import down_of
from model_lab.report.hand_in_space import draw
from softhand_bringup.lab_story.free_poses import free_poses
from softhand_bringup.lab_story.lab_command import run_lab
from softhand_common.documents.output_file import write_file
from softhand_common.numerics.arrays import Array
from softhand_model.effects.hand import ActuatorScatter, Crosstalk, HandEffect, MountTilt
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import Model, load_model

BASE_MODEL = "gravity"  # the shipped model of a hand: weight, and nothing that is missing
HIDDEN_SIZES: Mapping[str, Callable[[np.random.Generator], dict[str, float]]] = {
    "crosstalk": lambda random: {"share": float(random.uniform(0.12, 0.25))},
    "actuator_scatter": lambda random: {
        "modulus_factor": float(random.uniform(0.65, 0.8) ** random.choice([-1.0, 1.0]))
    },
    "mount_tilt": lambda random: dict(
        zip(("roll", "pitch", "yaw"), _turn(random, 0.1).tolist(), strict=True)
    ),
}  # what may be hidden, and how large it is
HIDDEN_KINDS: Mapping[str, type[HandEffect]] = {
    effect.name: effect for effect in (Crosstalk, ActuatorScatter, MountTilt)
}

SAME_POSE = 2.0  # [kPa] of a pressure, and in tenths of the way down

Rig = Callable[[Path, Path, Path], Path]


@dataclass
class HandStory:
    """Records a hand that hides an effect, diagnoses it, adds what is found, and records the
    simulator with the new model.

    Args:
        rig: function of (folder, strategy, model) that runs a strategy with a model file in the
            simulator, records it into the folder, and returns the bag.
        folder: folder for hidden.yaml, poses.yaml, measured/, set/, diagnosis.json, report.html,
            model.yaml, mended/, hand.png and result.json.
        hand: name or file of the hand.
        hidden: a key of HIDDEN_SIZES.
        seed: seed of the place and the size of the hidden effect.
        say: prints one line.
        stopped: set when the user wants to end.
    """

    rig: Rig
    folder: Path
    hand: str
    hidden: str
    seed: int
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)

    def run(self) -> dict[str, Any]:
        """Run all steps; returns the content of result.json, with errors in [m].

        Raises:
            RunFailed: a session or a command of the lab failed.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        hand = load_hand(self.hand)
        truth, poses = self.folder / "hidden.yaml", self.folder / "poses.yaml"
        effect = hidden_effect(hand, self.hidden, np.random.default_rng(self.seed))
        weight = load_model(BASE_MODEL).effects
        write_model(truth, Model(effects=(*weight, effect)), "What the lab must find")
        write_file(poses, free_poses(hand, self.hand))
        self.say("1. A hand holds poses in free air; the recording becomes a set.")
        measured = self._recorded("measured", "set", poses, truth)
        self.say("2. What does the model lack, and where? The lab gets only the set.")
        self._lab("compare", measured, "--model", BASE_MODEL, "--json", self.folder / "before.json")
        page = ("--json", self.folder / "diagnosis.json", "--report", self.folder)
        self._lab("diagnose", measured, "--model", BASE_MODEL, *page)
        found = self._read("diagnosis.json")
        before = self._read("before.json")
        result = {
            "hidden": {"name": effect.kind, "where": dict(effect.where), **effect.values},
            "right": is_right(effect, found),
            "diagnosis": found,
            "error_before": before["rmse"],
            "noise_floor": before["noise_floor"],
        }
        if found["effects"]:
            result |= self._mended(measured, poses, found)
        write_file(self.folder / "result.json", json.dumps(result, indent=2) + "\n")
        self._conclude(result)
        return result

    def _mended(self, measured: Path, poses: Path, found: Mapping[str, Any]) -> dict[str, float]:
        """Add what was found, and hold the same poses with the new model in the simulator."""
        self.say("3. What was found is added to the model.")
        model = BASE_MODEL
        for number, entry in enumerate(found["effects"], start=1):
            last = number == len(found["effects"])
            out = self.folder / ("model.yaml" if last else f"model-{number}.yaml")
            self._lab("add", _named(entry), "--data", measured, "--model", model, "--out", out)
            model = str(out)
        after = self.folder / "after.json"
        self._lab("compare", measured, "--model", model, "--json", after)
        models = [(name, load_model(name)) for name in (BASE_MODEL, model)]
        titled = [(title, one) for title, (_, one) in zip(("before", "after"), models, strict=True)]
        draw(load_measurements(measured), titled, self.folder / "hand.png")
        self.say("4. The simulator holds the same poses with the new model.")
        again = self._recorded("mended", "mended_set", poses, Path(model))
        return {
            "error_after": self._read("after.json")["rmse"],
            "error_simulated": distance(measured, again),
        }

    def _recorded(self, session: str, into: str, poses: Path, model: Path) -> Path:
        bag = self.rig(self.folder / session, poses, model)
        out = self.folder / into
        self._lab("import", bag, "--hand", self.hand, "-o", out, "--yes")
        return out

    def _read(self, name: str) -> dict[str, Any]:
        found: dict[str, Any] = json.loads((self.folder / name).read_text(encoding="utf-8"))
        return found

    def _lab(self, *arguments: object) -> None:
        run_lab(self.say, self.stopped, *arguments)

    def _conclude(self, result: Mapping[str, Any]) -> None:
        hidden = result["hidden"]
        place = ", ".join(f"{key} {name}" for key, name in hidden["where"].items())
        verdict = "found" if result["right"] else "not found"
        self.say(f"Hidden was {hidden['name']} ({place}): {verdict}.")
        before, floor = 1e3 * result["error_before"], 1e3 * result["noise_floor"]
        if "error_after" not in result:
            self.say(f"Error {before:.2f} mm, noise floor {floor:.2f} mm; nothing was added.")
            return
        after, again = 1e3 * result["error_after"], 1e3 * result["error_simulated"]
        self.say(
            f"Error {before:.2f} mm before, {after:.2f} mm after ({before / after:.1f} times "
            f"smaller), noise floor {floor:.2f} mm; the simulator with the new model is {again:.2f}"
            f" mm from the hand; drawn in {self.folder / 'hand.png'}."
        )


def hidden_effect(hand: HandDescription, kind: str, random: np.random.Generator) -> HandEffect:
    """An effect of a kind, with a size and a place that are drawn from `random`."""
    effect = HIDDEN_KINDS[kind]
    places = effect.places(hand)
    return effect.at(**places[int(random.integers(len(places)))])(**HIDDEN_SIZES[kind](random))


def is_right(hidden: HandEffect, found: Mapping[str, Any]) -> bool:
    """Whether a diagnosis (`found`, its JSON) names the hidden effect at its place, and nothing
    else.
    """
    truth = hidden.kind, dict(hidden.where)
    return [(entry["name"], entry.get("where", {})) for entry in found["effects"]] == [truth]


def distance(one: Path, other: Path) -> float:
    """Distance [m] between the markers of two measurement sets in the same poses, root mean square
    over all coordinates. Poses of `one` that are not in `other` are left out, as a recording may
    miss a pose that was not at rest. Raises ValueError for sets without a common pose.
    """
    (inputs, places), (others, other_places) = _poses(one), _poses(other)
    off = np.abs(inputs[:, None] - others).max(axis=2)
    nearest = off.argmin(axis=1)
    alike = off.min(axis=1) < SAME_POSE
    if not alike.any():
        raise ValueError(f"{other}: expected poses as in {one}, got no common pose")
    return float(np.sqrt(np.mean((places[alike] - other_places[nearest[alike]]) ** 2)))


def _poses(folder: Path) -> tuple[Array, Array]:
    """Inputs (poses, channels + 3): pressures [kPa], way down [0.1]; markers (poses, 3 n) [m]."""
    data = load_measurements(folder)
    inputs, places = [], []
    for run in data.runs:
        pressures = 1e-3 * np.array([run.columns[name] for name in data.inputs]).T
        inputs.append(np.hstack([pressures, np.tile(10.0 * down_of(run), (run.samples, 1))]))
        places.append(np.array([run.columns[name] for name in data.outputs]).T)
    return np.concatenate(inputs), np.concatenate(places)


def _named(entry: Mapping[str, Any]) -> str:
    """An effect of a diagnosis as `model-lab add` takes it."""
    where = entry.get("where")
    return f"{entry['name']}[{'>'.join(where.values())}]" if where else str(entry["name"])


def _turn(random: np.random.Generator, angle: float) -> Array:
    way = random.standard_normal(3)
    return np.asarray(angle * way / np.linalg.norm(way))
