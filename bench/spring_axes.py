"""Stiffness of an actuator about its three axes: what each spring takes, and what it leaves out.

`python -m bench.spring_axes` prints the table of docs/understand/simulator-springs.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bench.command_line import command_line
from softhand_model.chain.segments import cut_chain
from softhand_model.hand import joint_stiffness as side_stiffness
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import ChainDescription, load_hand
from softhand_model.hand.joint_stiffness import SpringModel, rubber_stress

FINE = 1000  # segments, so many that one of them stands for a place
MESH = 2.5e9 * np.pi / 4.0 * 70e-6**2 * 140 / 25.4e-3  # [N/m]: E of PET (Table 3.1) times
# the threads along the actuator, 70 um thick, 140 to the inch (3.3.2)
BENT = 1.35  # stretch of the top of a P10 bent evenly by 90 deg


@dataclass(frozen=True)
class Place:
    """A place along a chain, as a share of its length [-]."""

    name: str
    chain: ChainDescription
    share: float = 0.0
    segments: int = 10

    def stiffness(self, springs: SpringModel) -> np.ndarray:
        """Stiffness (3,) [N m2] sideways, in bending when straight, and in twist."""
        chain = cut_chain(self.chain, self.segments, springs)
        index = round(self.share * self.segments)
        gain = 2.0 if springs.bending == "curvature" else 1.0  # 3.24 over the rule
        edge = self.actuator.length / self.segments
        return chain.stiffness[index] * edge * [1.0, gain, 1.0]

    @property
    def actuator(self) -> Actuator:
        """The actuator, or one of a pair."""
        return next(iter(self.chain.actuators.values()))

    @property
    def walls(self) -> tuple[float, float, float, float]:
        """Height, width, wall and side wall [m]."""
        height, width, wall, side_wall = self.actuator.sides(self.share * self.actuator.length)
        return float(height), float(width), float(wall), float(side_wall)


def places() -> list[Place]:
    """The columns of the table."""
    finger = load_hand("single_finger").chain("finger")
    pair = replace(load_hand("rbo_hand_1").chain("middle"), web=None)
    name, one = next(iter(pair.actuators.items()))
    alone = replace(pair, actuators={name: one}, pitch=0.0)
    return [
        Place("P10 base", finger, 0.0, FINE),
        Place("P10, 95 %", finger, 0.95, FINE),
        Place("P5", alone),
        Place("pair of P5", pair),
    ]


def table() -> list[tuple[str, str, list[float]]]:
    """Rows: what, source, stiffness [mN m2] or quotient [-] at every place."""
    found = [_column(place) for place in places()]
    sources = {
        "bending without side walls": "3.26",
        "`bending: rule`": "3.26 times 2/ratio of 3.35",
        "`bending: curvature`, straight": "3.24 with c/4, times 2/ratio",
        "the same, top stretched by 1.35": "3.24 with c/4, times 2/ratio",
        "`lateral: section` with `rule`": "2 G I",
        "`lateral: section` with `curvature`": "4 G I",
        "`twist: section`": "G J (Bredt)",
        "`rule` over `lateral: section`": "",
        "the same, side walls integrated exactly": "integral of 3.27 in place of 3.35",
        "`rule` over `twist: section`": "",
        "left out: taut mesh, sideways": "E t z³/12 (Steiner for the pair)",
        "mesh taut at one edge, with `rule`": "2 G I about that edge",
        "left out: mesh that joins three fingers, each": "2 G A y²",
    }
    return [(what, source, [column[what] for column in found]) for what, source in sources.items()]


def _column(place: Place) -> dict[str, float]:
    rule, rubber = (
        1e3 * place.stiffness(SpringModel(bending, "section", "section"))
        for bending in ("rule", "curvature")
    )
    walls = 2.0 / float(section.side_wall_ratio(*place.walls))
    integrated = 1.0 + float(section.side_wall_share(*place.walls))
    width, count, offset = place.walls[1], len(place.chain.actuators), place.chain.pitch / 2.0
    tension = 1e3 * _tension(place)
    return {
        "bending without side walls": rule[1] / walls,
        "`bending: rule`": rule[1],
        "`bending: curvature`, straight": rubber[1],
        "the same, top stretched by 1.35": rule[1] * float(rubber_stress(np.array(BENT))[1]) / 2.0,
        "`lateral: section` with `rule`": rule[0],
        "`lateral: section` with `curvature`": rubber[0],
        "`twist: section`": rule[2],
        "`rule` over `lateral: section`": rule[1] / rule[0],
        "the same, side walls integrated exactly": rule[1] / walls * integrated / rule[0],
        "`rule` over `twist: section`": rule[1] / rule[2],
        "left out: taut mesh, sideways": 1e3 * count * MESH * width * (width**2 / 12 + offset**2),
        "mesh taut at one edge, with `rule`": rule[0] + tension * (width / 2.0 + offset) ** 2,
        "left out: mesh that joins three fingers, each": 1e3 * _joined(place),
    }


def _joined(place: Place) -> float:
    """What a finger of RBO Hand 1 has sideways [N m2] on average, by the modulus of the rule, if
    its sections stay in one plane with those of the others; nan for any other.
    """
    hand = load_hand("rbo_hand_1")
    if not place.chain.pitch:
        return np.nan
    offset = np.array([chain.mount.position[1] for chain in hand.chains])
    return _tension(place) * float(np.var(offset))


def _tension(place: Place) -> float:
    """Force over strain [N] of all walls along the chain, by the modulus of the rule."""
    area = len(place.chain.actuators) * float(side_stiffness.wall_area(*place.walls))
    return 2.0 * place.actuator.shear_modulus * area


def _shown(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.3g}"


def markdown() -> str:
    """The table in Markdown."""
    names = [place.name for place in places()]
    lines = [["stiffness [mN m²], quotient [-]", "source", *names], ["---"] * (2 + len(names))]
    for what, source, values in table():
        lines.append([what, source, *map(_shown, values)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    command_line("bench.spring_axes", __doc__).parse_args()
    print(markdown())
