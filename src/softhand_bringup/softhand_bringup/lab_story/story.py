"""The lab story: an effect hidden in the simulator is measured, diagnosed, added and monitored.

The lab is used through its commands.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from threading import Event
from typing import Any

from model_lab.comparison.add import write_model
from softhand_bringup.lab_story.lab_command import run_lab
from softhand_bringup.lab_story.measuring import CHECK_PLAN, FULL_PLAN, Plan, PlayedRun, finger
from softhand_bringup.lab_story.picture import draw
from softhand_bringup.lab_story.recorded import live_residual, still_stamps, write_set
from softhand_common.documents.output_file import write_file
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

LAB_BASE_MODEL = "base"  # the shipped model without effects
NOTHING_HIDDEN = "nothing"
HIDDEN_EFFECTS: Mapping[str, Mapping[str, float]] = {
    "viscoelasticity": {"relative_modulus": 0.3, "relaxation_time": 1.2},
    "gent_stiffening": {"jm": 4.0},
    NOTHING_HIDDEN: {},
}


Rig = Callable[[Path, Plan, Path, str], list[PlayedRun]]


@dataclass(frozen=True)
class Watched:
    """A session: its runs and the rms of the monitor's residual in them [rad]."""

    runs: list[PlayedRun]
    residual: float


@dataclass
class HiddenEffectRun:
    """Measures, diagnoses, adds the diagnosed effects, and measures again.

    Args:
        rig: function that runs a plan and records into a folder, with the model files of the
            simulator and of the monitor.
        folder: folder for hidden.yaml, measured/, set/, diagnosis.json, report.html, model.yaml,
            mended/, result.json and live.png.
        hidden: name of the hidden effect, a key of HIDDEN_EFFECTS.
        say: prints one line.
        stopped: set when the user wants to end.
        plan, check: measurements for the diagnosis, and measurements with the improved model.
        report: whether the lab also writes its HTML report.
    """

    rig: Rig
    folder: Path
    hidden: str
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)
    plan: Plan = FULL_PLAN
    check: Plan = CHECK_PLAN
    report: bool = True

    def run(self) -> dict[str, Any]:
        """Run all steps; returns the content of result.json, with angles in [rad].

        Raises:
            RunFailed: a session or a command of the lab failed.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        truth = self._hide()
        self.say("1. A finger is measured over ROS; the monitor predicts it with the base model.")
        before = self._measure(truth)
        self.say("2. Which effect does the model lack? The lab gets only the bags.")
        found = self._diagnose()
        runs = {"measured": [asdict(run) for run in before.runs]}
        result = {
            "hidden": self._hidden(),
            "diagnosis": found,
            "live_before": before.residual,
            "runs": runs,
        }
        if found["effects"]:
            self.say("3. The effect is added to the model.")
            mended = self._add([effect["name"] for effect in found["effects"]])
            self.say("4. The same finger again; the monitor has the improved model.")
            after = self._watch("mended", self.check, truth, mended)
            runs["mended"] = [asdict(run) for run in after.runs]
            result["live_after"] = after.residual
        self._write(result)
        self._conclude(result)
        return result

    def _hidden(self) -> list[dict[str, Any]]:
        if self.hidden == NOTHING_HIDDEN:
            return []
        return [{"name": self.hidden, "parameters": dict(HIDDEN_EFFECTS[self.hidden])}]

    def _write(self, result: dict[str, Any]) -> None:
        text = json.dumps(result, indent=2) + "\n"
        write_file(self.folder / "result.json", text)
        if "live_after" in result:
            draw(self.folder, self.folder / "live.png")

    def _conclude(self, result: dict[str, Any]) -> None:
        before, after = result["live_before"], result.get("live_after")
        if after is None:
            verdict = result["diagnosis"]["verdict"]
            self.say(
                f"The verdict is {verdict}: there is nothing to add. "
                f"Live residual {_degrees(before)}."
            )
        else:
            self.say(
                f"Live residual at constant pressure: {_degrees(before)} before, "
                f"{_degrees(after)} after, {before / after:.1f} times smaller; "
                f"drawn in {self.folder / 'live.png'}."
            )
        self.say(f"The hidden effect: {self._revealed()}.")

    def _revealed(self) -> str:
        values = ", ".join(
            f"{key} = {value:g}" for key, value in HIDDEN_EFFECTS[self.hidden].items()
        )
        return f"{self.hidden}, {values}" if values else self.hidden

    def _hide(self) -> Path:
        """Write the model file of the simulator: without gravity, as in a horizontal plane."""
        chosen = [] if self.hidden == NOTHING_HIDDEN else [effect_classes()[self.hidden]]
        effects = tuple(effect(**HIDDEN_EFFECTS[self.hidden]) for effect in chosen)
        path = self.folder / "hidden.yaml"
        write_model(path, Model(effects=effects), "What the simulator does and the lab must find")
        return path

    def _measure(self, truth: Path) -> Watched:
        """Record with the base model and write the measurement set."""
        watched = self._watch("measured", self.plan, truth, LAB_BASE_MODEL)
        bag = self.folder / "measured" / "bag"
        write_set(self.folder / "set", bag, watched.runs, still_stamps(bag), finger())
        self.say(f"{len(watched.runs)} runs, a bag each, in {self.folder}/set")
        return watched

    def _diagnose(self) -> dict[str, Any]:
        path = self.folder / "diagnosis.json"
        page = ("--report", self.folder) if self.report else ()
        self._lab("diagnose", self.folder / "set", "--model", LAB_BASE_MODEL, "--json", path, *page)
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return found

    def _add(self, names: list[str]) -> str:
        model = LAB_BASE_MODEL
        for number, name in enumerate(names, start=1):
            out = self.folder / ("model.yaml" if number == len(names) else f"model-{number}.yaml")
            self._lab("add", name, "--data", self.folder / "set", "--model", model, "--out", out)
            model = str(out)
        return model

    def _watch(self, name: str, plan: Plan, truth: Path, model: str) -> Watched:
        """Run a plan; the monitor has this model."""
        runs = self.rig(self.folder / name, plan, truth, model)
        bag = self.folder / name / "bag"
        return Watched(runs, live_residual(bag, runs, still_stamps(bag)))

    def _lab(self, *arguments: object) -> None:
        run_lab(self.say, self.stopped, *arguments)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.2f} deg"
