"""Finding the classes of effects: built-in ones in this package, a user's in one Python file."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from softhand_model.effects.effect import Effect
from softhand_model.effects.stages import (
    ElasticEffect,
    FlowEffect,
    InputEffect,
    LoadEffect,
    OutputEffect,
    StructureEffect,
)

STAGE_CLASSES: tuple[type[Effect], ...] = (
    InputEffect,
    LoadEffect,
    ElasticEffect,
    StructureEffect,
    OutputEffect,
    FlowEffect,
)
# what alone changes no prediction
NOT_ENOUGH = ("allows", "remember", "of", "by_direction", "leak")


@lru_cache(maxsize=1)
def _built_in() -> dict[str, type[Effect]]:
    package = importlib.import_module("softhand_model.effects")
    found: dict[str, type[Effect]] = {}
    for entry in pkgutil.iter_modules(package.__path__):
        found.update(_classes_of(importlib.import_module(f"{package.__name__}.{entry.name}")))
    return dict(sorted(found.items()))


def effect_classes() -> dict[str, type[Effect]]:
    """Built-in effects by name.

    >>> effect_classes()["gravity"].stage
    'load'
    """
    return dict(_built_in())


def effects_in_file(path: Path) -> dict[str, type[Effect]]:
    """Effects that a Python file defines, by name; the file is executed.

    Raises ValueError when the file is missing, fails or defines none, and for an effect that could
    not act: of no stage's class, without a method of its stage, or with the name of a built-in one.
    """
    if not path.is_file():
        raise ValueError(f"{path}: expected a Python file with an effect, got no such file")
    spec = importlib.util.spec_from_file_location(f"softhand_user_effects_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ValueError(
            f"{path}: expected a Python file with an effect, got {path.suffix or 'no suffix'}"
        )
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as reason:
        raise ValueError(
            f"{path}: expected a Python file that runs, got {type(reason).__name__}: {reason}"
        ) from reason
    found = _classes_of(module)
    if not found:
        raise ValueError(
            f"{path}: expected a subclass of softhand_model.effects.Effect with a name, got none"
        )
    for effect in found.values():
        _check(effect, path)
    return found


def _check(effect: type[Effect], path: Path) -> None:
    """Refuse an effect that could not act."""
    of_stage = next((base for base in STAGE_CLASSES if issubclass(effect, base)), None)
    if of_stage is None:
        wanted, got = _listed(base.__name__ for base in STAGE_CLASSES), "another base class"
        raise ValueError(
            f"{path}: effect {effect.name}: expected a subclass of one of {wanted}, got {got}"
        )
    methods = [name for name, member in vars(of_stage).items() if inspect.isfunction(member)]
    methods = [name for name in methods if name not in NOT_ENOUGH]
    if not any(getattr(effect, name) is not getattr(of_stage, name) for name in methods):
        raise ValueError(
            f"{path}: effect {effect.name}: expected a method of its stage, "
            f"{_listed(methods, 'or')}, got none"
        )
    if effect.name in _built_in():
        raise ValueError(
            f"{path}: effect {effect.name}: expected a name that no built-in effect has; "
            "choose another one"
        )


def _listed(names: Iterable[str], last: str = "and") -> str:
    *others, end = names
    return f"{', '.join(others)} {last} {end}" if others else end


def _classes_of(module: ModuleType) -> dict[str, type[Effect]]:
    """Named effects that a module itself defines."""
    return {
        member.name: member
        for _, member in inspect.getmembers(module, inspect.isclass)
        if issubclass(member, Effect) and member.name and member.__module__ == module.__name__
    }
