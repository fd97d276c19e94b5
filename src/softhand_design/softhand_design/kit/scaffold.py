"""The scaffold (7.3): wrist plate, flexible struts, arms, and pads that actuators are bonded to.

The thesis shows it in pictures alone. Here the plate keeps its size and moves back until it clears
the actuators. Each chain on the wrist gets a pad under its base. A strut of the file's section
leads there, all of them as far behind the rubber as none meets anything; a base without strut is
held by an arm. Pads under the palm's sheet are raised to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softhand_design.kit.frames import Array, base_height, mount_poses
from softhand_design.kit.palm_sheet import Bent
from softhand_design.kit.parameters import KitParameters
from softhand_design.kit.solids import Solid, box, grown, joined, meets
from softhand_design.mould.plan import MILLI
from softhand_model.chain.segments import lateral_places
from softhand_model.hand.hand import WRIST, ChainDescription, HandDescription, Plate, Strut

PLACE_STEP, FARTHEST_PLACE = 0.5, 60.0  # in which places are tried, and how far [mm]
ARM_SUNK = 1.0  # of an arm in the plate, which joins both [mm]
SWEPT_WAY = 200.0  # past any sheet [mm]


@dataclass(frozen=True)
class Scaffold:
    """The scaffold in the frame of the wrist, lengths in mm.

    plate_moved, struts_moved: how far plate and struts lie behind their positions in the hand's
    file. free_lengths: of the struts, by the names of their chains.
    """

    solid: Solid
    plate_moved: float
    struts_moved: float
    free_lengths: dict[str, float]


def base_section(chain: ChainDescription, layer: float) -> tuple[Array, Array]:
    """Least and greatest x and y (2,) [mm] of a chain's base in its frame, with a layer [mm]."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for actuator, y in zip(chain.actuators.values(), lateral_places(chain), strict=True):
        height, width = float(actuator.height(0.0)), float(actuator.width(0.0))
        low = np.minimum(low, np.array([-height, y - width / 2.0]) / MILLI)
        high = np.maximum(high, np.array([0.0, y + width / 2.0]) / MILLI)
    return low, high + [layer, 0.0]


def plate_of(hand: HandDescription) -> Plate:
    """The plate of a hand; raises ValueError if it has none."""
    if hand.plate is None:
        raise ValueError(
            f"{hand.name}: plate: expected a palm plate in the hand's file, on which its parts are "
            "mounted, got none"
        )
    return hand.plate


class _Builder:
    """Plate, arms and struts, each clear of the rubber and of what was placed before."""

    def __init__(
        self,
        hand: HandDescription,
        rubber: Sequence[Solid],
        clear: Sequence[Solid],
        used: KitParameters,
    ) -> None:
        plate = plate_of(hand)
        self.used, self.frames = used, mount_poses(hand)
        self.rubber, self.kept_clear = rubber, clear
        half, middle = np.array(plate.size) / 2.0, np.array(plate.position)
        low, high = (middle - half) / MILLI, (middle + half) / MILLI
        for moved in np.arange(0.0, FARTHEST_PLACE, PLACE_STEP):
            shift = np.array([-moved, 0.0, 0.0])
            self.plate = box(low + shift, high + shift)
            # an actuator may stand on the plate
            if not meets(self.plate, rubber) and (
                not moved or not meets(self.plate, self.kept_clear)
            ):
                self.low, self.high, self.moved = low + shift, high + shift, float(moved)
                return
        raise ValueError(
            f"plate: it overlaps the actuators of {hand.name} in its place and everywhere up to "
            f"{FARTHEST_PLACE:g} mm behind it; make it smaller in the hand's file"
        )

    def pad(self, chain: ChainDescription, back: float | None = None) -> tuple[Array, Array]:
        """Least and greatest corner (3,) [mm] of a chain's pad in its frame, from x = `back`."""
        low, high = base_section(chain, self.used.layer)
        top = base_height(chain)
        least = low[0] if back is None else min(back, low[0])
        return np.array([least, low[1], top - self.used.pad]), np.array([*high, top])

    def to_plate(self, part: Solid) -> Solid:
        """The hull of a part in the wrist frame and of the plate's nearest patch."""
        points = np.asarray(part.to_mesh64().vert_properties)[:, :3]
        sunk = np.minimum(ARM_SUNK, (self.high - self.low) / 2.0)
        return Solid.hull_points(
            np.concatenate([points, np.clip(points, self.low + sunk, self.high - sunk)])
        )

    def arm(self, chain: ChainDescription, others: Sequence[Solid]) -> Solid:
        """Pad and arm of a chain without strut: straight to the plate, or around behind it."""
        frame, used = self.frames[chain.name], self.used
        low, high = self.pad(chain)
        pad = box(low, high).transform(frame)
        direct = self.to_plate(pad)
        if not meets(direct, [*self.rubber, *others]):
            return direct
        half = min(used.arm_width, high[1] - low[1]) / 2.0
        middle = (low[1] + high[1]) / 2.0
        for back in np.arange(low[0] - used.gap, low[0] - FARTHEST_PLACE, -PLACE_STEP):
            rim = box(
                [back - used.arm, middle - half, low[2]], [back, middle + half, high[2]]
            ).transform(frame)
            arm = self.to_plate(rim)
            if meets(arm, [*self.kept_clear, *others]):
                continue
            bridge = box(
                [back - used.arm, middle - half, low[2]], [high[0], middle + half, high[2]]
            )
            return pad + bridge.transform(frame) + arm
        raise ValueError(
            f"mount of {chain.name}: expected room for an arm of {used.arm:g} mm from its base to "
            "the plate, got none; move its mount in the hand's file"
        )

    def struts(
        self, chains: Sequence[tuple[ChainDescription, Strut]], others: Sequence[Solid]
    ) -> tuple[list[Solid], float]:
        """Struts with their pads, all as far [mm] behind the rubber's palm side."""
        clear = [grown(other, self.used.gap) for other in others]
        for back in np.arange(0.0, FARTHEST_PLACE, PLACE_STEP):
            made = [self._strut(chain, strut, -float(back)) for chain, strut in chains]
            if all(
                not meets(bar, [*self.kept_clear, *clear])
                and not meets(pad, [*self.rubber, *clear])
                for bar, pad in made
            ):
                return [bar + pad for bar, pad in made], float(back)
        names = ", ".join(chain.name for chain, _ in chains)
        raise ValueError(
            f"strut: expected room for the struts of {names} up to {FARTHEST_PLACE:g} mm behind "
            "the rubber, got none; make the struts thinner or narrower in the hand's file"
        )

    def _strut(self, chain: ChainDescription, strut: Strut, x: float) -> tuple[Solid, Solid]:
        """A strut with its root, and its pad."""
        frame = self.frames[chain.name]
        thick, wide = strut.thickness / MILLI / 2.0, strut.width / MILLI / 2.0
        low, high = self.pad(chain, x - thick)
        bar = box([x - thick, -wide, 0.0], [x + thick, wide, low[2]]).transform(frame)
        root = box([x - thick, -wide, 0.0], [x + thick, wide, ARM_SUNK]).transform(frame)
        return bar + self.to_plate(root), box(low, high).transform(frame)


def build_scaffold(
    hand: HandDescription,
    rubber: Sequence[Solid],
    clear: Sequence[Solid],
    bent: Bent | None,
    used: KitParameters,
) -> Scaffold:
    """The scaffold of a hand, in the wrist frame [mm]. Pads, which are bonded to the rubber, stay
    outside of `rubber`, the room that casts and layers take; all else stays outside of `clear`, the
    same room with a gap around it, if there is a place for it.

    Raises ValueError for a hand without plate, or where there is no room for plate, arm or strut.
    """
    made = _Builder(hand, rubber, clear, used)
    on_wrist = [chain for chain in hand.chains if chain.mount.parent == WRIST]
    stiff: list[Solid] = []
    for chain in on_wrist:
        if chain.strut is None:
            stiff.append(made.arm(chain, stiff))
    flexible = [(chain, chain.strut) for chain in on_wrist if chain.strut]
    struts, moved = made.struts(flexible, stiff) if flexible else ([], 0.0)
    raised = [_raised(made, chain, bent) for chain in on_wrist] if bent else []
    parts = [made.plate, *stiff, *struts, *(post for post in raised if post is not None)]
    solid = joined(parts)
    free = {c.name: base_height(c) - used.pad for c, _ in flexible}
    return Scaffold(solid, made.moved, moved, free)


def _raised(made: _Builder, chain: ChainDescription, bent: Bent) -> Solid | None:
    """The pad of a chain raised to the sheet above it, where nothing else is in between."""
    pad = box(*made.pad(chain)).transform(made.frames[chain.name])
    far = pad.translate(tuple(SWEPT_WAY * bent.rise))
    post = Solid.batch_hull([pad, far]) ^ bent.under
    return None if post.is_empty() or meets(post, made.rubber) else post
