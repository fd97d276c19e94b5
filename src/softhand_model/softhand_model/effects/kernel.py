"""Kernels of effects: compiled functions that replace the methods in loops through whole runs.

An elastic effect, or one of the walls, may have a `Kernel` beside its methods. It does the same for
arrays of one axis, `lanes`: all sections of a run with all trial values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from numba import types

from softhand_common.documents.quoted import shortened
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.by_address import address_of, call_with
from softhand_common.numerics.compiled import compiled

PURE_SHEAR, UNIAXIAL, EQUIBIAXIAL, LINEAR = 0, 1, 2, 3
MODE_OF = {
    "pure_shear": PURE_SHEAR,
    "uniaxial": UNIAXIAL,
    "equibiaxial": EQUIBIAXIAL,
    "linear": LINEAR,
}
HEIGHT, WIDTH, WALL, SIDE_WALL, RATIO = range(5)
SIZES = 5


class Trial(NamedTuple):
    """A trial value of the stretch at the end of a time step.

    stretch (lanes,) [-]. dt [s]: duration of the step; 0 at the first sample of a run. accepted:
    whether the step ends with this stretch, so that the state has to be updated. mode: PURE_SHEAR,
    UNIAXIAL, EQUIBIAXIAL or LINEAR, see `stages.Strain`. sizes (5, lanes): HEIGHT, WIDTH, WALL,
    SIDE_WALL [m] and RATIO [-] of the sections.
    """

    stretch: Array
    dt: float
    accepted: bool
    mode: int
    sizes: Array


LANES, TABLE = types.float64[::1], types.float64[:, ::1]
TRIAL = types.NamedTuple((LANES, types.float64, types.boolean, types.intp, TABLE), Trial)
ACT = LANES, TRIAL, TABLE, TABLE
BEGIN_STEP = types.float64, TABLE, TABLE
call_act, call_begin_step = call_with(ACT), call_with(BEGIN_STEP)


@dataclass(frozen=True)
class Kernel:
    """The compiled form of an effect: functions decorated with `numerics.compiled.compiled`.

    act(stress, trial, values, state): changes stress (lanes,) [-] in place, from that without the
    effect to that with it. values (k, lanes): from `Effect.kernel_values`. state (m, lanes): at the
    start of the step; to be changed if `trial.accepted` is true, and only then.

    begin_step(dt, values, state): called before each step, for what depends only on its duration
    [s].

    rest: the state of a section that has rested for long, one number for each row. In `state`, the
    rows of `ElasticEffect.largest`, which belong to the specimen, come before these, in its order.

    Raises TypeError for functions without the decorator.
    """

    act: Callable[..., None]
    begin_step: Callable[..., None] | None = None
    rest: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse functions that numba has not got."""
        for name in ("act", "begin_step"):
            function = getattr(self, name)
            if not hasattr(function, "py_func") and (name, function) != ("begin_step", None):
                raise TypeError(
                    f"kernel: {name}: expected a function with the decorator @compiled, "
                    f"got {shortened(repr(function))}"
                )

    @cached_property
    def addresses(self) -> tuple[int, int]:
        """Addresses of the compiled act and begin_step; 0 for a function that is None."""
        begin = 0 if self.begin_step is None else address_of(self.begin_step, BEGIN_STEP)
        return address_of(self.act, ACT), begin


# ---------------------------------------------------------------------- for use in kernels
@compiled
def base_stress(stretch: Any, mode: Any) -> Any:
    """Stress of the base model over the shear modulus [-], as in `stages.Strain.elastic_term`."""
    inverse = 1.0 / stretch
    if mode == PURE_SHEAR:
        return stretch - inverse * inverse * inverse
    if mode == UNIAXIAL:
        return stretch - inverse * inverse
    if mode == EQUIBIAXIAL:
        return stretch - (inverse * inverse) ** 2 * inverse
    return stretch - 1.0


@compiled
def invariant(stretch: Any, mode: Any) -> Any:
    """Invariant J1 [-], as in `stages.Strain.invariant`."""
    inverse = 1.0 / stretch
    if mode == PURE_SHEAR:
        return (stretch - inverse) ** 2
    if mode == UNIAXIAL:
        return (stretch - 1.0) ** 2 * (1.0 + 2.0 * inverse)
    if mode == EQUIBIAXIAL:
        return (inverse * inverse - 1.0) ** 2 * (1.0 + 2.0 * stretch * stretch)
    return (stretch - 1.0) ** 2
