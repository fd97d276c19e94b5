"""Effects of the user's own, from Python files, which are run, and all that take part with them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from softhand_model.effects import Effect, effect_classes, effects_in_file
from softhand_model.effects.effect import EXPERIMENTS
from softhand_model.model_file import Model


def own_classes(files: Iterable[Path]) -> dict[str, type[Effect]]:
    """The effects of the files, by name.

    Raises ValueError for one that acts in no experiment, or in two files.
    """
    found: dict[str, type[Effect]] = {}
    for path in files:
        for name, effect in effects_in_file(path).items():
            if name in found:
                raise ValueError(f"{path}: effect: expected a name of its own, got {name} again")
            if not effect.experiments:
                raise ValueError(
                    f"{path}: effect {name}: experiments: expected some of "
                    f"{', '.join(EXPERIMENTS)}, got none"
                )
            found[name] = effect
    return found


def file_of_each(files: Iterable[Path]) -> dict[str, Path]:
    """The file of each of these effects, by its name."""
    return {name: path for path in files for name in effects_in_file(path)}


def all_classes(model: Model, files: Iterable[Path]) -> dict[str, type[Effect]]:
    """Effects that take part: built-in ones, those of a model, and those of the files."""
    of_model = {effect.name: type(effect) for effect in model.effects}
    return {**effect_classes(), **of_model, **own_classes(files)}
