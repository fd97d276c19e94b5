"""Finding the classes of effects: the built-in ones, in the modules of this package."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import lru_cache
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


@lru_cache(maxsize=1)
def _built_in() -> dict[str, type[Effect]]:
    package = importlib.import_module("softhand_model.effects")
    found: dict[str, type[Effect]] = {}
    for entry in pkgutil.iter_modules(package.__path__):
        found.update(classes_of(importlib.import_module(f"{package.__name__}.{entry.name}")))
    return dict(sorted(found.items()))


def effect_classes() -> dict[str, type[Effect]]:
    """Built-in effects by name.

    >>> effect_classes()["gravity"].stage
    'load'
    """
    return dict(_built_in())


def classes_of(module: ModuleType) -> dict[str, type[Effect]]:
    """Named effects that a module itself defines."""
    return {
        member.name: member
        for _, member in inspect.getmembers(module, inspect.isclass)
        if issubclass(member, Effect) and member.name and member.__module__ == module.__name__
    }
