"""The engine MuJoCo, with the interface of `pneuflex_sim.engines.contract`."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.engines.contract import Surroundings
from pneuflex_sim.engines.mujoco.compliance import set_compliance
from pneuflex_sim.engines.mujoco.springs import Places, State, read_joints, set_springs
from pneuflex_sim.engines.mujoco.thing import MujocoObject
from pneuflex_sim.engines.mujoco.touches import Touches
from pneuflex_sim.engines.mujoco.world import PALM_PAD, WRIST, document
from pneuflex_sim.engines.mujoco.wrist import push_wrist, read_wrist
from pneuflex_sim.hand.driven_bases import HandWeight
from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.hand.wrist import Wrist
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.world import Diverged, SolverSettings
from softhand_common.numerics.arrays import Array
from softhand_model.dynamics.joint_springs import look_at_joints
from softhand_model.effects.load import STANDARD_GRAVITY

FASTEST = 1e4  # [rad/s]; faster, a joint has no meaning any more
LARGEST_TOUCHING_STEP = 0.004  # at which fingers that touch come to rest [s]; not at 0.005
WHOLE = mujoco.mjtState.mjSTATE_INTEGRATION

mujoco.set_mju_user_warning(lambda message: None)  # else it writes a file into the current folder


class MujocoHand:
    """The joints of the hand in a model; arrays have one row per joint, in the order of the
    layout.

    Attributes:
        q, v: orientations (n, 4) and velocities (n, 3) [rad/s] of the joints.
        rotations: (n, 3) [rad], rotation vector of each joint relative to its rest without
            pressure; y is the bend.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, layout: HandLayout) -> None:
        self.layout, self.rest = layout, np.ascontiguousarray(layout.rest)
        n = len(layout.mass)
        self.q, self.v, self.rotations = self.rest.copy(), np.zeros((n, 3)), np.zeros((n, 3))
        own = {model.joint(k).name: k for k in range(model.njnt)}
        balls = np.array([name in own for name in layout.names])
        first = np.array([own.get(name, own.get(f"{name}_y")) for name in layout.names])
        positions, speeds, springs = (
            np.array(index, np.int64)
            for index in (model.jnt_qposadr[first], model.jnt_dofadr[first], first)
        )
        self.places = Places(positions, speeds, springs, balls)
        self.state = State(data.qpos, data.qvel, model.qpos_spring, model.jnt_stiffness)
        self._model, self._data = model, data
        scene_wrist = own.get(WRIST)
        self.wrist_at = None if scene_wrist is None else int(model.jnt_qposadr[scene_wrist])
        self.wrist_speed = None if scene_wrist is None else int(model.jnt_dofadr[scene_wrist])
        self._pad = own.get(PALM_PAD)

    def reset(self, wrist: Wrist, joints: Array | None = None) -> None:
        """Put the hand at the wrist and every joint at its orientation in `joints` (n, 4), by
        default at rest without pressure; all velocities are zero.
        """
        data, model = self._data, self._model
        data.qvel[:] = data.qacc_warmstart[:] = data.qfrc_applied[:] = 0.0
        if self.wrist_at is not None:
            pose = np.array([*wrist.position, *np.roll(wrist.orientation, 1)])
            data.qpos[self.wrist_at : self.wrist_at + 7] = pose
        if self._pad is not None:
            data.qpos[model.jnt_qposadr[self._pad]] = 0.0
        place_joints(self.rest, self.rest if joints is None else joints, self.places, data.qpos)
        self.read()

    def read(self) -> float:
        """Read orientations and velocities from MuJoCo; returns the highest speed [rad/s] of a
        joint."""
        read_joints(self.rest, self.places, self.state, self.q, self.v)
        return look_at_joints(self.rest, self.q, self.v, self.rotations)


def place_joints(rest: Array, joints: Array, places: Places, qpos: Array) -> None:
    """Write joint orientations (n, 4) into MuJoCo's positions."""
    for i, turn in enumerate(Rotation.from_quat(rest).inv() * Rotation.from_quat(joints)):
        at = places.position[i]
        if places.is_ball[i]:
            qpos[at : at + 4] = np.roll(turn.as_quat(), 1)
        else:
            qpos[at : at + 3] = turn.as_euler("YXZ")


class MujocoEngine:
    """A model of MuJoCo's with hand, object and scene in it."""

    def __init__(self, around: Surroundings) -> None:
        _check(around)
        self.model = mujoco.MjModel.from_xml_string(document(around))
        soft = None if around.object is None else around.object.compliance
        set_compliance(self.model, around.layout.names, soft)
        self.data = mujoco.MjData(self.model)
        layout = self._layout = around.layout
        self._air, self._wrist = around.air, around.wrist
        self._step, self.broken = around.step, False
        self.bodies = MujocoHand(self.model, self.data, layout)
        self.object = None
        if around.object is not None:
            self.object = MujocoObject(self.model, self.data, around.object)
        self._touches = Touches(self.model, self.data, layout)
        self._friction = self.model.geom_friction.copy(), self.model.pair_friction.copy()
        gravity = around.weight_scale * STANDARD_GRAVITY
        center = HandShape(layout).center_of_mass(layout.rest)
        self._weight = HandWeight(gravity, float(layout.mass.sum()) * gravity, center)
        self._push = np.zeros((2, 3))
        self._find_wrist()
        self.bodies.reset(around.wrist)

    def _find_wrist(self) -> None:
        """Views of the wrist's free joint; none for a rigid one."""
        hand, data = self.bodies, self.data
        if hand.wrist_at is None or hand.wrist_speed is None:
            self._free = None
            return
        speed = slice(hand.wrist_speed, hand.wrist_speed + 6)
        self._free = (
            data.qfrc_applied[speed],
            data.qpos[hand.wrist_at : hand.wrist_at + 7],
            data.qvel[speed],
        )

    def drive(self, ambient: float, pressures_abs: Array, volumes: Array, wrist: Wrist) -> None:
        """Apply the springs of the joints at absolute pressures [Pa], and the force of the arm on
        the wrist."""
        air, layout, hand = self._air, self._layout, self.bodies
        set_springs(
            air.by_tables,
            pressures_abs - ambient,
            air.tables,
            layout.stiffness,
            layout.stretching,
            air.actuation,
            hand.places,
            hand.state,
        )
        if self._free is not None:
            push_wrist(self._step, wrist.arm, self._weight, wrist.state, self._push, self._free[0])

    def advance(self, wrist: Wrist) -> None:
        """One step."""
        mujoco.mj_step(self.model, self.data)
        fastest = self.bodies.read()
        if self._free is not None:
            read_wrist(self._step, wrist.arm, wrist.state, self._push, *self._free[1:])
        if self.object is not None:
            self.object.let_be()
        if not np.isfinite(fastest) or fastest > FASTEST:
            self.broken = True
            raise Diverged(
                f"the simulation diverged: a joint turns at {fastest:.0f} rad/s (expected below "
                f"{FASTEST:.0f}); a smaller step or slower commands are needed"
            )

    def contacts(self) -> list[Contact]:
        """All contact points that carry a force."""
        return self._touches.contacts()

    def object_contacts(self) -> list[Contact]:
        """Contact points of the object with anything."""
        return self._touches.contacts(only_object=True)

    def touching_object(self) -> frozenset[str]:
        """Names of the bodies that press on the object."""
        return self._touches.touching_object()

    def object_gaps(self, reach: float) -> dict[str, float]:
        """Distance [m] of the object from each part of the hand within a reach [m]."""
        return self._touches.gaps(reach)

    def object_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m] around the object's parts: lowest and highest corner in the world."""
        return self._touches.boxes(self._touches.of_object)

    def hand_boxes(self) -> Array:
        """Boxes (k, 2, 3) [m] around the hand's links, palm sheet and plate."""
        return self._touches.boxes(self._touches.of_hand)

    def scale_friction(self, factor: float) -> None:
        """Scale the sliding friction of every pair to a factor of the table's."""
        geoms, pairs = self._friction
        self.model.geom_friction[:, :2] = factor * geoms[:, :2]
        self.model.pair_friction[:, :2] = factor * pairs[:, :2]

    def save(self) -> tuple[Array, Array]:
        """The state."""
        state = np.empty(mujoco.mj_stateSize(self.model, WHOLE))
        mujoco.mj_getState(self.model, self.data, state, WHOLE)
        return state, self._push.copy()

    def restore(self, saved: tuple[Array, Array]) -> None:
        """Return to a state, with its contacts."""
        mujoco.mj_setState(self.model, self.data, saved[0], WHOLE)
        self._push[:] = saved[1]
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, saved[0], WHOLE)
        self.bodies.read()

    def close(self) -> None:
        """Nothing to free."""


def _check(around: Surroundings) -> None:
    """Raise ValueError for what this engine does not do."""
    if around.gui:
        raise ValueError(
            "gui: expected false with engine mujoco, which opens no window; use softhand-play, "
            "or engine pybullet"
        )
    if around.finger_contact and around.step > LARGEST_TOUCHING_STEP:
        raise ValueError(
            f"step: expected at most {1e3 * LARGEST_TOUCHING_STEP:g} ms with finger_contact and "
            f"engine mujoco, got {1e3 * around.step:g} ms, at which fingers that touch each other "
            "do not come to rest"
        )
    if around.solver != SolverSettings():
        raise ValueError(
            "solver: expected default with engine mujoco, whose solver always iterates until it "
            "has converged; for other settings use engine pybullet"
        )
