"""`make lab-demo`: all steps on a set with one hidden effect, with their results explained.

Every step is a command that a user would type; this module only runs them in turn and says what
their results mean. Exit status: 0 whatever the verdict, or that of the first command that failed.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from model_lab.cli.main import PROGRAM
from model_lab.measurements.units import display_of
from model_lab.report.sentences import listed

EXPERIMENT = "free_bending"
DEMO_MODEL = "base"


class StepFailed(Exception):
    """A command of the demonstration failed. Its argument is the exit status of the command."""

    def __init__(self, status: int) -> None:
        super().__init__(status)
        self.status = status


@dataclass(frozen=True)
class Demonstration:
    """The steps of `make lab-demo`: hide an effect in simulated measurements, diagnose the model,
    add the effect, and show that the error falls.

    folder: where the files are written. seed: seed of all random draws. force: whether files of an
    earlier run are overwritten.
    """

    folder: Path
    seed: int
    force: bool

    def run(self) -> None:
        """Run all steps.

        Raises StepFailed when a command fails.
        """
        data = self.folder / "set"
        _say(1, "A set is measured, on actuators that do something the model leaves out.")
        self._run("synthesize", EXPERIMENT, "--hide", "--seed", self.seed, "--out", data)
        _say(2, "The model is compared with it: how far is it off, and where?")
        before = self._json("compare", data, "--model", DEMO_MODEL, out="before.json")
        _say(3, "What is missing? The diagnosis tries every effect, and may refuse to name one.")
        found = self._json(
            "diagnose", data, "--model", DEMO_MODEL, "--report", self.folder, out="diagnosis.json"
        )
        if found["effects"]:
            self._add(data, before, found)
        else:
            print(f"\nThe verdict is {found['verdict']}: there is nothing to add.")
        _say(6, "The seal is opened.")
        truth = self._json("reveal", data, out="truth.json")
        print(f"\n{ending(found, truth)}\nAll figures on one page: {self.folder / 'report.html'}")

    def _add(self, data: Path, before: dict[str, Any], found: dict[str, Any]) -> None:
        named = [effect["name"] for effect in found["effects"]]
        _say(4, f"The model gets what it lacks: {listed(named)}.")
        model: Path | str = DEMO_MODEL
        for number, name in enumerate(named, start=1):
            last = number == len(named)
            out = self.folder / ("model.yaml" if last else f"model-{number}.yaml")
            self._run("add", name, "--data", data, "--model", model, "--out", out)
            model = out
        _say(5, "It is compared again.")
        after = self._json("compare", data, "--model", model, out="after.json")
        shown = display_of(found["unit"]).shown
        errors = [shown(held_out_error(part)) for part in (before, after)]
        print(
            f"\nThe held-out error has fallen from {errors[0]} to {errors[1]}; "
            f"the noise floor is {shown(found['noise_floor'])}."
        )

    def _json(self, *arguments: object, out: str) -> dict[str, Any]:
        path = self.folder / out
        self._run(*arguments, "--json", path)
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    def _run(self, *arguments: object) -> None:
        words = [str(argument) for argument in arguments]
        words += ["--force"] if self.force else []
        print(f"\n    $ {shlex.join([PROGRAM, *words])}\n", flush=True)
        done = subprocess.run([sys.executable, "-m", "model_lab", *words], check=False)
        if done.returncode != 0:
            raise StepFailed(done.returncode)


def ending(found: dict[str, Any], truth: dict[str, Any]) -> str:
    """A sentence on whether the diagnosis `found` names the effect that was hidden by `truth`."""
    hidden = [effect["name"] for effect in truth["effects"]]
    named = [effect["name"] for effect in found["effects"]]
    tied = [name for names in found["tied"] for name in names]
    if set(named) == set(hidden):
        verdict = "Right"
    elif set(hidden) <= {*named, *tied}:
        verdict = f"Right within its tie ({listed(tied, 'or')})"
    else:
        verdict = "Wrong" if named else "Not found"
    return f"{verdict}: {listed(hidden)} was hidden, {listed(named) or 'nothing'} was named."


def held_out_error(comparison: dict[str, Any]) -> float:
    """Held-out root mean square error, in SI units, from the JSON of `compare`."""
    return float(comparison["held_out"]["rmse"])


def _say(number: int, sentence: str) -> None:
    print(f"\n{number}. {sentence}", flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demonstration and return its exit status, as the module says. arguments: None: those
    of the command line.
    """
    parser = argparse.ArgumentParser(
        prog="softhand lab-demo",
        description="Hide an effect in simulated measurements, find it, and add it.",
    )
    parser.add_argument("--seed", type=int, default=11, help="chooses the effect and the noise")
    parser.add_argument("--out", type=Path, default=Path("out/lab-demo"), help="folder of results")
    options = parser.parse_args(arguments)
    try:
        Demonstration(options.out, options.seed, options.out.exists()).run()
    except StepFailed as failed:
        return failed.status
    return 0


if __name__ == "__main__":
    sys.exit(main())
