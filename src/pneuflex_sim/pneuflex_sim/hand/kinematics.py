"""Tips and angles of a hand from its joint orientations, and the readings of angle sensors at the
actuators' tips under the effects of a model.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.layout import HandLayout
from softhand_common.numerics.arrays import Array
from softhand_model.dynamics.chain import not_placed, place_links
from softhand_model.effects import OutputEffect
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.model_file import Model

SENSED_QUANTITY = "tip_angle"  # of output effects that act on the sensors


class HandShape:
    """Forward kinematics of a layout."""

    def __init__(self, layout: HandLayout) -> None:
        self.layout, self._links = layout, layout.links(0.0)
        self._bases = [Rotation.from_quat(body.orientation).as_matrix() for body in layout.bodies]
        self._tips: dict[str, slice] = {}  # joints from the base to each fingertip
        tips = []
        for name in layout.description.tips:
            k = next(k for k, body in enumerate(layout.bodies) if name in body.chains)
            last = layout.chain_joints[name].stop
            self._tips[name] = slice(layout.bodies[k].joints.start, last)
            tips.append((self._bases[k], layout.bodies[k].position, layout.chain_tips[name]))
        self._tip_frames = tuple(map(np.array, zip(*tips, strict=True)))

    def frames(self, q: Array) -> tuple[Array, Array, Array]:
        """Positions (n, 3) [m] and rotation matrices (n, 3, 3) of the joints, and centres of mass
        (n, 3) [m] of the links, in the wrist frame.
        """
        frame, arm, center, *_ = placed = not_placed(len(q))
        place_links(q, self._links, placed)
        position = np.empty_like(arm)
        for body, base in zip(self.layout.bodies, self._bases, strict=True):
            of_body = body.joints
            position[of_body] = np.cumsum(arm[of_body], axis=0) @ base.T + body.position
            frame[of_body] = base @ frame[of_body]
            center[of_body] = center[of_body] @ base.T + position[of_body]
        return position, frame, center

    def fingertips(self, q: Array) -> dict[str, tuple[Array, Array]]:
        """Position [m] and quaternion of each fingertip in the wrist frame, in the order of the
        hand's `tips`.
        """
        if not self._tips:
            return {}
        frame, arm, *_ = placed = not_placed(len(q))
        place_links(q, self._links, placed)
        base, place, tip = self._tip_frames
        arms = np.array([arm[joints].sum(axis=0) for joints in self._tips.values()])
        turn = base @ frame[[joints.stop - 1 for joints in self._tips.values()]]
        position = place + (base @ arms[..., None] + turn @ tip[..., None])[..., 0]
        turns = Rotation.from_matrix(turn).as_quat()
        return dict(zip(self._tips, zip(position, turns, strict=True), strict=True))

    def tip_angles(self, bend: Array) -> dict[str, float]:
        """Angle [rad] of the tip of each actuator relative to its base: the sum of its joints'
        bends (n,), except that of the strut.
        """
        angles = {}
        for chain in self.layout.description.chains:
            joints = self.layout.chain_joints[chain.name]
            first = joints.start + (1 if chain.strut is not None else 0)
            angle = float(bend[first : joints.stop].sum())
            angles.update(dict.fromkeys(chain.actuators, angle))
        return angles

    def center_of_mass(self, q: Array) -> Array:
        """Centre of mass (3,) of the chains in the wrist frame [m]."""
        center = self.frames(q)[2]
        return self.layout.mass @ center / self.layout.mass.sum()


class TipSensors:
    """One angle sensor per actuator, with the memory of the model's output effects.

    `active` says whether the model has such effects; without such effects readings are the true
    angles.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        shown = (e for e in model.stage("output") if isinstance(e, OutputEffect))
        self.active = any(effect.shows(SENSED_QUANTITY) for effect in shown)
        self.reset()

    def reset(self) -> None:
        """Clear the memory of all sensors, as after a long time at rest."""
        self._sensors: dict[str, StagedEffects] = {}
        self._readings: dict[str, float] = {}

    def step(self, dt: float, angles: Mapping[str, float]) -> None:
        """Advance the sensors by a step of dt [s], at the end of which `angles` are the true angles
        [rad] by actuator.
        """
        for name, angle in angles.items():
            sensor = self._sensors.setdefault(name, StagedEffects(self._model.stage("output")))
            self._readings[name] = float(sensor.reading(SENSED_QUANTITY, np.asarray(angle), dt))

    def readings(self, angles: Mapping[str, float]) -> dict[str, float]:
        """Readings [rad] by actuator after the last step; before the first step, those of a step of
        zero duration at the true angles [rad].
        """
        if not self.active:
            return dict(angles)
        if not self._readings:
            self.step(0.0, angles)
        return dict(self._readings)
