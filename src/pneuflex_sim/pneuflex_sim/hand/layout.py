"""The joints of a whole hand in one set of arrays, in the order of the kernels and of PyBullet.

A chain mounted on another one (the thumb on the palm) continues the serial body of its parent;
every other chain starts a body of its own at its mount on the wrist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.chain.hulls import SMALLEST_EDGE
from softhand_model.chain.segments import link_inertia
from softhand_model.chain.serial import mounted, serial_chains
from softhand_model.dynamics.chain import Links
from softhand_model.dynamics.joint_springs import Springs
from softhand_model.effects.hand import altered, damping_time
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

MAX_SPHERICAL_JOINTS = 30  # beyond that PyBullet returns empty joint states without an error
ADDED_INERTIA = 0.2  # at a step of 1 ms [-]
TIP_SHARE = 0.3
# chosen on the first frequency and on the clashes and blows of `bench.sim --rows holding`
GIVEN_SHARE = 0.9  # of the added inertia that is given back
TRUE_STEP = 0.002  # [s] up to which it is given back


@dataclass(frozen=True)
class Body:
    """One serial PyBullet body: name, pose of its base in the wrist frame, its joints and the
    chains it carries.
    """

    name: str
    position: Array
    orientation: Array
    joints: slice
    chains: tuple[str, ...]


@dataclass(frozen=True)
class HandLayout:
    """All joints of a hand and their bodies; arrays have shapes (n, ...) as in `SegmentChain`."""

    description: HandDescription
    segments: int  # an actuator
    models: dict[str, ChainModel]
    bodies: tuple[Body, ...]
    chain_joints: dict[str, slice]
    chain_tips: dict[str, Array]
    names: tuple[str, ...]
    offset: Array
    rest: Array
    stiffness: Array
    stretching: Array
    size: Array
    center: Array
    mass: Array
    damping_time: float  # damping of all joints over their stiffness [s]

    def links(self, step: float) -> Links:
        """The links for the kernels, with the inertia that keeps a time step [s] stable."""
        start = np.array([body.joints.start for body in self.bodies] + [len(self.mass)])
        inertia = self.inertia(step)
        share = GIVEN_SHARE if step <= TRUE_STEP else 0.0
        given = share * (inertia - self.inertia(0.0))
        return Links(start, self.offset, self.center, inertia, self.mass, given)

    def springs(self) -> Springs:
        """The joints' springs for the kernels."""
        damping = self.damping_time * self.stiffness
        rest = np.ascontiguousarray(self.rest)
        return Springs(rest, self.stiffness, self.stretching, damping)

    def inertia(self, step: float) -> Array:
        """Principal inertia (n, 3) [kg m2] of the links as boxes, plus the rotary inertia that
        keeps a time step [s] stable.

        PyBullet's contact solver sees links without their springs. So each link gets an additional
        c*(step**2*k + step*d), with c = 0.2 at 1 ms and proportional to the step: contacts meet
        heavy links, and statics are unchanged. Up to TRUE_STEP, chains that touch nothing and are
        not fast get most of it back in motion (see `joint_springs`); at 5 ms clashes and blows
        diverged with that, so there all motion is slower. Tips, whose stiffness tends to zero, get
        at least TIP_SHARE of the chain's median: with less, grasps that jam a fingertip between
        table and object diverged. No axis gets less than bending: otherwise hands that are softer
        sideways diverged when they hit the table hard.
        """
        box = link_inertia(self.size, self.mass)
        stiffness = self.stiffness.copy()
        for joints in self.chain_joints.values():
            own = stiffness[joints]
            own[:-1] = np.maximum(own[:-1], own[1:])
            np.maximum(own, TIP_SHARE * np.median(own[:, 1]), out=own)
            np.maximum(own, own[:, 1:2], out=own)
        share = ADDED_INERTIA * step / 1e-3
        return box + share * (step**2 + step * self.damping_time) * stiffness


def build_layout(description: HandDescription, segments: int, model: Model) -> HandLayout:
    """Discretise every chain of a hand into `segments` segments per actuator and arrange the
    joints.

    Raises ValueError if a serial body would have more joints than PyBullet can report.
    """
    description = altered(description, model.effects)
    models = {chain.name: discretise(chain, segments, model) for chain in description.chains}
    bodies, chain_joints, count = [], {}, 0
    for chains in serial_chains(description):
        start = count
        for name in chains:
            chain_joints[name] = slice(count, count + len(models[name].segments.mass))
            count = chain_joints[name].stop
        if count - start > MAX_SPHERICAL_JOINTS:
            raise ValueError(
                f"segments of {' + '.join(chains)}: expected at most {MAX_SPHERICAL_JOINTS} "
                f"joints in one body, got {count - start}; take fewer segments"
            )
        mount, joints = description.chain(chains[0]).mount, slice(start, count)
        place = np.asarray(mount.position)
        bodies.append(Body(chains[0], place, mount.quaternion, joints, chains))
    cut = {name: chain_model.segments for name, chain_model in models.items()}
    placed = [mounted(description, cut, name) for name in chain_joints]

    def rows(key: str) -> Array:
        return np.concatenate([getattr(models[name].segments, key) for name in chain_joints])

    return HandLayout(
        description,
        segments,
        models,
        tuple(bodies),
        chain_joints,
        {name: np.asarray(models[name].segments.tip_offset) for name in models},
        tuple(
            f"{name}_{i}"
            for name, joints in chain_joints.items()
            for i in range(joints.stop - joints.start)
        ),
        np.concatenate([offset for offset, _ in placed]),
        np.concatenate([rest for _, rest in placed]),
        rows("stiffness"),
        rows("stretching"),
        np.maximum(rows("body_size"), [SMALLEST_EDGE, SMALLEST_EDGE, 0.0]),
        rows("body_center"),
        rows("mass"),
        damping_time(model.effects),
    )
