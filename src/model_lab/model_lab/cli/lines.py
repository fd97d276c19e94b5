"""Shell commands shown in reports: to repeat a result, and for the next steps."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from model_lab.diagnosis.result import SLIP, UNEXPLAINED, Diagnosis
from model_lab.rules import RULES
from softhand_model.model_file import ALLOW_EFFECT_FILES

LEARNED_FILE, MODEL_FILE, NEXT = "my_effect.py", "model.yaml", "next"


def diagnosed_again(arguments: argparse.Namespace) -> str:
    """The shell line that repeats a diagnosis and writes its report."""
    again = ["--seed", arguments.seed, "--report", arguments.report, "--force"]
    return _line(arguments, ["diagnose", arguments.data], arguments.model, again)


def learned_again(arguments: argparse.Namespace) -> str:
    """The shell line that learns the curve again and writes effect file and report."""
    again = ["--out", arguments.out, "--report", arguments.report, "--force"]
    return _line(arguments, ["learn", arguments.data], arguments.model, again)


def after_diagnosis(
    arguments: argparse.Namespace, diagnosis: Diagnosis, may_learn: bool = True
) -> list[str]:
    """Shell lines for the next steps: `plan`, if effects are tied; `add` for each missing effect;
    `learn`, if much error is left. No lines if the verdict is a slip, which must be corrected
    first.

    may_learn: whether the line with `learn` may be given.
    """
    if diagnosis.verdict == SLIP:
        return []
    names = [effect.name for effect in diagnosis.effects]
    models = [arguments.model, *numbered(MODEL_FILE, len(names))]
    lines = [
        _line(arguments, ["add", name, "--data", arguments.data], old, ["--out", new])
        for name, (old, new) in zip(names, pairwise(models), strict=True)
    ]
    if any(diagnosis.tied) and diagnosis.next_experiment is not None:
        planned = _line(arguments, ["plan", arguments.data], arguments.model, ["--out", NEXT])
        lines.insert(0, planned)
    much = diagnosis.rmse_after > RULES.rest_error * diagnosis.noise_floor
    unexplained = (diagnosis.verdict_mended or diagnosis.verdict) == UNEXPLAINED
    if may_learn and (unexplained or (names and much)):
        lines.append(
            _line(arguments, ["learn", arguments.data], models[-1], ["--out", LEARNED_FILE])
        )
    return lines


def after_learning(arguments: argparse.Namespace, files: Sequence[Path]) -> list[str]:
    """Shell lines that add the learned curves to the model, one after the other."""
    models = [arguments.model, *(file.with_suffix(".yaml") for file in files)]
    lines = []
    for file, (old, new) in zip(files, pairwise(models), strict=True):
        given = ["add", file.stem, "--effects", file, "--data", arguments.data]
        own = [] if old is models[0] or arguments.allow_effect_files else [ALLOW_EFFECT_FILES]
        lines.append(_line(arguments, given, old, [*own, "--out", new]))
    return lines


def numbered(name: str, count: int) -> list[str]:
    """A list of `count` file names: the first as given, the others numbered.

    >>> numbered("model.yaml", 2)
    ['model.yaml', 'model_2.yaml']
    """
    stem, _, suffix = name.partition(".")
    return [name, *(f"{stem}_{number}.{suffix}" for number in range(2, count + 1))][:count]


def _line(
    arguments: argparse.Namespace, start: Iterable[object], model: object, end: Iterable[object]
) -> str:
    """A command with a model, and the modulus and effects of the one that was given."""
    words = [*start, "--model", model]
    if arguments.free_modulus:
        words.append("--free-modulus")
    for path in arguments.effects:
        words += ["--effects", path]
    if arguments.allow_effect_files:
        words.append(ALLOW_EFFECT_FILES)
    return shlex.join(["model-lab", *map(str, [*words, *end])])
