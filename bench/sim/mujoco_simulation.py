"""The hand in MuJoCo, stepped and observed as `pneuflex_sim.simulation.Simulation` is, so that the
same strategy and the same judge run on both.

The air is computed by the simulator's own kernels: before each step the chambers' volumes follow
from the joints, the pressures from the imposed masses, and the springs' references of the ball
joints from the pressures.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bench.sim.mujoco_model import OBJECT, WRIST, Settings, model_text
from pneuflex_sim.dynamics.spatial import quaternion_of_rotation, rotation_between
from pneuflex_sim.hand.air import (
    BEND_AXIS,
    AirCoupling,
    act_on_joints,
    chamber_volumes,
    enclosed_pressures_abs,
)
from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.scene.objects import ObjectDescription, load_object
from pneuflex_sim.scene.scenes import SceneDescription, load_scene
from pneuflex_sim.simulation import SimulationConfig
from softhand_common.numerics.compiled import compiled
from softhand_common.numerics.rotations import compose, from_rpy
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import load_model

Array = NDArray[np.float64]

mujoco.set_mju_user_warning(lambda message: None)  # else it writes a file into the current folder


class MujocoSimulation:
    """What `Simulation` offers to a strategy, of a configuration by the same class; model, friction
    and collision shapes are the default ones.
    """

    def __init__(self, config: SimulationConfig, settings: Settings | None = None) -> None:
        hand, scene, thing = config.hand, config.scene, config.object
        self.hand = hand if isinstance(hand, HandDescription) else load_hand(hand)
        self.scene = scene if isinstance(scene, SceneDescription) else load_scene(scene)
        described = thing if isinstance(thing, ObjectDescription) else load_object(thing)
        self.layout = build_layout(self.hand, config.segments, load_model(None))
        self.air, self.shape = AirCoupling(self.layout), HandShape(self.layout)
        self.channels, self.step_size = tuple(self.hand.channels), config.step
        self.model = mujoco.MjModel.from_xml_string(
            model_text(
                self.layout,
                self.scene,
                described if self.scene.has_object else None,
                config,
                settings or Settings(),
            )
        )
        self.data = mujoco.MjData(self.model)
        self.turned = np.zeros_like(self.layout.stiffness)
        self._pressures = np.full(len(self.channels), AMBIENT_PRESSURE)
        self._masses = np.zeros(len(self.channels))
        self._find_addresses()
        self.steps = 0
        mujoco.mj_forward(self.model, self.data)

    def _find_addresses(self) -> None:
        """Where joints, wrist and object are in MuJoCo's arrays."""
        names, model = self.layout.names, self.model
        balls = [k for k in range(model.njnt) if model.jnt_type[k] == mujoco.mjtJoint.mjJNT_BALL]
        address = {model.joint(k).name: int(model.jnt_qposadr[k]) for k in balls}
        self._address = np.array([address.get(name, -1) for name in names])
        self._qpos, self._reference = self.data.qpos, model.qpos_spring
        if not self.scene.rigid_wrist:
            self._wrist_at = np.array(self.scene.wrist_position)
            self._wrist_turn = from_rpy(self.scene.wrist_rpy)
            self._slides = int(model.joint(f"{WRIST}_x").qposadr[0])
            self._slide_dofs = int(model.joint(f"{WRIST}_x").dofadr[0])
            self._ball = address[WRIST]
        if self.scene.has_object:
            self._object = int(model.joint(OBJECT).qposadr[0])
            self._object_geom = model.geom(OBJECT).id
        chain_of = {
            names[joint]: chain
            for chain, joints in self.layout.chain_joints.items()
            for joint in range(joints.start, joints.stop)
        }
        geoms = [model.geom(k).name for k in range(model.ngeom)]
        self._names = [chain_of.get(name, name) for name in geoms]

    # ---------------------------------------------------------------- commands
    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Set the target pose of the wrist: position (3,) [m], quaternion (4,)."""
        turn = Rotation.from_quat(self._wrist_turn).inv() * Rotation.from_quat(orientation)
        self.data.ctrl[:3] = position - self._wrist_at
        self.data.ctrl[3:6] = turn.as_rotvec()

    def set_air_masses(self, masses: Array) -> None:
        """Impose the channels' air masses [kg above rest]."""
        self._masses = masses

    # ---------------------------------------------------------------- stepping
    def step(self) -> None:
        """One step; raises RuntimeError when the simulation has diverged."""
        air = self.air
        move_references(
            self._masses,
            self._pressures,
            AMBIENT_PRESSURE,
            GAS_CONSTANT * ROOM_TEMPERATURE,
            air.rest_volumes,
            air.volume_gain,
            air.tables,
            air.actuation,
            self.layout.stiffness,
            self._address,
            self._qpos,
            self.turned,
            self._reference,
        )
        mujoco.mj_step(self.model, self.data)
        self.steps += 1
        if self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            raise RuntimeError("MuJoCo diverged")

    # ---------------------------------------------------------------- observation
    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.steps * self.step_size

    def pressures(self) -> Array:
        """Gauge pressure of each channel [Pa]."""
        return self._pressures - AMBIENT_PRESSURE

    def wrist_pose(self) -> tuple[Array, Array]:
        """Position [m] and quaternion of the wrist in the world."""
        moved = self._qpos[self._slides : self._slides + 3]
        turn = np.roll(self._qpos[self._ball : self._ball + 4], -1)
        return self._wrist_at + moved, compose(self._wrist_turn, turn)

    def wrist_wrench(self) -> tuple[Array, Array]:
        """Force (3,) [N] of all contacts on the hand, in world axes; the torque is left out."""
        force = self.data.qfrc_constraint[self._slide_dofs : self._slide_dofs + 3]
        return force.copy(), np.full(3, np.nan)

    def object_pose(self) -> tuple[Array, Array]:
        """Position [m] and quaternion of the object."""
        place = self._qpos[self._object : self._object + 7]
        return place[:3].copy(), np.roll(place[3:], -1)

    def object_contacts(self) -> list[Contact]:
        """Contacts of the object that carry a force."""
        found, wrench = [], np.zeros(6)
        for index in range(self.data.ncon):
            contact = self.data.contact[index]
            sides = contact.geom1, contact.geom2
            if self._object_geom not in sides:
                continue
            mujoco.mj_contactForce(self.model, self.data, index, wrench)
            if wrench[0] > 0:
                names = [self._names[side] for side in sides]
                first, second = names if names[1] == OBJECT else names[::-1]
                normal = tuple(contact.frame[:3])
                found.append(Contact(first, "", second, tuple(contact.pos), normal, wrench[0]))
        return found

    def touching_object(self) -> frozenset[str]:
        """Names of what presses on the object."""
        return frozenset(contact.first for contact in self.object_contacts())

    def tip_angles(self) -> dict[str, float]:
        """Bend of each chain from base to tip [rad], as `Simulation.tip_angles`."""
        return self.shape.tip_angles(self.turned[:, BEND_AXIS])

    def joints(self) -> Array:
        """Orientation (n, 4) of each joint's link against the one before, for pictures."""
        found = np.empty((len(self._address), 4))
        for joint, address in enumerate(self._address):
            if address >= 0:
                turn = np.roll(self._qpos[address : address + 4], -1)
            else:
                first = self.model.joint(f"{self.layout.names[joint]}_x").qposadr[0]
                angles = self._qpos[first : first + 3]
                turn = Rotation.from_euler("XYZ", angles).as_quat()
            found[joint] = compose(self.layout.rest[joint], turn)
        return found

    def close(self) -> None:
        """Nothing to free."""


@compiled
def move_references(
    masses,
    pressures,
    ambient,
    heat,
    rest_volumes,
    gain,
    tables,
    actuation,
    stiffness,
    address,
    qpos,
    turned,
    reference,
):
    """Rotations (n, 3) [rad] of the joints from MuJoCo's positions, absolute pressures (channels,)
    [Pa] of the masses, and the springs' references from them; `address` (n,) of the ball joints'
    quaternions w, x, y, z, -1 for joints that no pressure bends.
    """
    straight, turn = np.array([0.0, 0.0, 0.0, 1.0]), np.empty(4)
    for i in range(len(address)):
        if address[i] >= 0:
            for k in range(4):
                turn[k] = qpos[address[i] + (k + 1) % 4]
            turned[i, 0], turned[i, 1], turned[i, 2] = rotation_between(straight, turn)
    volumes = np.empty_like(masses)
    chamber_volumes(rest_volumes, gain, turned, volumes)
    enclosed_pressures_abs(masses, heat, ambient, rest_volumes, volumes, pressures)
    no_drop = np.zeros_like(pressures)
    act_on_joints(pressures - ambient, no_drop, True, tables, stiffness, actuation)
    for i in range(len(address)):
        if address[i] >= 0:
            rest = quaternion_of_rotation(actuation.bend[i])
            for k in range(4):
                reference[address[i] + (k + 1) % 4] = rest[k]
