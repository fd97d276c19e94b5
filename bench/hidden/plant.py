"""The truth behind a set: geometry of the specimens and everything that acts, in one record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from bench.hidden import rubber
from bench.hidden.rubber import Loop, Modes, OgdenRoxburgh, Softening

Array = np.ndarray


@dataclass(frozen=True)
class Body:
    """Sections of the specimens in use: arrays (rows, sections), rows are runs or samples.

    x and weights [m] are places along the actuator and what each counts in an integral over it.
    """

    x: Array
    weights: Array
    length: Array
    height: Array
    width: Array
    wall: Array
    side: Array
    modulus: Array
    mass: Array
    uphill: Array  # +1 base above (weight straightens), -1 base below, 0 level

    @property
    def ratio(self) -> Array:
        """Side walls, one factor on the load (3.35)."""
        reach = np.maximum(self.height - self.wall, 0.0)
        more = reach**2 / (self.height * self.width) * (2 * self.side) / (2 * self.wall)
        return 2.0 / (1.0 + more)

    def rows(self, index: Array) -> Body:
        """The body with other rows."""
        return Body(**{name: value[index] for name, value in vars(self).items()})


@dataclass
class Plant:
    """All that acts, empty for the base model.

    gauge: acting supply pressure -> what the pressure sensor shows. chamber: (time, pressure) ->
    pressure in the chamber, both (runs, steps). loads: (s, pressure) -> s. factors: (stretch, body)
    -> factor on the elastic stress. sensors: (time, value, pressure) -> what is shown, on the fine
    grid. `moving`: something needs the fine grid.
    """

    scale: float = 1.0
    mode: str = "planar"
    gauge: list[Callable[[Array], Array]] = field(default_factory=list)
    chamber: list[Callable[[Array, Array], Array]] = field(default_factory=list)
    modulus: list[Callable[[Array], Array]] = field(default_factory=list)
    ageing: list[Callable[[Array], Array]] = field(default_factory=list)  # runs before -> factor
    loads: list[Callable[[Array, Array], Array]] = field(default_factory=list)
    factors: list[Callable[[Array, Body], Array]] = field(default_factory=list)
    softening: Softening | OgdenRoxburgh | None = None
    modes: Modes | None = None
    loop: Loop | None = None
    mass_scale: float = 0.0
    tip_mass: float = 0.0  # [kg]
    mass_tilt: float = 0.0  # 1: mass per length grows from zero at the base to twice the mean
    side_walls: bool = False
    printed: tuple[float, float] | None = None
    set_share: float = 0.0  # of the largest strain so far, which stays in the rubber
    grips: float = 0.0  # stretch by which the grips of a strip yield per stress [1/Pa]
    tip_compliance: Callable[[Array], Array] | None = None  # force [N] -> deflection [m]
    bulges: bool = False  # between base and gauge, where the tip is blocked
    sensors: list[Callable[[Array, Array, Array], Array]] = field(default_factory=list)
    bend_twist: float = 0.0  # these three of the chain whose torque is measured
    slack: float = 1.0
    mixing: list[Array] = field(default_factory=list)
    moving: bool = False
    parts: int = 1  # steps of the grid a sample

    @property
    def remembers(self) -> bool:
        """Whether the rubber's stress depends on its past within a run (softening apart)."""
        return self.modes is not None or self.loop is not None

    def aged(self, body: Body, before: Array) -> Body:
        """The body of specimens that have had so many runs (rows,) before."""
        factor = np.ones(len(before))
        for change in self.ageing:
            factor = factor * change(before)
        return replace(body, modulus=body.modulus * factor[:, None])

    def elastic(self, stretch: Array, body: Body) -> Array:
        """Q: the elastic stress over G with its factors."""
        stress = rubber.neo_hooke(stretch, self.mode)
        for factor in self.factors:
            stress = stress * factor(stretch, body)
        return stress if self.softening is None else stress * self.softening.factor(stretch)

    def load(self, pressure: Array, temperature: Array, body: Body) -> Array:
        """s: what the balance is loaded with, (rows, sections)."""
        s = pressure * body.ratio * body.height / (4 * body.modulus * self.scale * body.wall)
        for change in self.modulus:
            s = s / change(temperature)
        for change in self.loads:
            s = change(s, pressure)
        return s * (2.0 / body.ratio if self.side_walls else 1.0)

    def side_stress(self, stretch: Array, body: Body) -> Array | float:
        """What the side walls add to the stress when they are integrated."""
        if not self.side_walls:
            return 0.0
        return rubber.side_wall_stress(stretch, body.height, body.width, body.wall, body.side)

    def moment_unit(self, temperature: Array, body: Body) -> Array:
        """m of a moment of 1 N m, (rows, sections)."""
        modulus = body.modulus * self.scale
        for change in self.modulus:
            modulus = modulus * change(temperature)
        unit = body.ratio / (2 * modulus * body.height * body.wall * body.width)
        return unit * (2.0 / body.ratio if self.side_walls else 1.0)
