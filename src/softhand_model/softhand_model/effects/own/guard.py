"""Guard around the methods of a user's own effects, which reports their errors in one line.

A guarded method gets its arguments as arrays that cannot be changed. A call must end within
`CALL_LIMIT`, and must return finite numbers in a shape to which the arguments broadcast.
"""

from __future__ import annotations

import functools
import inspect
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from softhand_common.documents.quoted import quoted, shortened
from softhand_common.numerics.arrays import Array
from softhand_model.effects.effect import Effect
from softhand_model.effects.stages import FlowEffect, Pulse

CALL_LIMIT = 5.0  # processor time of one call [s]
WAIT_LIMIT = 60.0  # wall time of one call that waits for something [s]


class EffectError(ValueError):
    """An error in a user's effect; the message has its file, class and method."""


class _TooLong(BaseException):
    """A call has not ended in time; a user's `except Exception` does not catch this."""


def guard(effect: type[Effect], of_stage: type[Effect], path: Path) -> None:
    """Make the methods of a user's effect report their errors with file, class and method.

    Replaces each overridden method by a guarded one (see the module), and sets `effect.origin`.

    Args:
        effect: class in the user's file.
        of_stage: the base class of its stage.
        path: the file, for messages.
    """
    effect.origin = f"{path}: {effect.__name__}"
    for name in own_methods(effect, of_stage):
        place = f"{effect.origin}.{name}"
        setattr(effect, name, _guarded(getattr(effect, name), place))


def own_methods(effect: type[Effect], of_stage: type[Effect]) -> list[str]:
    """Methods of the base class of a stage that an effect class overrides, in the order of the base
    class.
    """
    return [
        name
        for name in stage_methods(of_stage)
        if getattr(effect, name) is not getattr(of_stage, name)
    ]


def stage_methods(of_stage: type[Effect]) -> list[str]:
    """Names of the methods of the base class of a stage."""
    return [name for name, member in vars(of_stage).items() if inspect.isfunction(member)]


def _guarded(method: Callable[..., Any], place: str) -> Callable[..., Any]:
    check = CHECKS.get(method.__name__, _check_numbers)

    @functools.wraps(method)
    def call(effect: Effect, *given: Any, **named: Any) -> Any:
        positional = [_frozen(value) for value in given]
        by_name = {name: _frozen(value) for name, value in named.items()}
        with effect_errors(place):
            found = method(effect, *positional, **by_name)
        return check(found, effect, [*given, *named.values()], place)

    return call


@contextmanager
def effect_errors(place: str) -> Iterator[None]:
    """Context in which code of a user runs; any error in it is raised as an `EffectError` that
    begins with `place`.
    """
    try:
        with _time_limit():
            yield
    except KeyboardInterrupt:
        raise
    except EffectError:
        raise
    except SystemExit as reason:
        raise EffectError(
            f"{place}: expected the code to return, got sys.exit({quoted(reason.code)})"
        ) from reason
    except _TooLong as limit:
        raise EffectError(f"{place}: expected the code to end within {limit}, got longer") from None
    except BaseException as reason:
        if isinstance(reason, ValueError) and "read-only" in str(reason):
            wanted, got = "arguments left as they are", "a change in place"
        else:
            wanted, got = "it to run", shortened(f"{type(reason).__name__}: {reason}")
        raise EffectError(f"{place}: expected {wanted}, got {got}") from reason


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise _TooLong after a limit; in the main thread only, as Python has alarms only there."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    with (
        _alarm(signal.ITIMER_VIRTUAL, signal.SIGVTALRM, CALL_LIMIT, "processor time"),
        _alarm(signal.ITIMER_REAL, signal.SIGALRM, WAIT_LIMIT, "wall time"),
    ):
        yield


@contextmanager
def _alarm(timer: int, number: signal.Signals, limit: float, what: str) -> Iterator[None]:
    def ring(number: int, frame: FrameType | None) -> None:
        raise _TooLong(f"{limit:g} s of {what}")

    handler = signal.signal(number, ring)
    left, interval = signal.setitimer(timer, limit)
    try:
        yield
    finally:
        signal.setitimer(timer, left, interval)
        signal.signal(number, handler)


def _frozen(value: Any) -> Any:
    """The same argument, its arrays as views that cannot be written."""
    if isinstance(value, np.ndarray):
        view = value.view()
        view.flags.writeable = False
        return view
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: _frozen(getattr(value, f.name)) for f in fields(value)})
    return value


def _check_numbers(found: Any, effect: Effect, given: list[Any], place: str) -> Any:
    numbers = (
        np.asarray(found) if isinstance(found, np.ndarray | np.generic | int | float) else None
    )
    if numbers is None or numbers.dtype.kind not in "iuf":
        raise EffectError(f"{place}: expected numbers, got {quoted(found)}")
    arrays = [*_arrays(given), *_values(effect)]
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    if not _fits(numbers.shape, shape):
        raise EffectError(f"{place}: expected the shape {shape}, got {numbers.shape}")
    finite = np.isfinite(numbers)
    if not finite.all() and all(np.isfinite(array).all() for array in arrays):
        got = float(numbers[~finite].flat[0]) if numbers.ndim else float(numbers)
        raise EffectError(f"{place}: expected finite numbers, got {got}")
    return numbers if numbers.ndim == 0 or numbers.flags.writeable else numbers.copy()


def _fits(shape: tuple[int, ...], whole: tuple[int, ...]) -> bool:
    try:
        return np.broadcast_shapes(shape, whole) == whole
    except ValueError:
        return False


def _arrays(given: list[Any]) -> list[Array]:
    """The numbers among arguments, and within those that are dataclasses."""
    found: list[Array] = []
    for value in given:
        if is_dataclass(value) and not isinstance(value, type):
            found += _arrays([getattr(value, field.name) for field in fields(value)])
        elif isinstance(value, np.ndarray | np.generic | int | float):
            found.append(np.asarray(value))
    return found


def _values(effect: Effect) -> list[Array]:
    """The effect's parameters in the shape in which its stage has them."""
    lanes = (-1, 1) if isinstance(effect, FlowEffect) else (-1, 1, 1)
    values = [np.asarray(value) for value in effect.values.values()]
    return [value.reshape(lanes) if value.ndim else value for value in values]


def _check_pulse(found: Any, effect: Effect, given: list[Any], place: str) -> Pulse:
    if not isinstance(found, Pulse):
        raise EffectError(f"{place}: expected a Pulse, got {quoted(found)}")
    for field in fields(found):
        if field.name != "inflating":
            _check_numbers(getattr(found, field.name), effect, given, f"{place}: {field.name}")
    return found


def _check_flags(found: Any, effect: Effect, given: list[Any], place: str) -> Any:
    if np.asarray(found).dtype.kind != "b":
        raise EffectError(f"{place}: expected true or false, got {quoted(found)}")
    return found


def _check_nothing(found: Any, effect: Effect, given: list[Any], place: str) -> None:
    if found is not None:
        raise EffectError(f"{place}: expected nothing returned, got {quoted(found)}")


CHECKS = {"act_on_pulse": _check_pulse, "allows": _check_flags, "remember": _check_nothing}
