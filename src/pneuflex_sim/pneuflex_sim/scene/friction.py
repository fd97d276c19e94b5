"""Friction of pairs of materials, and the coefficients that reproduce it in PyBullet.

PyBullet multiplies the coefficients of the two bodies in contact, so a general table of pairs
cannot be expressed by one number per material. The pairs of a hand, an object and fixed bodies can:
rubber gets the square root of its coefficient with itself, the object its coefficient with rubber
divided by that, and a fixed body one coefficient towards the hand and another towards the object
(see `scenes`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from pneuflex_sim.bullet import pybullet
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import Bounds, Node, read_document

FORMAT = "pneuflex-friction/1"
RUBBER_MATERIAL = "rubber"
MIN_FRICTION = 1e-3  # less than any pair of dry materials has
MAX_FRICTION = 10.0  # PyBullet cuts off above
RUBBER_RANGE_BOUNDS = Bounds(0.1, 10.0, "")


@dataclass(frozen=True)
class FrictionTable:
    """Coefficients of friction [-] between materials.

    pairs: the coefficient by the set of the two names; a single name stands for a material on
    itself. source: the files that state them. rubber_range: the smallest and the largest factor [-]
    by which the coefficients of rubber can be multiplied and stay within published values.
    """

    pairs: Mapping[frozenset[str], float]
    source: str = "the table of friction"
    rubber_range: tuple[float, float] = (1.0, 1.0)

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of all materials, sorted."""
        return tuple(sorted({name for pair in self.pairs for name in pair}))

    def pair(self, first: str, second: str) -> float:
        """Coefficient [-] of two materials, in either order; raises ValueError when the table has
        no such pair.
        """
        found = self.pairs.get(frozenset((first, second)))
        if found is None:
            raise ValueError(
                f"friction: expected a coefficient of {first} on {second} in {self.source}, got "
                f"none; its materials are {listed(self.materials)}"
            )
        return found

    def check_material(self, node: Node) -> None:
        """Raise DocumentError for a material that is not in the table."""
        if node.text() not in self.materials:
            raise node.error(f"one of {listed(self.materials)} (of {self.source})")

    def rubber_scaled(self, factor: float) -> FrictionTable:
        """The table with all pairs of rubber with something else times a factor [-]."""
        pairs = {
            pair: value * (factor if RUBBER_MATERIAL in pair and len(pair) == 2 else 1.0)
            for pair, value in self.pairs.items()
        }
        return replace(self, pairs=pairs)

    @property
    def hand(self) -> float:
        """PyBullet's coefficient of the hand; its square is that of rubber on rubber."""
        return math.sqrt(self.pair(RUBBER_MATERIAL, RUBBER_MATERIAL))

    def towards_hand(self, material: str) -> float:
        """PyBullet's coefficient of anything that the hand touches: of the object, or of a fixed
        body towards the hand.
        """
        return self.pair(material, RUBBER_MATERIAL) / self.hand

    def towards_object(self, material: str, of_object: str) -> float:
        """PyBullet's coefficient of a fixed body of a `material` towards an object of the material
        `of_object`.
        """
        return self.pair(material, of_object) / self.towards_hand(of_object)


class BodyFriction:
    """Coefficients of all present bodies of a PyBullet client, to scale all pairs together."""

    def __init__(self, client: int) -> None:
        self._client, self._factor = client, 1.0
        self._coefficients = [
            (body, link, *self._coefficients_of(body, link))
            for body in map(self._body, range(pybullet.getNumBodies(physicsClientId=client)))
            for link in range(-1, pybullet.getNumJoints(body, physicsClientId=client))
        ]

    def _body(self, index: int) -> int:
        return int(pybullet.getBodyUniqueId(index, physicsClientId=self._client))

    def _coefficients_of(self, body: int, link: int) -> tuple[float, float, float]:
        found = pybullet.getDynamicsInfo(body, link, physicsClientId=self._client)
        return found[1], found[6], found[7]

    def scale(self, factor: float) -> None:
        """Scale the sliding and twisting friction of every pair to `factor` times the initial one.
        Rolling resistance, which PyBullet multiplies with sliding friction, is kept.
        """
        if factor == self._factor:
            return
        self._factor, root = factor, math.sqrt(factor)
        for body, link, sliding, rolling, twisting in self._coefficients:
            pybullet.changeDynamics(
                body,
                link,
                lateralFriction=root * sliding,
                rollingFriction=rolling / root,
                spinningFriction=root * twisting,
                physicsClientId=self._client,
            )


def load_friction(path: str | Path | None = None) -> FrictionTable:
    """The shipped table. The pairs of a user's file at `path` replace shipped pairs or are added;
    None: no such file.

    Raises ValueError naming file, key, expected and got.

    >>> load_friction().pair("cardboard", "wood") == load_friction().pair("wood", "cardboard")
    True
    """
    file = Path(str(resources.files("pneuflex_sim").joinpath("data/friction.yaml")))
    shipped = _read(file)
    if path is None:
        return shipped
    own = _read(Path(path)).pairs
    return replace(shipped, pairs={**shipped.pairs, **own}, source=f"{file} and {path}")


def _read(path: Path) -> FrictionTable:
    fields = read_document(path, FORMAT).fields(["format", "pairs"], ["rubber_range"])
    pairs: dict[frozenset[str], float] = {}
    for first, row in fields["pairs"].mapping().items():
        for second, value in row.mapping().items():
            _add(pairs, frozenset((first, second)), value)
    if "rubber_range" not in fields:
        return FrictionTable(pairs, str(path))
    low, high = fields["rubber_range"].vector(2, RUBBER_RANGE_BOUNDS)
    return FrictionTable(pairs, str(path), (low, high))


def _add(pairs: dict[frozenset[str], float], pair: frozenset[str], value: Node) -> None:
    if pair in pairs:
        raise value.error("every pair once", "it twice")
    pairs[pair] = value.number(high=MAX_FRICTION, low=MIN_FRICTION)
