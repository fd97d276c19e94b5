"""Lines and arrows of contact forces, in the world: along the normal, and friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.contacts import Contact

Array = NDArray[np.float64]

METRES_PER_NEWTON = 0.02  # length of lines and arrows


def contact_lines(contacts: list[Contact]) -> Array:
    """Start, the contact point, and end (k, 2, 3) [m] of a line a contact, along the force on the
    first side.

    >>> one = Contact("thumb", "thumb_4", "object", (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), 2.0)
    >>> contact_lines([one]).tolist()
    [[[0.0, 0.0, 0.1], [0.0, 0.0, 0.14]]]
    """
    start = np.array([contact.position for contact in contacts])
    return np.stack([start, start + METRES_PER_NEWTON * _forces(contacts)], axis=1)


def total_arrow(contacts: list[Contact]) -> Array:
    """Start and end (2, 3) [m] of the arrow of the summed force on the first side; it starts at the
    mean of the contact points, weighted by their normal forces.
    """
    weight = np.array([contact.force for contact in contacts])
    start = weight @ np.array([contact.position for contact in contacts]) / weight.sum()
    return np.stack([start, start + METRES_PER_NEWTON * _forces(contacts).sum(axis=0)])


def total_force(contacts: list[Contact]) -> float:
    """Sum of the normal forces [N]."""
    return sum(contact.force for contact in contacts)


def _forces(contacts: list[Contact]) -> Array:
    """Whole forces (k, 3) [N] on the first side."""
    return np.array(
        [contact.force * np.array(contact.normal) + contact.friction for contact in contacts]
    )
