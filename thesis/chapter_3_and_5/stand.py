"""A simulated finger on a test stand: pressures held, the tip blocked or moved."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.hand.collision import BOXES, ENVIRONMENT_GROUP
from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.scenes import SceneDescription, load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.chain.segments import SegmentChain
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.hand.joint_stiffness import THESIS, SpringModel
from softhand_model.model_file import Model
from thesis.frame import Array

FINGER = "finger"
STEP = 0.001  # [s]
RAMP = 0.3  # [s] in which a pressure is reached
STILL = 1e-4  # [rad/s] of a finger at rest; a tip held by friction trembles by 6e-5
CALM = 20  # steps that a finger at rest is still
LONGEST = 30.0  # [s] that a finger may take to come to rest
BLOCK = (0.02, 0.1, 0.05)  # half extents [m]
SIDEWAYS_ONLY = (1.0, 1.0, 0.0)  # shares of the friction along x, y, z
# A wrist that carries a force sensor: a thousand newtons move it by a micrometre.
SENSOR = WristParameters(1e9, 1e7, 1e6, 1e5, 1e3, 10.0)


def hand_of(actuator: Actuator) -> HandDescription:
    """The hand `single_finger` with another actuator."""
    hand = load_hand("single_finger")
    return replace(hand, chains=(replace(hand.chain(FINGER), actuators={FINGER: actuator}),))


def fill(simulation: Simulation, pressures: Array | float) -> None:
    """Give the chambers the air that corresponds to gauge pressures [Pa] in their present shape."""
    pressures_abs = pressures + simulation.ambient
    temperature, rotations = simulation.temperature, simulation.bodies.rotations
    masses = simulation.air.masses(pressures_abs, simulation.ambient, temperature, rotations)
    simulation.set_air_masses(masses)


@dataclass(frozen=True)
class Touch:
    """Normal force [N] on a block and the place (2,) [m], x and z, of its centre."""

    force: float
    place: Array


class FingerStand:
    """A weightless finger on a fixed base, in the frame of the base: z along it, bending towards
    +x.

    Args:
        with_sensor: put the base on a stiff wrist that measures its load, see `base_torque`.
        collision: shapes of the links. Boxes end where the chain does, so the contact is at the
            tip; the simulator's hulls are rounded there.
        springs: of the joints (`joint_stiffness`).
    """

    def __init__(
        self,
        actuator: Actuator,
        segments: int,
        with_sensor: bool = False,
        collision: str = BOXES,
        springs: SpringModel = THESIS,
    ) -> None:
        self.simulation = Simulation(
            SimulationConfig(
                engine=PYBULLET,
                hand=hand_of(actuator),
                scene=_scene(with_sensor),
                model=Model(springs=springs),
                collision=collision,
                step=STEP,
                segments=segments,
                wrist=SENSOR,
            )
        )
        self.client = self.simulation.engine.world.client
        self._pressure = 0.0

    def __enter__(self) -> FingerStand:
        return self

    def __exit__(self, *reason: object) -> None:
        self.simulation.close()

    @property
    def chain(self) -> SegmentChain:
        """Links and springs of the finger."""
        return self.simulation.bodies.layout.models[FINGER].segments

    def rest_angles(self, pressure: float) -> Array:
        """Angles (n,) [rad] of the joints at a pressure [Pa] when nothing touches the finger."""
        return self.simulation.bodies.layout.models[FINGER].rest_rotation([pressure])[:, 1]

    def step(self, pressure: float) -> None:
        """One step with the chamber at a gauge pressure [Pa]."""
        fill(self.simulation, pressure)
        self.simulation.step()
        self._pressure = pressure

    def settle(self, pressure: float) -> None:
        """Bring the chamber to a gauge pressure [Pa] and wait until the finger is at rest.

        Raises RuntimeError as `rest`.
        """
        start, steps = self._pressure, round(RAMP / self.simulation.step_size)
        for k in range(steps):
            self.step(start + (pressure - start) * (k + 1) / steps)
        self.rest(pressure)

    def rest(self, pressure: float) -> None:
        """Wait until the finger is at rest, the chamber at a gauge pressure [Pa].

        Raises RuntimeError for a finger that does not come to rest.
        """
        still = 0
        for _ in range(round(LONGEST / self.simulation.step_size)):
            still = still + 1 if np.abs(self.simulation.bodies.v).max() < STILL else 0
            if still == CALM:
                return
            self.step(pressure)
        raise RuntimeError(f"the finger does not come to rest at {pressure:.0f} Pa")

    def block(self, gap: float, bottom: float) -> int:
        """Put a block beside the finger, its face at x = gap [m], from z = bottom [m] upwards;
        returns its id.

        It has no friction in the plane of bending, but sideways: a finger that presses on a smooth
        wall would leave its plane.
        """
        place = np.array([gap + self._thickened(), 0.0, bottom]) + np.array(BLOCK) * np.array(
            [1.0, 0.0, 1.0]
        )
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=BLOCK, physicsClientId=self.client
        )
        block = pybullet.createMultiBody(
            0, shape, -1, (place + self.origin).tolist(), physicsClientId=self.client
        )
        pybullet.setCollisionFilterGroupMask(
            block, -1, ENVIRONMENT_GROUP, -1, physicsClientId=self.client
        )
        pybullet.changeDynamics(
            block,
            -1,
            lateralFriction=1.0,
            anisotropicFriction=SIDEWAYS_ONLY,
            physicsClientId=self.client,
        )
        return block

    def touch(self, block: int) -> Touch:
        """Contact of the finger with a block; the place is NaN without contact."""
        points = pybullet.getContactPoints(block, physicsClientId=self.client)
        force = np.array([point[9] for point in points])
        places = np.array([point[6] for point in points]).reshape(-1, 3) - self.origin
        if not force.sum() > 0.0:
            return Touch(0.0, np.full(2, np.nan))
        return Touch(float(force.sum()), (force @ places / force.sum())[[0, 2]])

    def base_torque(self) -> Array:
        """Torque (3,) [N m] of the finger on its base; needs the sensor."""
        return self.simulation.wrist_wrench()[1].copy()

    def bends(self) -> Array:
        """Angles (n,) [rad] of the joints about y."""
        return self.simulation.bodies.rotations[:, 1].copy()

    def line(self) -> Array:
        """Places (n + 2, 3) [m] of base, joints and tip."""
        simulation = self.simulation
        joints = simulation.shape.frames(simulation.bodies.q)[0]
        tip = simulation.fingertips()[FINGER][0]
        return np.vstack([np.zeros(3), joints, tip])

    def _thickened(self) -> float:
        """How far [m] the collision box of the last link, which has a least height, stands out from
        the passive layer.
        """
        if self.simulation.config.collision != BOXES:
            return 0.0
        size = self.simulation.bodies.layout.size[-1, 0]
        return float(size - self.chain.body_size[-1, 0]) / 2.0

    @property
    def origin(self) -> Array:
        """Place (3,) [m] of the base in the world."""
        return np.array(self.simulation.scene.wrist_position)


def _scene(with_sensor: bool) -> SceneDescription:
    return replace(load_scene("stand"), rigid_wrist=not with_sensor)
