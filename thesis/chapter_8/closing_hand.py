"""A hand of softer or stiffer rubber that closes around an object with a force, and holds it.

The palm looks down. A spring holds the object out between palm and fingers while the hand closes,
then lets go, so that the hand alone carries it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.pose import Pose
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.usual_step import USUAL_STEP
from thesis.chapter_3_and_5.stand import fill
from thesis.frame import Array

PALM_DOWN = (0.0, np.pi / 2.0, 0.0)  # of the wrist: roll, pitch, yaw [rad]
RISE = 1.5  # in which the air rises to the usual pressures [s]
CLOSING = 3.0  # until the object is let go [s]
FADING, HOLDING = 0.5, 1.0  # of the spring, and of the hold after it [s]
MOST_AIR = 2.0  # times the pressures that bend a free hand as the usual ones do
LOOK_EVERY, SMOOTHING = 5, 0.2  # steps between two looks at the force; weight of the latest
SHIFT, TURN = 0.004, np.radians(5.0)  # largest, in and about each axis [m], [rad]
MASS_SHARE, FRICTION_SHARE = 0.05, 0.15  # largest changes of both
LOST_WAY = 0.05  # of the object in the wrist's frame, from where it was let go [m]


@dataclass(frozen=True)
class Closing:
    """How a hand closes: its name and model, usual gauge pressures [Pa] of its channels, and where
    the side of the object that faces the palm is in the wrist frame (3,) [m].
    """

    hand: str
    model: str | None
    pressures: tuple[float, ...]
    place: tuple[float, float, float]


@dataclass(frozen=True)
class Draw:
    """What differs between trials: shift (3,) [m] and turn (3,) [rad] of the object, factors [-] on
    its mass and on all friction.
    """

    shift: Array
    turn: Array
    mass_scale: float
    friction_scale: float

    @classmethod
    def of(cls, *seed: int) -> Draw:
        """The draw of a seed, uniform."""
        rng = np.random.default_rng(seed)
        shift, turn = SHIFT * rng.uniform(-1, 1, 3), TURN * rng.uniform(-1, 1, 3)
        mass, friction = rng.uniform(-1, 1, 2)
        return cls(shift, turn, 1.0 + MASS_SHARE * mass, 1.0 + FRICTION_SHARE * friction)


@dataclass(frozen=True)
class Held:
    """How a hand held an object.

    Attributes:
        force: sum of its normal forces on the object when it was let go [N].
        air: pressures over those that bend the free hand as the usual ones do [-].
        yielding: root of the mean square by which joints are bent less or more than by their air
            alone [rad].
        way: of the object in the wrist's frame after it was let go [m].
        points, links, parts, area [m2], redundancy, margin: `Adaptability` at the end of the hold.
    """

    force: float
    air: float
    yielding: float
    way: float
    points: int
    links: int
    parts: int
    area: float
    redundancy: int
    margin: float

    @property
    def lost(self) -> bool:
        """Whether the object has left the hand."""
        return self.points == 0 or self.way > LOST_WAY


def stiffened(name: str, factor: float) -> HandDescription:
    """A hand whose pressure limits are a factor [-] of its own: those of so much stiffer rubber."""
    hand = load_hand(name)
    return replace(
        hand,
        chains=tuple(
            replace(
                chain,
                actuators={
                    key: replace(actuator, max_pressure=factor * actuator.max_pressure)
                    for key, actuator in chain.actuators.items()
                },
            )
            for chain in hand.chains
        ),
    )


def laid(half_sizes: Array) -> Rotation:
    """Orientation in the wrist frame of an object of half sizes (3,) [m]: its longest axis across
    the fingers, its shortest towards the palm.

    >>> turned = laid(np.array([0.05, 0.02, 0.03]))
    >>> np.abs(turned.apply(np.diag([0.05, 0.02, 0.03]))).max(axis=0).round(3).tolist()
    [0.02, 0.05, 0.03]
    """
    short, middle, long = np.argsort(half_sizes, kind="stable")
    matrix = np.zeros((3, 3))
    matrix[[0, 2, 1], [short, middle, long]] = 1.0
    matrix[2] *= np.linalg.det(matrix)
    return Rotation.from_matrix(matrix)


class ClosingHand:
    """One hold.

    Args:
        closing: how the hand closes.
        object: its name; none that is a sheet.
        draw: what differs from other trials.
        stiffness: factor on the shear modulus of the rubber, and so on the pressures that bend the
            free hand alike [-].
        segments: an actuator.
    """

    def __init__(
        self, closing: Closing, object: str, draw: Draw, stiffness: float, segments: int
    ) -> None:
        self._pressures = stiffness * np.array(closing.pressures)
        self.simulation = Simulation(
            SimulationConfig(
                engine=PYBULLET,
                hand=stiffened(closing.hand, stiffness),
                model=closing.model,
                object=object,
                scene=replace(load_scene("held"), wrist_rpy=PALM_DOWN),
                step=USUAL_STEP,
                segments=segments,
                modulus_scale=stiffness,
                object_mass_scale=draw.mass_scale,
                friction_scale=draw.friction_scale,
            )
        )
        half_sizes = load_object(object).half_sizes
        place = np.array(closing.place) + [half_sizes.min(), 0.0, 0.0] + draw.shift
        turn = Rotation.from_rotvec(draw.turn) * laid(half_sizes)
        self.simulation.hold_object(place, turn.as_quat())
        self._air = self._force = 0.0

    def hold(self, force: float | None = None) -> Held:
        """Close, let the object go, and hold it.

        Args:
            force: to close with [N]: the air rises while the hand presses on the object with less,
                and falls while with more; None: to the usual pressures, whatever the force.

        Raises:
            Diverged: the simulation has.
        """
        simulation = self.simulation
        for number in range(1, round(CLOSING / USUAL_STEP) + 1):
            wanted = 1.0 if force is None else float(np.clip(1.0 - self._force / force, -1.0, 1.0))
            most = 1.0 if force is None else MOST_AIR
            self._air = float(np.clip(self._air + USUAL_STEP / RISE * wanted, 0.0, most))
            self._step()
            if number % LOOK_EVERY == 0:
                pressing = sum(contact.force for contact in simulation.object_contacts())
                self._force += SMOOTHING * (pressing - self._force)
        reached, start = self._force, self._in_wrist()
        simulation.release_object(FADING)
        for _ in range(round((FADING + HOLDING) / USUAL_STEP)):
            self._step()
        found = InProcessScene(simulation).adaptability()
        way = float(np.linalg.norm(self._in_wrist() - start))
        return Held(reached, self._air, self._yielding(), way, **asdict(found))

    def close(self) -> None:
        """Free the simulation."""
        self.simulation.close()

    def _step(self) -> None:
        fill(self.simulation, self._air * self._pressures)
        self.simulation.step()

    def _in_wrist(self) -> Array:
        return Pose(*self.simulation.wrist_pose()).locate(self.simulation.object_pose()[0])

    def _yielding(self) -> float:
        simulation, rotations = self.simulation, self.simulation.bodies.rotations
        free = simulation.air.rest_bend(
            USUAL_STEP, simulation.pressures(), rotations, simulation.temperature
        )
        return float(np.sqrt(np.mean(np.sum((rotations - free) ** 2, axis=1))))
