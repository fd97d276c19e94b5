"""What an effect is: a name, the stage in which it acts, and parameters with units and bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.quoted import quoted, shortened
from softhand_common.numerics.arrays import Array
from softhand_model.effects.kernel import Kernel

STAGES = ("hand", "input", "load", "elastic", "structure", "output", "flow")
BASES = ("pneuflex", "linear")
EXPERIMENTS = (
    "free_bending",
    "blocked_tip",
    "uniaxial",
    "rubber",
    "valve_pulse",
    "base_torque",
    "hand_pose",
    "hand_motion",
    "press",
    "grasp",
)

OUTPUT_UNIT = "[y]"  # of parameters in the unit of whatever output is measured
BENDING = frozenset({"free_bending", "blocked_tip", "base_torque"})
STRETCHED = frozenset({"uniaxial", "rubber"})  # the stretch of a sample is imposed
RUBBER = BENDING | STRETCHED  # wherever the rubber is strained
POSED = frozenset({"hand_pose"})  # a hand at rest: effects that need neither time nor runs before
AXES = (
    *("pressure", "session", "run_order", "temperature"),
    *("wall", "mount", "specimen"),
)  # of an effect; session: runs before, of any specimen


def unseen_when_stretched(reason: str) -> dict[str, str]:
    """The reason why an effect does not show in tests of the rubber alone, by the name of each of
    these tests.
    """
    return dict.fromkeys(sorted(STRETCHED), reason)


NO_PRESSURE: Mapping[str, str] = unseen_when_stretched("the stretch is imposed: no pressure acts")

OF_KERNEL = ("stress", "remember", "wall_stress")  # methods whose work a kernel does


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    unit: "" for none. low, high: bounds within which the number makes sense. typical: range (low,
    high) in which it usually lies, where a search starts; None: the bounds. logarithmic: whether it
    spans decades. neutral: value at which the effect does nothing; None if there is none. relative:
    (`pressure` or `output`, low, high), the usual range divided by the largest measured pressure or
    output of a set, in which the lab then searches.

    Raises ValueError for bounds, a usual range or a neutral value that make no sense.
    """

    name: str
    unit: str
    low: float
    high: float
    description: str = ""
    typical: tuple[float, float] | None = None
    logarithmic: bool = False
    neutral: float | None = None
    relative: tuple[str, float, float] | None = None

    def __post_init__(self) -> None:
        """Refuse what no search could use."""
        bounds = f"{self.low!r} to {self.high!r}"
        if not (_is_number(self.low) and _is_number(self.high) and self.low < self.high):
            raise ValueError(f"parameter {self.name}: expected two numbers as bounds, got {bounds}")
        if self.logarithmic and self.low <= 0.0:
            raise ValueError(
                f"parameter {self.name}: expected bounds above 0, as it is logarithmic, "
                f"got {bounds}"
            )
        for key, value in self._within():
            if not _is_number(value) or not self.low <= value <= self.high:
                raise ValueError(
                    f"parameter {self.name}: {key}: expected numbers within its bounds, {bounds}, "
                    f"got {value!r}"
                )

    def usual(self, share: float = 0.5) -> float:
        """The value at a share [-] of the usual range, on a logarithmic scale if the parameter
        spans decades.

        >>> Parameter("x", "", 1.0, 1e4, typical=(1.0, 100.0), logarithmic=True).usual()
        10.0
        """
        low, high = self.typical or (self.low, self.high)
        if self.logarithmic:
            return float(low ** (1.0 - share) * high**share)
        return float((1.0 - share) * low + share * high)

    def _within(self) -> list[tuple[str, float]]:
        """What has to lie within the bounds, by name."""
        typical = [("typical", value) for value in self.typical or ()]
        return typical + ([] if self.neutral is None else [("neutral", self.neutral)])


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


class Effect:
    """Base class of all effects. A subclass sets the class attributes below and defines the method
    of its `stage`: the part of the model in which it acts, one of STAGES (`effects.stages` has a
    base class for each).

    `values` of an instance maps names of parameters to numbers. In the lab they map to arrays
    (lanes, 1, 1) with many values of the parameter at once, one in each lane (`in_lanes`);
    therefore methods calculate with numpy. Raises ValueError for a parameter that is unknown,
    missing or out of bounds.

    experiments: names of the experiments in which the effect can be seen, of EXPERIMENTS.
    unseen_in: maps names of other experiments to the reason why they do not show the effect.

    confounded_with: maps names of effects (or of calibrations) that look nearly like this one to
    what is alike. stands_for: names of effects for which this one may be taken if they follow other
    equations than those here.

    has_memory: whether the effect depends on earlier inputs, and so needs `time`. endless: whether
    its memory fades with the logarithm of time and so has no longest time constant; then samples
    far apart show it, too.

    rank: within a stage, effects of lower rank act first, whatever the order in the model file.

    bases: names of the base models, of BASES, to which the effect can be added.

    physical: False for a term without physical meaning, which the lab adds on request but never
    names as a cause.

    axes: properties of a run on which the effect depends besides the arguments of its methods, of
    AXES, such as its temperature. While `chamber_pressure`, `modulus_factor` or `reading` is
    called, `around` maps each of these names to an array (1, rows, 1) of its values (or names),
    where a row is a run or a sample. The simulator, which has no runs, may leave them out.

    refines: names of simpler effects of which this one is a finer form. The lab adds it on request.
    In tests of the rubber alone (`uniaxial`, `rubber`) it searches the effect if the simpler ones
    leave too much error, and else ties it with one that it refines, if it explains as much.

    beside: names of effects of which the model must have one before the lab searches this one; ()
    for an effect that needs none.

    fewest_runs: least number of runs in a measurement set with which the effect can be told from
    one that changes the input over time.

    not_simulated: why the simulator refuses the effect; "" if it simulates the effect.

    kernel: compiled form of the methods `stress`, `remember` or `wall_stress`, which makes the lab
    fast. A subclass that overrides one of them needs a kernel of its own (`matching_kernel`).

    origin: file and class of an effect that a user has written, for messages; "" for a built-in
    one.

    cause, member: the class of causes to which the effect belongs, such as "lag", and its name in
    that class, such as "tube". Effects of one class often explain a set equally well, and the lab
    then names the class. "" for an effect that is a class of its own.
    """

    name: ClassVar[str] = ""
    stage: ClassVar[str] = ""
    experiments: ClassVar[frozenset[str]] = frozenset()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    unseen_in: ClassVar[Mapping[str, str]] = {}
    confounded_with: ClassVar[Mapping[str, str]] = {}
    has_memory: ClassVar[bool] = False
    stands_for: ClassVar[tuple[str, ...]] = ()
    endless: ClassVar[bool] = False
    rank: ClassVar[int] = 0
    bases: ClassVar[frozenset[str]] = frozenset(BASES)
    physical: ClassVar[bool] = True
    axes: ClassVar[tuple[str, ...]] = ()
    refines: ClassVar[tuple[str, ...]] = ()
    beside: ClassVar[tuple[str, ...]] = ()
    fewest_runs: ClassVar[int] = 1
    not_simulated: ClassVar[str] = ""
    kernel: ClassVar[Kernel | None] = None
    origin: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    member: ClassVar[str] = ""

    around: Mapping[str, Any] = MappingProxyType({})
    values: Mapping[str, Any]

    def __init__(self, /, **values: float) -> None:
        known = {parameter.name: parameter for parameter in self.parameters}
        for name in values:
            if name not in known:
                raise ValueError(
                    f"effect {self.name}: parameters: expected only {_listed(known)}, "
                    f"got {shortened(name)}"
                )
        for name, parameter in known.items():
            if name not in values:
                raise ValueError(
                    f"effect {self.name}: parameters: expected {name}, got {_listed(values)}"
                )
            self._check(parameter, values[name])
        self.values = {name: float(values[name]) for name in known}  # in the order of parameters

    @classmethod
    def in_lanes(cls, values: Mapping[str, ArrayLike]) -> Self:
        """The effect with many trial values (lanes,) of each parameter at once; bounds are not
        checked.
        """
        effect = cls.__new__(cls)
        effect.values = {
            parameter.name: np.asarray(values[parameter.name], float).reshape(-1, 1, 1)
            for parameter in cls.parameters
            if parameter.name in values
        }
        return effect

    @property
    def matching_kernel(self) -> Kernel | None:
        """The kernel; None without one, or if a subclass without a kernel of its own overrides a
        method that the kernel replaces.
        """
        for owner in type(self).__mro__:
            if "kernel" in vars(owner):
                return self.kernel
            if any(method in vars(owner) for method in OF_KERNEL):
                return None
        return None

    def kernel_values(self) -> list[Array]:
        """Rows of values for the kernel, arrays (lanes or 1,): by default the parameters in their
        order.
        """
        return [np.ravel(np.asarray(value, float)) for value in self.values.values()]

    def __init_subclass__(cls) -> None:
        """Refuse a class that names no stage of the list or an unknown experiment."""
        if cls.name and cls.stage not in STAGES:
            raise ValueError(
                f"effect {cls.name}: stage: expected one of {_listed(STAGES)}, got {cls.stage!r}"
            )
        unread = set(cls.axes) - set(AXES)
        if cls.name and unread:
            raise ValueError(
                f"effect {cls.name}: axes: expected some of {_listed(AXES)}, "
                f"got {_listed(sorted(unread))}"
            )
        unknown = set(cls.experiments) - set(EXPERIMENTS)
        if cls.name and unknown:
            raise ValueError(
                f"effect {cls.name}: experiments: expected some of {_listed(EXPERIMENTS)}, "
                f"got {_listed(sorted(unknown))}"
            )

    def _check(self, parameter: Parameter, value: float) -> None:
        if not _is_number(value) or not parameter.low <= value <= parameter.high:
            unit = f" {parameter.unit}" if parameter.unit else ""
            raise ValueError(
                f"effect {self.name}: {parameter.name}: expected a number from "
                f"{parameter.low:g} to {parameter.high:g}{unit}, got {quoted(value)}"
            )

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={value:g}" for name, value in self.values.items())
        return f"{type(self).__name__}({shown})"


def _listed(names: Iterable[object]) -> str:
    return ", ".join(str(name) for name in names) or "nothing"
