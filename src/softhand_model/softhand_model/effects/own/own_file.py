"""Effects in a user's own Python file: rehearsed in another process, then loaded and guarded.

Such a file is code: nothing here runs unless the user has asked for it. The rehearsal calls every
method once with plausible arguments, so that a file that ends or blocks its process does so there.
"""

from __future__ import annotations

import importlib.util
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from softhand_model.effects.catalogue import STAGE_CLASSES, classes_of, effect_classes
from softhand_model.effects.effect import Effect
from softhand_model.effects.own.guard import (
    EffectError,
    effect_errors,
    guard,
    own_methods,
    stage_methods,
)

REHEARSAL = "softhand_model.effects.own.rehearsal"
REHEARSAL_LIMIT = 30  # processor time of the whole [s]
REHEARSAL_WAIT = 300.0  # wall time of the whole [s]
THROUGH = "through"  # what a rehearsal says that has found nothing wrong
NOT_ENOUGH = ("allows", "remember", "of", "by_direction", "leak")  # alone changes no prediction


def effects_in_file(path: Path) -> dict[str, type[Effect]]:
    """Effect classes that a Python file defines, by name, with their methods guarded. The file is
    executed, first in a process of its own.

    Raises ValueError if the file is missing, fails or defines no effect; for an effect that derives
    from no class of a stage, has no method of its stage, or has the name of a built-in one; and for
    one that fails its rehearsal.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"{path}: expected a Python file with an effect, got no such file")
    status = path.stat()
    refusal = _rehearsed(str(path), status.st_mtime_ns, status.st_size)
    if refusal:
        raise EffectError(refusal)
    return load_guarded(path)


@lru_cache
def _rehearsed(path: str, changed: int, size: int) -> str:
    """The errors of a file, empty for none; checked again when the file has changed."""
    reader, writer = os.pipe()
    command = [sys.executable, "-P", "-m", REHEARSAL, path, str(writer)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with os.fdopen(reader, encoding="utf-8", errors="replace") as said:
        try:
            status = subprocess.run(
                command,
                pass_fds=(writer,),
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=REHEARSAL_WAIT,
                preexec_fn=_limit_processor_time,
            ).returncode
        except subprocess.TimeoutExpired:
            return (
                f"{path}: expected the code to end within {REHEARSAL_WAIT:g} s of wall time, "
                "got longer"
            )
        finally:
            os.close(writer)
        verdict = said.read()
    if status == -signal.SIGXCPU:
        return (
            f"{path}: expected the code to end within {REHEARSAL_LIMIT} s of processor time, "
            "got longer"
        )
    if verdict:
        return "" if verdict == THROUGH else verdict
    left = f"{path}: expected it to return, got the end of its process, status {status}"
    return left


def _limit_processor_time() -> None:
    """Of the calling process, which is ended by SIGXCPU."""
    resource.setrlimit(resource.RLIMIT_CPU, (REHEARSAL_LIMIT, REHEARSAL_LIMIT + 1))


def load_guarded(path: Path) -> dict[str, type[Effect]]:
    """Effect classes of a file, which is executed in this process, checked and guarded."""
    found = classes_of(_executed(path))
    if not found:
        raise ValueError(
            f"{path}: expected a class derived from softhand_model.effects.Effect that has a name "
            "(name = 'my_effect'), got no such class"
        )
    for effect in found.values():
        guard(effect, _checked_stage(effect, path), path)
    return found


def _executed(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"softhand_user_effects_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ValueError(
            f"{path}: expected a Python file with an effect, got {path.suffix or 'no suffix'}"
        )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where numba looks for it when it loads a compiled kernel
    with effect_errors(str(path)):
        spec.loader.exec_module(module)
    return module


def _checked_stage(effect: type[Effect], path: Path) -> type[Effect]:
    """The class of an effect's stage; refuses an effect that could not act."""
    of_stage = next((base for base in STAGE_CLASSES if issubclass(effect, base)), None)
    if of_stage is None:
        wanted, got = _listed(base.__name__ for base in STAGE_CLASSES), "another base class"
        raise ValueError(
            f"{path}: effect {effect.name}: expected a subclass of one of {wanted}, got {got}"
        )
    if not set(own_methods(effect, of_stage)) - set(NOT_ENOUGH):
        methods = [name for name in stage_methods(of_stage) if name not in NOT_ENOUGH]
        raise ValueError(
            f"{path}: effect {effect.name}: expected a method of its stage, "
            f"{_listed(methods, 'or')}, got none"
        )
    if effect.name in effect_classes():
        raise ValueError(
            f"{path}: effect {effect.name}: expected a name that no built-in effect has; "
            "choose another one"
        )
    return of_stage


def _listed(names: Iterable[str], last: str = "and") -> str:
    *others, end = names
    return f"{', '.join(others)} {last} {end}" if others else end
