"""The palm's sheet (7.2, 7.3): bent as in the hand, and flat for its tray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from softhand_design.kit.frames import Array, after, pose, turned
from softhand_design.kit.solids import Solid, meets
from softhand_design.mould.plan import MILLI
from softhand_model.hand.palm_sheet import PalmSheet

LIFT_STEPS, FARTHEST_LIFT = (
    (0.5, 0.02),
    60.0,
)  # by which it is lifted, coarse and fine, and at most [mm]
ARC_POINTS = 97
BELOW_SHEET = 300.0  # below the sheet [mm]
ARCH_IN_SHEET = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Bent:
    """The bent sheet in the wrist frame [mm], the room under it, the way (3,) it rises, and how far
    [mm] it was lifted.
    """

    solid: Solid
    under: Solid
    rise: Array
    lift: float


def bend(sheet: PalmSheet, below: Sequence[Solid]) -> Bent:
    """The sheet where the hand's file has it, or lifted until it only touches the solids `below`.

    Raises ValueError where no lift clears it.
    """
    frame = turned(sheet.rpy, sheet.position)
    rise = frame[:, 0]
    band, under = _solid(sheet, False), _solid(sheet, True)

    def at(lift: float) -> Array:
        return after(frame, pose(np.eye(3), np.array([lift, 0.0, 0.0])))

    first = 0.0
    for step in LIFT_STEPS:
        for lift in np.arange(first, FARTHEST_LIFT, step):
            if not meets(band.transform(at(lift)), below):
                break
        else:
            raise ValueError(
                "sheet: expected a place clear of the actuators, where the hand's file has it or "
                f"up to {FARTHEST_LIFT:g} mm above, got overlaps at each; move the sheet, or make "
                "it smaller"
            )
        first = max(0.0, float(lift) - step)
    return Bent(band.transform(at(lift)), under.transform(at(lift)), rise, float(lift))


def _solid(sheet: PalmSheet, under: bool) -> Solid:
    """The arch in its frame, or all that lies below it."""
    angle = np.linspace(-0.5, 0.5, ARC_POINTS) * sheet.angle
    base, half = np.cos(sheet.angle / 2.0), sheet.thickness / 2.0

    def arc(radius: float) -> Array:
        high = radius * np.cos(angle) - sheet.radius * base
        return np.stack([radius * np.sin(angle), high], axis=1) / MILLI

    inner = arc(sheet.radius - half)
    if under:
        foot = [[inner[-1, 0], -BELOW_SHEET], [inner[0, 0], -BELOW_SHEET]]
        points = np.concatenate([inner, foot])
    else:
        points = np.concatenate([inner, arc(sheet.radius + half)[::-1]])
    area = np.sum(
        points[:, 0] * np.roll(points[:, 1], -1) - points[:, 1] * np.roll(points[:, 0], -1)
    )
    section = manifold3d.CrossSection([points if area > 0.0 else points[::-1]])
    width = sheet.width / MILLI
    solid = section.extrude(width).translate((0.0, 0.0, -width / 2.0))
    return solid.transform(pose(ARCH_IN_SHEET, np.zeros(3)))


def flat(sheet: PalmSheet) -> manifold3d.CrossSection:
    """Outline [mm] of the sheet before it is bent."""
    return manifold3d.CrossSection.square((sheet.length / MILLI, sheet.width / MILLI))


def volume(sheet: PalmSheet) -> float:
    """Volume [mm3] of the sheet, flat or bent: its middle surface keeps its length."""
    return sheet.length * sheet.width * sheet.thickness / MILLI**3
