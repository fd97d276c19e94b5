"""Budget and criteria of the comparison, fixed before any run.

NIGHT is sized for a short night on two cores: 21,200 trials of 0.45 to 0.85 s of processor time
each (idle and loaded, including the construction of hands and scenes) and 360 fine ones of 3 to 6 s
are 3 to 6 core-hours. SMALL, some 500 of them, takes four minutes.

All criteria are evaluated on the held-out trials of the seed at which an arm was run; these are the
same for all arms. Arms are compared by the difference of their shares of success, seed by seed,
with the 95 % interval of Student's t over the seeds. Co-design helps if that interval lies above 0
against *both* single arms; otherwise it has not been shown to help at this budget.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from thesis.co_design.trials import Physics

CONFIDENCE = 0.95
MOST_SHRINKAGE = 15.0  # from training to held-out success [percentage points]
LEAST_RANK = 0.7  # Spearman, of the best designs' scores at the coarse and the fine step
LEAST_RATE = 2000.0  # trials a core-hour
MOST_GAIN = 0.05  # of a negative control over the shipped pair
LEAST_CLAIM = 0.15  # by which the score that noise gives is above the true one


@dataclass(frozen=True)
class World:
    """Distribution of the trials: objects, places per object; largest shift (x, y) [m], turn [rad]
    and relative change of mass; factors on friction and on shear modulus, drawn between both ends
    or the ends themselves.
    """

    objects: tuple[str, ...]
    places: int
    friction: tuple[float, float]
    modulus: tuple[float, float]
    at_ends: bool
    shift: float = 0.020
    yaw: float = 0.17
    mass: float = 0.05

    @property
    def trials(self) -> int:
        """Of a design."""
        return len(self.objects) * self.places


@dataclass(frozen=True)
class Plan:
    """Budget, seeds and worlds.

    Each design of a generation gets `rungs[0]` trials; the best `kept[0]` go on to `rungs[1]`, and
    so on. `control_seeds` are those with shuffled labels. With the `fine` physics, the
    `fine_designs` best of the co-design arm are run on `fine_trials` of their training.
    """

    seeds: tuple[int, ...] = (1, 2, 3, 4, 5)
    control_seeds: tuple[int, ...] = (1, 2, 3)
    generations: int = 10
    generation: int = 12
    rungs: tuple[int, ...] = (2, 8, 40)
    kept: tuple[int, ...] = (3, 1)
    training: World = World(
        ("cylinder", "ball", "thin_cylinder", "tape_dispenser", "tube"),
        places=8,
        friction=(0.85, 1.15),
        modulus=(0.95, 1.05),
        at_ends=False,
    )
    held_out: World = World(
        ("water_bottle", "staple_remover", "rod", "paper_cup", "marker"),
        places=16,
        friction=(0.7, 1.3),
        modulus=(0.85, 1.15),
        at_ends=True,
    )
    fine: Physics = field(default_factory=lambda: Physics(0.002, 10, True))
    fine_designs: int = 10
    fine_trials: int = 20

    def __post_init__(self) -> None:
        if self.rungs[-1] != self.training.trials:
            raise ValueError(f"rungs: expected {self.training.trials} at last, got {self.rungs}")

    @property
    def budget(self) -> int:
        """Trials of a search.

        >>> Plan().budget
        740
        """
        counts = (self.generation, *self.kept)
        added = (high - low for low, high in zip((0, *self.rungs), self.rungs, strict=False))
        return self.generations * sum(n * more for n, more in zip(counts, added, strict=True))


def _small(world: World, places: int) -> World:
    return World(world.objects, places, world.friction, world.modulus, world.at_ends)


NIGHT = Plan()
SMALL = Plan(
    seeds=(1, 2),
    control_seeds=(1,),
    generations=2,
    generation=4,
    rungs=(2, 5),
    kept=(2,),
    training=_small(NIGHT.training, 1),
    held_out=_small(NIGHT.held_out, 2),
    fine_designs=4,
    fine_trials=5,
)
PLANS = {"night": NIGHT, "small": SMALL}
