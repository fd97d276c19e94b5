"""Springs of a chain at many samples and trial values, with what the structure's effects do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softhand_model.effects.stages import StructureEffect
from softhand_model.joint_springs import Factor, JointSprings, springs_of
from softhand_model.segments import SegmentChain

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def chain_springs(
    chain: SegmentChain, modulus: Array, rest: Array, effects: Sequence[StructureEffect]
) -> JointSprings:
    """Springs at the points lane*samples + sample: those of the chain, and what effects do.

    modulus (lanes, samples): shear modulus over that of the chain; rest (lanes, samples, joints or
    1) [rad]: free angles.
    """
    lanes, samples = modulus.shape
    joints = len(chain.mass)
    angles = np.broadcast_to(rest, (lanes, samples, joints)).reshape(lanes * samples, joints)
    return replace(
        springs_of(chain, np.ascontiguousarray(angles.T), modulus.reshape(-1)),
        coupling=_coupling(effects, lanes, samples),
        factor=_factor(effects, samples),
    )


def _coupling(effects: Sequence[StructureEffect], lanes: int, samples: int) -> Array | None:
    """Coupling (points,) of lateral bending and twist over B [-]; none without such an effect."""
    coupled = _that_have(effects, "bend_twist_coupling")
    if not coupled:
        return None
    total = np.zeros(lanes)
    for effect in coupled:
        total = total + np.ravel(effect.bend_twist_coupling())
    return np.repeat(total, samples)


def _factor(effects: Sequence[StructureEffect], samples: int) -> Factor | None:
    """Factor on the stiffness in bending, each point a lane of its own to the effects."""
    scaling = _that_have(effects, "stiffness_factor")
    if not scaling:
        return None

    at_points: tuple[Indices | None, list[StructureEffect]] = None, []

    def factor(bend: Array, rest: Array, points: Indices) -> Array:
        nonlocal at_points
        if at_points[0] is not points:  # which stay for many calls
            at_points = points, [_at_points(effect, points // samples) for effect in scaling]
        shape = (len(points), 1, 1)
        total = np.ones(shape)
        for effect in at_points[1]:
            total = total * effect.stiffness_factor(bend.reshape(shape), rest.reshape(shape))
        return total[:, 0, 0]

    return factor


def _at_points(effect: StructureEffect, lanes: Indices) -> StructureEffect:
    """The effect with the values of the lanes to which points belong, each a lane of its own."""
    return type(effect).in_lanes({key: _of(value, lanes) for key, value in effect.values.items()})


def _of(value: float | Array, lane: Indices) -> Array:
    """Values of a parameter in the lanes of points."""
    known = np.ravel(value)
    return known[lane] if known.size > 1 else np.full(len(lane), known[0])


def _that_have(effects: Sequence[StructureEffect], method: str) -> list[StructureEffect]:
    base = getattr(StructureEffect, method)
    return [effect for effect in effects if getattr(type(effect), method) is not base]
