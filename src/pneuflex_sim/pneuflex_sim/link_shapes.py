"""Collision shapes of the links in PyBullet: pieces that follow the outline, or boxes."""

from __future__ import annotations

import pybullet

from pneuflex_sim.layout import Body, HandLayout
from pneuflex_sim.pieces import MARGIN, chain_pieces

PIECES, BOXES = "pieces", "boxes"
KINDS = (PIECES, BOXES)


def check_kind(kind: str) -> None:
    """Raise ValueError for anything but a kind of collision shapes."""
    if kind not in KINDS:
        raise ValueError(f"collision: expected one of {', '.join(KINDS)}, got {kind!r}")


def link_shapes(layout: HandLayout, body: Body, kind: str, client: int) -> list[int]:
    """Create the collision shape of every link of a body; their PyBullet ids.

    Each is centred where the link's mass is: PyBullet then needs no compound around it.
    """
    return _boxes(layout, body, client) if kind == BOXES else _pieces(layout, body, client)


def _boxes(layout: HandLayout, body: Body, client: int) -> list[int]:
    joints = body.joints
    return [
        pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=(size / 2).tolist(),
            collisionFramePosition=center.tolist(),
            physicsClientId=client,
        )
        for size, center in zip(layout.size[joints], layout.center[joints], strict=True)
    ]


def _pieces(layout: HandLayout, body: Body, client: int) -> list[int]:
    """Hulls; the engine's own margin around them is that of `pieces` (see `set_margin`)."""
    pieces = [
        piece
        for name in body.chains
        for piece in chain_pieces(layout.models[name].description, layout.segments)
    ]
    return [
        pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=(piece - center).tolist(),
            collisionFramePosition=center.tolist(),
            physicsClientId=client,
        )
        for piece, center in zip(pieces, layout.center[body.joints], strict=True)
    ]


def set_margin(body: int, link: int, kind: str, client: int) -> None:
    """Dilate a link's piece by the margin it was eroded by; boxes hold theirs within."""
    if kind == PIECES:
        pybullet.changeDynamics(body, link, collisionMargin=MARGIN, physicsClientId=client)
