"""Judge of the Kapandji test: does the thumb's end touch a place of a finger (8.2.1, Fig. 8.7)?

The thesis shows the eight places in a picture, and a person judges. Places and limits here are our
choice after Kapandji, fixed before any search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grasp_strategies.in_process_scene import SkinContact, SkinPlace

THUMB = "thumb"
THUMB_TIP = 0.020  # [m] of the thumb's end count, on any side: it pinches with its back (7.3)
RADIUS = 0.008  # of a place [m], along the skin
OTHER_RADII = (0.005, 0.012)  # [m], reported beside it
FORCE = (0.05, 2.0)  # normal force of a touch [N]
SLOW = 0.05  # of all joints at rest [rad/s]


@dataclass(frozen=True)
class Target:
    """A place to touch: finger, share of its length, side (or `tip`)."""

    number: int
    finger: str
    share: float
    side: str

    def distance(self, place: SkinPlace) -> float:
        """How far [m] from it a place on its finger is, along the skin."""
        return place.distance(self.share, self.side)


TARGETS = (
    Target(1, "index", 0.50, "+y"),  # radial side of the middle third
    Target(2, "index", 0.83, "+y"),  # radial side of the end third
    Target(3, "index", 1.00, "tip"),
    Target(4, "middle", 1.00, "tip"),
    Target(5, "ring", 1.00, "tip"),
    Target(6, "little", 1.00, "tip"),
    Target(7, "little", 0.75, "pad"),
    Target(8, "little", 0.45, "pad"),
)


@dataclass(frozen=True)
class Snapshot:
    """State of a hand at an instant: contacts of its fingers with each other, and the speed of its
    fastest joint [rad/s].
    """

    contacts: Sequence[SkinContact]
    speed: float


@dataclass(frozen=True)
class Verdict:
    """Whether a place is touched, and if not, why; distance [m] along the skin of the nearest
    contact of the thumb's end with the finger (None: there is none), normal force [N] of those
    within the radius, other fingers that the thumb touches.
    """

    touched: bool
    reason: str
    distance: float | None
    force: float
    others: tuple[str, ...]


def judge(target: Target, closed: Snapshot, later: Snapshot, radius: float = RADIUS) -> Verdict:
    """Judge a posture from snapshots when the valves close and one second later.

    A place counts as touched when contacts between the thumb's last 20 mm and the target, within
    `radius` [m] of it, have a total normal force of 0.05 to 2 N in both snapshots, and the joints
    are at rest in the second.
    """
    near = _near(target, later, radius)
    force = sum(contact.force for contact, _ in near)
    reached = [distance for _, distance in _touches(target, later)]
    others = sorted({f for contact in later.contacts for f in _fingers(contact)} - {target.finger})
    return Verdict(
        not (reason := _reason(target, closed, later, radius, force)),
        reason,
        min(reached, default=None),
        force,
        tuple(others),
    )


def _reason(target: Target, closed: Snapshot, later: Snapshot, radius: float, force: float) -> str:
    """Why a place is not touched, in words; empty if it is."""
    if not _near(target, later, radius):
        return "not within the radius" if _touches(target, later) else "no contact"
    low, high = FORCE
    if not low <= force <= high:
        return f"force of {force:.3g} N"
    if not _near(target, closed, radius):
        return "not touched when the valves closed"
    return f"joints at {later.speed:.2g} rad/s" if later.speed > SLOW else ""


def _near(target: Target, seen: Snapshot, radius: float) -> list[tuple[SkinContact, float]]:
    return [found for found in _touches(target, seen) if found[1] <= radius]


def _touches(target: Target, seen: Snapshot) -> list[tuple[SkinContact, float]]:
    """Contacts of the thumb's end with the target's finger, and how far [m] from the target."""
    found = []
    for contact in seen.contacts:
        sides = {place.chain: place for place in contact.places}
        if sides.keys() == {THUMB, target.finger}:
            thumb = sides[THUMB]
            if thumb.along >= thumb.length - THUMB_TIP:
                found.append((contact, target.distance(sides[target.finger])))
    return found


def _fingers(contact: SkinContact) -> set[str]:
    """The finger that the thumb touches, if it is one of the two."""
    chains = {place.chain for place in contact.places}
    return chains - {THUMB} if THUMB in chains else set()
