"""Effects of the catalogue that might be missing in RBO Hand 2, one parameter each, over the range
that the catalogue calls usual.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.effect import Parameter
from softhand_model.effects.hand import HandEffect
from thesis.frame import Array


@dataclass(frozen=True)
class Candidate:
    """A parameter of an effect; where: its place by key, for an effect of one place of the hand."""

    effect: str
    parameter: str
    where: Mapping[str, str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Effect and place, and the parameter where the effect has several.

        >>> Candidate("mount_tilt", "yaw", {"chain": "thumb"}).label
        'mount_tilt[thumb] yaw'
        """
        place = f"[{'>'.join(self.where.values())}]" if self.where else ""
        several = len(effect_classes()[self.effect].parameters) > 1
        return f"{self.effect}{place}" + (f" {self.parameter}" if several else "")

    @property
    def described(self) -> Parameter:
        """The parameter as the catalogue has it."""
        of = effect_classes()[self.effect].parameters
        return next(one for one in of if one.name == self.parameter)

    def usual(self, count: int) -> Array:
        """Values (count,) from end to end of the usual range, evenly, in the logarithm if the
        catalogue says so.
        """
        low, high = self.described.typical
        spaced = np.geomspace if self.described.logarithmic else np.linspace
        return np.asarray(spaced(low, high, count))

    def at(self, value: float) -> Effect:
        """The effect with this value, its other parameters neutral."""
        kind = effect_classes()[self.effect]
        if issubclass(kind, HandEffect):
            kind = kind.at(**self.where)
        values = {one.name: one.neutral for one in kind.parameters if one.neutral is not None}
        return kind(**{**values, self.parameter: value})

    def entry(self, value: float) -> str:
        """The effect as a line of a model file."""
        values = ", ".join(f"{k}: {float(v):.6g}" for k, v in self.at(value).values.items())
        where = ", ".join(f"{key}: {name}" for key, name in self.where.items())
        place = f"where: {{{where}}}, " if where else ""
        return f"  - {{name: {self.effect}, {place}parameters: {{{values}}}}}"


IN_POSE = (
    *(
        Candidate("actuator_scatter", "modulus_factor", {"actuator": name})
        for name in ("palm_inner", "palm_outer", "thumb", "index", "little")
    ),
    Candidate("palm_stiffness", "factor"),
    Candidate("strut_stiffness", "factor"),
    *(
        Candidate("mount_tilt", axis, {"chain": chain})
        for chain in ("palm", "thumb")
        for axis in ("roll", "pitch", "yaw")
    ),
    *(
        Candidate("crosstalk", "share", {"from": one, "to": other})
        for one, other in (("c", "d"), ("d", "c"))
    ),
    Candidate("tip_mass", "mass", {"chain": "thumb"}),
)
IN_GRASP = (
    Candidate("friction", "factor"),
    Candidate("palm_stiffness", "factor"),
    Candidate("actuator_scatter", "modulus_factor", {"actuator": "thumb"}),
    Candidate("strut_stiffness", "factor"),
    Candidate("actuator_scatter", "modulus_factor", {"actuator": "palm_outer"}),
)
