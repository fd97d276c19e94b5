"""What is hidden in a hand, and in which terms: never by the lab's classes of effects.

The plan, its seeds and its criteria were fixed before anything was run. Strong and weak effects of
each kind at places drawn by the seed, hands without anything, and three things outside of the
catalogue of hands.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from softhand_common.numerics.arrays import Array
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import ChainDescription, HandDescription
from softhand_model.model_file import Model

SEED = 3300  # of the first case; the others follow
SIZES = {  # (strong, weak)
    "actuator_scatter": (0.72, 0.90),  # modulus over the nominal one, or one over that
    "mount_tilt": (0.10, 0.04),  # [rad] about an axis that is drawn
    "crosstalk": (0.20, 0.06),  # share of the pressure
}
PLAN = [
    *[(kind, strength) for kind in SIZES for strength in ["strong"] * 3 + ["weak"] * 3],
    *[("nothing", "")] * 4,
    *[(name, "outside") for name in ("soft_struts", "stiffening", "dead_zone")],
]
SOFT_STRUTS, STIFFENING, DEAD_ZONE = 0.35, 0.12, 4e3  # factor; Yeoh's c2; [Pa]


def _same(pressures: Array) -> Array:
    return pressures


@dataclass(frozen=True)
class Hidden:
    """A hand with something hidden: its description, model, what pressures (channels,) [Pa] act in
    place of those that are read, and the truth as a verdict would have it.
    """

    hand: HandDescription
    name: str
    strength: str
    where: dict[str, str] = field(default_factory=dict)
    effects: tuple[Any, ...] = ()
    acting: Callable[[Array], Array] = _same

    @property
    def model(self) -> Model:
        """The model of the simulated hand, with its weight."""
        return Model(effects=(effect_classes()["gravity"](mass_scale=1.0), *self.effects))


def hidden_in(
    hand: HandDescription, kind: str, strength: str, random: np.random.Generator
) -> Hidden:
    """A case of the plan."""
    size = SIZES[kind][strength == "weak"] if kind in SIZES else 0.0
    plain = Hidden(hand, kind, strength)
    if kind == "actuator_scatter":
        name = str(random.choice(hand.actuator_names))
        factor = float(size if random.uniform() < 0.5 else 1.0 / size)
        return replace(plain, hand=_softened(hand, name, factor), where={"actuator": name})
    if kind == "mount_tilt":
        name = str(random.choice([chain.name for chain in hand.chains]))
        way = random.standard_normal(3)
        turn = size * way / np.linalg.norm(way)
        return replace(plain, hand=_turned(hand, name, turn), where={"chain": name})
    if kind == "crosstalk":
        pairs = list(permutations(range(len(hand.channels)), 2))
        source, target = pairs[random.integers(len(pairs))]

        def leaking(pressures: Array) -> Array:
            more = pressures.copy()
            more[target] += size * pressures[source]
            return more

        names = hand.channels
        return replace(plain, where={"from": names[source], "to": names[target]}, acting=leaking)
    if kind == "soft_struts":
        return replace(plain, hand=_each(hand, _with_soft_strut))
    if kind == "stiffening":
        return replace(plain, effects=(effect_classes()["yeoh_stiffening"](c2=STIFFENING),))
    if kind == "dead_zone":
        return replace(plain, acting=lambda pressures: np.maximum(pressures - DEAD_ZONE, 0.0))
    return plain


def _each(
    hand: HandDescription, change: Callable[[ChainDescription], ChainDescription]
) -> HandDescription:
    return replace(hand, chains=tuple(change(chain) for chain in hand.chains))


def _softened(hand: HandDescription, actuator: str, factor: float) -> HandDescription:
    def change(chain: ChainDescription) -> ChainDescription:
        parts = {
            name: part.with_modulus(factor) if name == actuator else part
            for name, part in chain.actuators.items()
        }
        return replace(chain, actuators=parts)

    return _each(hand, change)


def _turned(hand: HandDescription, name: str, turn: Array) -> HandDescription:
    def change(chain: ChainDescription) -> ChainDescription:
        if chain.name != name:
            return chain
        mount = Rotation.from_euler("xyz", chain.mount.rpy) * Rotation.from_rotvec(turn)
        return replace(chain, mount=replace(chain.mount, rpy=tuple(mount.as_euler("xyz").tolist())))

    return _each(hand, change)


def _with_soft_strut(chain: ChainDescription) -> ChainDescription:
    if chain.strut is None:
        return chain
    soft = replace(chain.strut, modulus=SOFT_STRUTS * chain.strut.modulus)
    return replace(chain, strut=soft)
