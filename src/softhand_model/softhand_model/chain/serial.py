"""Chains in series: a chain that is mounted on another one continues it (the thumb on the palm)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import compose, rotate
from softhand_model.chain.segments import SegmentChain
from softhand_model.hand.hand import WRIST, HandDescription


def serial_chains(description: HandDescription) -> list[tuple[str, ...]]:
    """Names of the chains in series, each list from the wrist outwards.

    Raises ValueError if two chains are mounted on the tip of one.

    >>> from softhand_model.hand.hand import load_hand
    >>> serial_chains(load_hand("rbo_hand_2"))[-2:]
    [('index',), ('palm', 'thumb')]
    """
    serial: dict[str, list[str]] = {}
    root: dict[str, str] = {}
    for chain in description.chains:
        parent = chain.mount.parent
        root[chain.name] = chain.name if parent == WRIST else root[parent]
        serial.setdefault(root[chain.name], []).append(chain.name)
        if parent != WRIST and serial[root[parent]][-2] != parent:
            raise ValueError(
                f"mount of {chain.name}: expected a parent that carries no other chain, got "
                f"{parent}, which carries one"
            )
    return [tuple(names) for names in serial.values()]


def mounted(
    description: HandDescription, segments: Mapping[str, SegmentChain], name: str
) -> tuple[Array, Array]:
    """Joint offsets (n, 3) [m] and rest orientations (n, 4) of the chain `name`; those of the first
    joint include the mount on the parent chain.
    """
    own, mount = segments[name], description.chain(name).mount
    offset, rest = np.array(own.offset, float), np.array(own.rest, float)
    if mount.parent != WRIST:
        tip = segments[mount.parent].tip_offset
        offset[0] = tip + mount.position + rotate(mount.quaternion, offset[0])
        rest[0] = compose(mount.quaternion, rest[0])
    return offset, rest
