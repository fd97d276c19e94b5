"""Saddles, which hold the base of a chain on the rounded end of the chain on which it is
mounted."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softhand_design.kit.frames import base_height, mount_poses
from softhand_design.kit.parameters import KitParameters
from softhand_design.kit.rubber import LAYER
from softhand_design.kit.scaffold import base_section
from softhand_design.kit.solids import Solid, box, hull_around, joined
from softhand_design.mould.plan import MILLI, nose_length
from softhand_model.hand.hand import WRIST, HandDescription

SMOOTHED_EDGE = 0.02  # [mm] below which edges are no form, and would not survive the file


def build_saddles(
    hand: HandDescription, rooms: Mapping[str, Solid], used: KitParameters
) -> dict[str, Solid]:
    """Saddles [mm] in the wrist frame by the chains that are mounted on others: prisms under their
    bases, with the others' ends, and space for adhesive around them, cut out.

    `rooms` [mm] are those of casts and layers in the wrist frame, by their names.
    """
    found, frames = {}, mount_poses(hand)
    for chain in hand.chains:
        if chain.mount.parent == WRIST:
            continue
        ends = hand.chain(chain.mount.parent).actuators
        depth = max(
            nose_length(float(part.width(part.length)) / MILLI / 2.0) for part in ends.values()
        )
        low, high = base_section(chain, used.layer)
        top = base_height(chain)
        prism = box([*low, top - depth], [*high, top]).transform(frames[chain.name])
        first, last = np.reshape(prism.bounding_box(), (2, 3))
        near = box(first - 2.0 * used.glue, last + 2.0 * used.glue)
        held = joined(
            hull_around(room ^ near, used.glue)
            for name, room in rooms.items()
            if name.removesuffix(LAYER) in ends
        )
        pieces = (prism - held).decompose()
        whole = max(pieces, key=lambda piece: piece.volume())
        found[chain.name] = whole.simplify(SMOOTHED_EDGE)
    return found
