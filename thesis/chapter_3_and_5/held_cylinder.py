"""A cylinder in the closed hand, held without weight and then loaded by forces at its centre."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.model_file import Model, load_model
from softhand_model.usual_step import USUAL_STEP
from thesis.chapter_3_and_5.stand import SENSOR, fill
from thesis.frame import Array

STEP = USUAL_STEP  # [s]
CLOSING, CALM = 1.5, 1.0  # [s] in which the pressures rise, and the cylinder comes to rest
ACROSS = (np.pi / 2.0, 0.0, 0.0)  # the cylinder's axis along y, across the fingers [rad]
DAMPED = 0.99  # of the cylinder while the hand closes, so that it does not swing
OBJECT = "cylinder"  # 65 mm across, 175 mm long
OBJECT_MASS = 0.106  # [kg]


@dataclass(frozen=True)
class Grasp:
    """A hand and how it closes around the cylinder: name, place (3,) [m] of the cylinder's centre
    in the wrist frame at the start, gauge pressures [Pa] of the channels, segments per actuator,
    and the model file, used without weight.
    """

    hand: str
    place: tuple[float, float, float]
    pressures: tuple[float, ...]
    segments: int = 5
    model: str = "base"


def weightless(name: str) -> Model:
    """A shipped model without the weight of the actuators."""
    model = load_model(name)
    return replace(model, effects=tuple(e for e in model.effects if e.name != "gravity"))


class HeldCylinder:
    """A hand on a stiff wrist that holds a cylinder of a mass [kg], in the frame of the wrist: x
    out of the palm, y across the fingers, z along them. Actuators have no weight.
    """

    def __init__(self, grasp: Grasp, mass: float = OBJECT_MASS) -> None:
        self._pressures = np.array(grasp.pressures)
        scene = replace(load_scene("stand"), has_object=True, rigid_wrist=False)
        self.simulation = simulation = Simulation(
            SimulationConfig(
                engine=PYBULLET,
                hand=grasp.hand,
                scene=scene,
                object=OBJECT,
                object_mass_scale=mass / OBJECT_MASS,
                model=weightless(grasp.model),
                step=STEP,
                segments=grasp.segments,
                wrist=SENSOR,
            )
        )
        self._client, self._origin = simulation.engine.world.client, np.array(scene.wrist_position)
        self._put(np.array(grasp.place))
        self._close()

    def __enter__(self) -> HeldCylinder:
        return self

    def __exit__(self, *reason: object) -> None:
        self.simulation.close()

    @property
    def place(self) -> Array:
        """Place (3,) [m] of the cylinder's centre."""
        return self.simulation.object_pose()[0] - self._origin

    def touching(self) -> list[str]:
        """Names of the parts of the hand that touch the cylinder."""
        return sorted({contact.first for contact in self.simulation.object_contacts()})

    def load(self, force: Array) -> None:
        """One step under a force (3,) [N] at the cylinder's centre, without its weight."""
        self._step(force, 1.0)

    def _put(self, place: Array) -> None:
        pybullet.resetBasePositionAndOrientation(
            self.simulation.engine.object_id,
            (place + self._origin).tolist(),
            pybullet.getQuaternionFromEuler(ACROSS),
            physicsClientId=self._client,
        )

    def _close(self) -> None:
        """Raise the pressures and wait; the cylinder is weightless while the hand closes."""
        self._damp(DAMPED)
        rising = round(CLOSING / STEP)
        for k in range(rising + round(CALM / STEP)):
            self._step(np.zeros(3), min(1.0, (k + 1) / rising))
        self._damp(0.0)

    def _damp(self, share: float) -> None:
        pybullet.changeDynamics(
            self.simulation.engine.object_id,
            -1,
            linearDamping=share,
            angularDamping=share,
            physicsClientId=self._client,
        )

    def _step(self, force: Array, share: float) -> None:
        """One step with the channels at a share of the pressures; they stay open to the supply."""
        simulation = self.simulation
        fill(simulation, share * self._pressures)
        lift = simulation.object_mass * STANDARD_GRAVITY
        pybullet.applyExternalForce(
            simulation.engine.object_id,
            -1,
            (force + [0.0, 0.0, lift]).tolist(),
            simulation.object_pose()[0].tolist(),
            pybullet.WORLD_FRAME,
            physicsClientId=self._client,
        )
        simulation.step()
