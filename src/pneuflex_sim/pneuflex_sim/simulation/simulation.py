"""The simulator without ROS: hand, wrist, air, object and scene, stepped together."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from pneuflex_sim.engines import build_engine
from pneuflex_sim.engines.contract import Engine, Hand, Surroundings
from pneuflex_sim.hand.air import BEND_AXIS, AirCoupling
from pneuflex_sim.hand.joint_stops import JointStops
from pneuflex_sim.hand.kinematics import HandShape, TipSensors
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.hand.wrist import Wrist
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.scene.object_protocol import BodyOfObject
from pneuflex_sim.scene.object_spring import HOLDING_MASS as HOLDING_MASS
from pneuflex_sim.scene.object_spring import ObjectSpring
from pneuflex_sim.simulation.config import SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_model.effects import FlowEffect
from softhand_model.effects.hand import object_mass_factor
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.pneumatics.plant import PneumaticPlant

SAVED_ATTRIBUTES = (
    "steps",
    "wrist",
    "pressures_abs",
    "_acting_abs",
    "_volumes",
    "_imposed",
    "tip_sensors",
    "_spring",
)


class Simulation:
    """One world with one hand. Channels are in the order of the hand's YAML; air masses are
    relative to the fill at rest and ambient pressure. `engine` moves the bodies.
    """

    def __init__(self, config: SimulationConfig | None = None) -> None:
        self.config = config = config or SimulationConfig()
        self.hand, model = config.described_hand(), config.described_model()
        self.friction = config.friction_table(model)
        self.scene = config.described_scene(self.friction)
        self.object = config.described_object(self.friction) if self.scene.has_object else None
        layout = build_layout(self.hand, config.segments, model)
        self.channels: tuple[str, ...] = tuple(self.hand.channels)
        self.step_size, self.temperature = config.step, ROOM_TEMPERATURE
        self.wrist = self._new_wrist()
        self.air = AirCoupling(layout)
        self._layout, self._weight_scale = layout, model.gravity_scale
        self._mass_factor = object_mass_factor(model.effects)
        self._make_world()
        self.shape = HandShape(layout)
        self.tip_sensors = TipSensors(model)
        self.stops = JointStops(layout)
        flow = model.stage("flow")
        self._flow_effects = [effect for effect in flow if isinstance(effect, FlowEffect)]
        self.plant = PneumaticPlant(
            self.channels, self.air.rest_volumes, seed=config.seed, effects=self._flow_effects
        )
        self.ambient = self.plant.parameters.ambient_pressure
        self._object_weight = (1 - self._weight_scale) * STANDARD_GRAVITY
        self.start = 0.0  # simulated time before the first step [s]
        self.reset()

    # ---------------------------------------------------------------- set-up
    def _make_world(self) -> None:
        """Create the engine's world with everything in it."""
        config = self.config
        around = Surroundings(
            config.step,
            self._layout,
            self.air,
            self.scene,
            self.friction,
            self.object,
            self.wrist,
            self._weight_scale,
            config.collision,
            config.finger_contact,
            config.gui,
            config.solver,
        )
        self.engine: Engine = build_engine(config.engine, around)
        self.engine.scale_friction(config.friction_scale)
        if self._body is not None:
            self._body.set_mass(self._stated_mass * config.object_mass_scale)

    @property
    def bodies(self) -> Hand:
        """The hand's joints."""
        return self.engine.bodies

    @property
    def _body(self) -> BodyOfObject | None:
        return self.engine.object

    @property
    def _stated_mass(self) -> float:
        """Mass of the object [kg] as described, and as the model's effects have it."""
        return self._mass_factor * self._object().description.mass

    def _new_wrist(self) -> Wrist:
        orientation = Rotation.from_euler("xyz", self.scene.wrist_rpy).as_quat()
        return Wrist(self.config.wrist, np.array(self.scene.wrist_position), orientation)

    def reset(self) -> None:
        """Return to the start: hand at rest at the scene's wrist pose, air at ambient pressure,
        object in its place, time at `start`.
        """
        self.steps = 0
        self.wrist = self._new_wrist()
        if self.engine.broken:
            self.engine.close()
            self._make_world()
        for model in self.bodies.layout.models.values():
            model.reset()
        self.tip_sensors.reset()
        self.bodies.reset(self.wrist)
        self.plant.reset(self.air.rest_volumes)
        self._imposed: Array | None = None
        self._volumes = self.air.volumes(self.bodies.rotations)
        self.pressures_abs = np.full(len(self.channels), self.ambient)
        self._acting_abs = self.pressures_abs
        self._put_object()

    def _put_object(self) -> None:
        self._spring: ObjectSpring | None = None
        if self._body is None:
            return
        self._body.resist(0.0, 0.0)
        place = np.array([0.0, 0.0, self._body.description.rest_height])
        place[: len(self.config.object_offset)] += self.config.object_offset
        self._body.put(place, self._body.description.rpy, self.config.object_yaw)

    def place_object(
        self,
        offset: tuple[float, ...],
        mass_scale: float,
        yaw: float = 0.0,
        friction_scale: float = 1.0,
    ) -> None:
        """Put the object at rest at another offset [m] from its place, turned by `yaw` [rad] about
        the vertical, with another mass and with the friction of all pairs scaled; raises ValueError
        as `SimulationConfig` does. A reset puts it there again.
        """
        self.config = replace(
            self.config,
            object_offset=offset,
            object_mass_scale=mass_scale,
            object_yaw=yaw,
            friction_scale=friction_scale,
        )
        self.engine.scale_friction(friction_scale)
        if self._body is not None:
            self._body.set_mass(self._stated_mass * mass_scale)
        self._put_object()

    # ---------------------------------------------------------------- commands
    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist in the world: position (3,) [m], quaternion (4,)."""
        self.wrist.command(position, orientation)

    def set_air_masses(self, masses: Array) -> None:
        """Impose the channels' air masses (channels,) [kg above rest] instead of those that flow
        through the valves.

        Raises ValueError for a wrong shape, and for a model with flow effects, which act on valve
        pulses only.
        """
        if self._flow_effects:
            names = ", ".join(effect.name for effect in self._flow_effects)
            raise ValueError(
                f"{self.config.model_name}: effects: {names}: act on valve pulses, and "
                "imposed air masses have none; command the valves, or leave these effects out"
            )
        masses = np.asarray(masses, float)
        if masses.shape != (len(self.channels),) or not np.isfinite(masses).all():
            raise ValueError(
                f"air masses: expected {len(self.channels)} finite numbers, got {masses}"
            )
        self._imposed = masses

    def hold_object(self, position: Array, orientation: Array) -> None:
        """Put the object at rest at a pose in the wrist frame, position (3,) [m] and quaternion
        (4,), and hold it there by a spring in six directions.

        Raises ValueError for an invalid pose, for a sheet, and in a scene without object.
        """
        body = self._object()
        if body.is_sheet:
            raise ValueError("held object: expected a rigid one, got a sheet")
        self._spring = ObjectSpring(tuple(map(float, position)), tuple(map(float, orientation)))
        body.put_at(*self._spring.pose(*self.wrist_pose()))

    def release_object(self, duration: float = 0.0) -> None:
        """Let the spring that holds the object fade within a duration [s], linearly."""
        if self._spring is not None:
            self._spring = self._spring.fading(self.time, duration)

    def push_object(self, force: Array) -> None:
        """Add a force (3,) [N] at the object's centre of mass, in world axes, for the next step."""
        self._object().push(np.asarray(force, float), np.zeros(3))

    def _pull_object(self, body: BodyOfObject, spring: ObjectSpring) -> None:
        weight = STANDARD_GRAVITY * (body.mass + self._weight_scale * HOLDING_MASS)
        spring.pull(body, self.wrist_pose(), self.time, self.step_size, weight)
        if spring.strength(self.time) == 0.0:
            self._spring = None

    # ---------------------------------------------------------------- stepping
    def step(self, valves: ArrayLike | None = None) -> None:
        """One physics step.

        `valves` (channels,) is +1 inflate, -1 deflate, 0 closed; None: imposed masses are kept, or
        without them all valves closed. Warns once (RuntimeWarning) when the pressure would bend a
        joint beyond its stop.
        """
        self._update_air(valves)
        self._acting_abs = self.air.acting(self.step_size, self._acting_abs, self.pressures_abs)
        pressures = self._acting_abs - self.ambient
        self.stops.look(pressures)
        if not self.air.by_tables:
            self.air.bend_by_models(
                self.step_size, pressures, self.bodies.rotations, self.temperature
            )
        self.engine.drive(self.ambient, self._acting_abs, self._volumes, self.wrist)
        if self._body is not None and self._object_weight:
            self._body.pull_down(self._object_weight)
        if self._body is not None and self._spring is not None:
            self._pull_object(self._body, self._spring)
        self.engine.advance(self.wrist)
        self.steps += 1
        if self.tip_sensors.active:
            self.tip_sensors.step(self.step_size, self.tip_angles())

    def _update_air(self, valves: ArrayLike | None) -> None:
        rotations = self.bodies.rotations
        if self._imposed is not None:
            self.pressures_abs, self._volumes = self.air.enclosed_air(
                self._imposed, self.ambient, self.temperature, rotations
            )
            return
        self._volumes = self.air.volumes(rotations)
        wanted = np.zeros(len(self.channels)) if valves is None else valves
        self.pressures_abs = self.plant.step(self.step_size, wanted, self._volumes)

    # ---------------------------------------------------------------- observation
    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.start + self.steps * self.step_size

    def wrist_pose(self) -> tuple[Array, Array]:
        """Position [m] and quaternion of the wrist in the world."""
        return self.wrist.position, self.wrist.orientation

    def wrist_wrench(self) -> tuple[Array, Array]:
        """Force [N] and torque [N m] of the hand on the wrist, without its own weight, in world
        axes.
        """
        return self.wrist.force, self.wrist.torque

    @property
    def object_mass(self) -> float:
        """Mass of the object now [kg]; raises ValueError in a scene without one."""
        return self._object().mass

    def object_pose(self) -> tuple[Array, Array]:
        """Position [m] and quaternion of the object.

        Raises ValueError in a scene without object, Diverged when the pose is not finite.
        """
        return self._object().pose()

    def _object(self) -> BodyOfObject:
        if self._body is None:
            raise ValueError(f"object: expected a scene with an object, got {self.scene.name}")
        return self._body

    def pressures(self) -> Array:
        """Gauge pressure of each channel [Pa]."""
        return self.pressures_abs - self.ambient

    def air_masses(self) -> Array:
        """True air mass of each channel [kg above rest at ambient]."""
        return self.air.masses(
            self.pressures_abs, self.ambient, self.temperature, self.bodies.rotations
        )

    def read_sensors(self) -> Array:
        """Noisy absolute pressures (channels + 1,) [Pa] of the channels and, last, of the
        supply.
        """
        return self.plant.read()

    def tip_angles(self) -> dict[str, float]:
        """Angle [rad] of the tip of each actuator relative to its base: the sum of its joints'
        bends, except that of the strut.
        """
        return self.shape.tip_angles(self.bodies.rotations[:, BEND_AXIS])

    def read_tip_angles(self) -> dict[str, float]:
        """Tip angles [rad] as read by their sensors."""
        return self.tip_sensors.readings(self.tip_angles())

    def fingertips(self) -> dict[str, tuple[Array, Array]]:
        """Position [m] and quaternion of each fingertip in the wrist frame."""
        return self.shape.fingertips(self.bodies.q)

    def contacts(self) -> list[Contact]:
        """All contact points of hand, object and scene."""
        return self.engine.contacts()

    def object_contacts(self) -> list[Contact]:
        """Contact points of the object with anything."""
        return self.engine.object_contacts()

    def touching_object(self) -> frozenset[str]:
        """Names of the bodies that press on the object: chains, palm plate, parts of the scene."""
        return self.engine.touching_object()

    def object_gaps(self, reach: float) -> dict[str, float]:
        """Distance [m] of the object from each part of the hand within a reach [m]; negative where
        they overlap.
        """
        return self.engine.object_gaps(reach)

    def object_box(self) -> Array:
        """Corners (2, 3) [m] of the object's bounding box along the world's axes; raises ValueError
        in a scene without object.
        """
        self._object()
        boxes = self.engine.object_boxes()
        return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    def hand_boxes(self) -> Array:
        """Bounding boxes (k, 2, 3) [m], along the world's axes, of the hand's links, palm sheet and
        plate.
        """
        return self.engine.hand_boxes()

    # ---------------------------------------------------------------- snapshots
    def save(self) -> dict[str, Any]:
        """Snapshot to return to with `restore`, bit for bit. It is valid for this simulation
        only.
        """
        return {
            "engine": self.engine.save(),
            "models": copy.deepcopy(self.bodies.layout.models),
            "plant": self.plant.save(),
            "own": copy.deepcopy({name: getattr(self, name) for name in SAVED_ATTRIBUTES}),
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Return to a snapshot."""
        self.engine.restore(saved["engine"])
        self.bodies.layout.models.update(copy.deepcopy(saved["models"]))
        self.plant.restore(saved["plant"])
        for name, value in copy.deepcopy(saved["own"]).items():
            setattr(self, name, value)
        if self._body is not None:
            self._body.resist(0.0, 0.0)  # a spring brings what it resists with in the next step

    def close(self) -> None:
        """Free what the engine holds."""
        self.engine.close()
