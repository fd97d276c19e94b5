"""Contact points with the names of the bodies that touch."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from pneuflex_sim.bullet import pybullet

OBJECT = "object"


@dataclass(frozen=True)
class Contact:
    """One contact point.

    Attributes:
        first, second: names of both sides.
        segment: joint name of the first side; empty for anything but a chain of the hand.
        position: (3,) [m] in the world.
        normal: (3,), towards the first side.
        force: along the normal [N].
        friction: (3,) [N] on the first side.
    """

    first: str
    segment: str
    second: str
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    force: float
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)


class ContactNames:
    """Names of PyBullet bodies and links: a chain of the hand, `object`, or a part of the scene."""

    def __init__(
        self, bodies: dict[int, str], links: dict[tuple[int, int], tuple[str, str]], client: int
    ) -> None:
        self._bodies, self._links, self._client = bodies, links, client

    def name(self, body: int, link: int) -> tuple[str, str]:
        """Return (name, segment) of a link; the segment is "" unless the link belongs to a
        chain.
        """
        return self._links.get((body, link)) or (self._bodies[body], "")

    def contacts(self, body: int | None = None) -> list[Contact]:
        """Contact points that carry a force, of one body or of all; only pairs with a positive
        normal force.

        The first side is a chain of the hand if there is one, else the body that the object
        touches.
        """
        # asked for one body, PyBullet may swap the sides, and then leaves friction as it was
        points = pybullet.getContactPoints(physicsClientId=self._client)
        found = [
            self._contact(point)
            for point in points
            if (point[9] > 0 or point[10] or point[12]) and (body is None or body in point[1:3])
        ]
        # the solver's last steps may take all of a point's normal force and leave its friction
        pressing = {(contact.first, contact.second) for contact in found if contact.force > 0}
        return [contact for contact in found if (contact.first, contact.second) in pressing]

    def touching(self, body: int) -> frozenset[str]:
        """Names of the bodies that press on a body. Takes a fifth of the time of `contacts`, which
        also has places and forces.
        """
        points = pybullet.getContactPoints(physicsClientId=self._client)
        pressing = {
            point[2:5:2] if point[1] == body else point[1:4:2]
            for point in points
            if point[9] > 0 and body in point[1:3]
        }
        return frozenset(self.name(*side)[0] for side in pressing) - {OBJECT}

    def gaps(self, body: int, other: int, reach: float) -> list[tuple[str, float]]:
        """Names of the parts of a body that are within a reach [m] of the body `other`, each with
        its distance [m], below zero where they overlap.
        """
        points = pybullet.getClosestPoints(body, other, reach, physicsClientId=self._client)
        return [(self.name(body, point[3])[0], point[8]) for point in points]

    def _contact(self, point: tuple) -> Contact:
        (first, segment), (second, other) = self.name(*point[1:4:2]), self.name(*point[2:5:2])
        position, (x, y, z) = point[5], point[7]  # on the first body, and towards it
        along, (ax, ay, az), across, (bx, by, bz) = point[10:14]
        fx, fy, fz = along * ax + across * bx, along * ay + across * by, along * az + across * bz
        if first == OBJECT or (other and not segment):
            first, segment, second = second, other, first
            position, x, y, z, fx, fy, fz = point[6], -x, -y, -z, -fx, -fy, -fz
        return Contact(first, segment, second, position, (x, y, z), point[9], (fx, fy, fz))


def by_pair(contacts: list[Contact]) -> dict[str, list[Contact]]:
    """Contacts by their pair of names, `first/second`; the hand stands first, and the object before
    the scene.
    """
    pairs: dict[str, list[Contact]] = defaultdict(list)
    for contact in contacts:
        names = (contact.first, contact.second)
        pairs["/".join(names if contact.segment else names[::-1])].append(contact)
    return dict(pairs)
