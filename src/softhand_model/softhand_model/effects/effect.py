"""What an effect is: a name, the stage in which it acts, and parameters with units and bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

STAGES = ("input", "load", "elastic", "structure", "output", "flow")
EXPERIMENTS = ("free_bending", "blocked_tip", "uniaxial", "valve_pulse", "base_torque")


@dataclass(frozen=True)
class Parameter:
    """One number of an effect: unit ("" for none) and the bounds within which it makes sense."""

    name: str
    unit: str
    low: float
    high: float
    description: str = ""


class Effect:
    """Base class of all effects; a subclass sets the class attributes and the method of its stage.

    Values of the parameters are attributes of the instance. Raises ValueError for a parameter that
    is unknown, missing or out of bounds.
    """

    name: ClassVar[str] = ""
    stage: ClassVar[str] = ""
    experiments: ClassVar[frozenset[str]] = frozenset()
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def __init__(self, **values: float) -> None:
        known = {parameter.name: parameter for parameter in self.parameters}
        for name in values:
            if name not in known:
                raise ValueError(
                    f"effect {self.name}: parameters: expected only {_listed(known)}, got {name}"
                )
        for name, parameter in known.items():
            if name not in values:
                raise ValueError(
                    f"effect {self.name}: parameters: expected {name}, got {_listed(values)}"
                )
            self._check(parameter, values[name])
        self.values = {name: float(value) for name, value in values.items()}

    def __init_subclass__(cls) -> None:
        """Refuse a class that names no stage of the list or an unknown experiment."""
        if cls.name and cls.stage not in STAGES:
            raise ValueError(
                f"effect {cls.name}: stage: expected one of {_listed(STAGES)}, got {cls.stage!r}"
            )
        unknown = cls.experiments - set(EXPERIMENTS)
        if cls.name and unknown:
            raise ValueError(
                f"effect {cls.name}: experiments: expected some of {_listed(EXPERIMENTS)}, "
                f"got {_listed(sorted(unknown))}"
            )

    def _check(self, parameter: Parameter, value: float) -> None:
        number = (
            isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        )
        if not number or not parameter.low <= value <= parameter.high:
            unit = f" {parameter.unit}" if parameter.unit else ""
            raise ValueError(
                f"effect {self.name}: {parameter.name}: expected a number from "
                f"{parameter.low:g} to {parameter.high:g}{unit}, got {value!r}"
            )

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={value:g}" for name, value in self.values.items())
        return f"{type(self).__name__}({shown})"


def _listed(names: Iterable[object]) -> str:
    return ", ".join(str(name) for name in names) or "nothing"
