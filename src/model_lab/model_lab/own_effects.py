"""Effects of the user's own: the classes in Python files, which are run to find them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from softhand_model.effects import Effect, effect_classes, effects_in_file
from softhand_model.effects.effect import EXPERIMENTS
from softhand_model.model_file import Model


def own_classes(files: Iterable[Path]) -> dict[str, type[Effect]]:
    """Effect classes by effect name, from Python files, which are run.

    Raises ValueError for an effect that acts in no experiment, and for an effect name that two
    files use.
    """
    found: dict[str, type[Effect]] = {}
    for path in files:
        for name, effect in effects_in_file(path).items():
            if name in found:
                raise ValueError(
                    f"{path}: effect: expected a name that no other file uses, got {name} again"
                )
            if not effect.experiments:
                raise ValueError(
                    f"{path}: effect {name}: experiments: expected some of "
                    f"{', '.join(EXPERIMENTS)}, got none"
                )
            found[name] = effect
    return found


def file_of_each(files: Iterable[Path]) -> dict[str, Path]:
    """The Python file that defines each effect, by effect name."""
    return {name: path for path in files for name in effects_in_file(path)}


def all_classes(model: Model, files: Iterable[Path]) -> dict[str, type[Effect]]:
    """Effect classes by effect name: built-in ones, those in the model, and those in the files."""
    of_model = {effect.name: type(effect) for effect in model.effects}
    return {**effect_classes(), **of_model, **own_classes(files)}
