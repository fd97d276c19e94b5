"""Finding the classes of effects: built-in ones in this package, a user's in one Python file."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from softhand_model.effects.effect import Effect


@lru_cache(maxsize=1)
def _built_in() -> dict[str, type[Effect]]:
    package = importlib.import_module("softhand_model.effects")
    found: dict[str, type[Effect]] = {}
    for entry in sorted(pkgutil.iter_modules(package.__path__), key=lambda entry: entry.name):
        found.update(_classes_of(importlib.import_module(f"{package.__name__}.{entry.name}")))
    return found


def effect_classes() -> dict[str, type[Effect]]:
    """Built-in effects by name.

    >>> effect_classes()["gravity"].stage
    'load'
    """
    return dict(_built_in())


def effects_in_file(path: Path) -> dict[str, type[Effect]]:
    """Effects that a Python file defines, by name; the file is executed.

    Raises ValueError when the file is missing, fails or defines none.
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
    return found


def _classes_of(module: ModuleType) -> dict[str, type[Effect]]:
    """Named effects that a module itself defines."""
    return {
        member.name: member
        for _, member in inspect.getmembers(module, inspect.isclass)
        if issubclass(member, Effect) and member.name and member.__module__ == module.__name__
    }
