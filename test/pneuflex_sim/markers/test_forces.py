"""Lines and arrows add up to the forces they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from pneuflex_sim.pictures.surfaces import (
    METRES_PER_NEWTON,
    contact_lines,
    total_arrow,
    total_force,
)
from pneuflex_sim.scene.contacts import Contact

CONTACTS = [
    Contact("index", "index_4", "object", (0.0, 0.0, 0.1), (1.0, 0.0, 0.0), 3.0),
    Contact("index", "index_3", "object", (0.0, 0.4, 0.1), (0.0, -1.0, 0.0), 1.0),
]


def test_lines_begin_at_the_contacts_and_are_as_long_as_their_forces():
    lines = contact_lines(CONTACTS)
    np.testing.assert_allclose(lines[:, 0], [c.position for c in CONTACTS])
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    np.testing.assert_allclose(length, [3 * METRES_PER_NEWTON, METRES_PER_NEWTON])


def test_the_arrow_of_a_pair_is_the_vector_sum_at_the_weighted_place():
    start, end = total_arrow(CONTACTS)
    np.testing.assert_allclose(start, [0.0, 0.1, 0.1])
    np.testing.assert_allclose((end - start) / METRES_PER_NEWTON, [3.0, -1.0, 0.0])


def test_friction_turns_the_lines_and_the_arrow():
    rubbing = [replace(CONTACTS[0], friction=(0.0, 0.0, -4.0))]
    for start, end in (contact_lines(rubbing)[0], total_arrow(rubbing)):
        np.testing.assert_allclose((end - start) / METRES_PER_NEWTON, [3.0, 0.0, -4.0])
    assert total_force(rubbing) == 3.0  # stays what presses


def test_the_arrow_of_a_lying_object_is_its_weight_on_the_table(simulate):
    simulation = simulate(object="tape_dispenser", step=0.002)
    simulation.command_wrist(np.array([0.0, 0.0, 0.5]), np.array([0.0, 0.0, 0.0, 1.0]))
    for _ in range(300):
        simulation.step()
    contacts = simulation.object_contacts()
    start, end = total_arrow(contacts)
    weight = simulation.object_mass * 9.81
    assert (end - start)[2] / METRES_PER_NEWTON == pytest.approx(-weight, rel=0.02)
    assert total_force(contacts) == pytest.approx(weight, rel=0.02)
    place, _ = simulation.object_pose()
    np.testing.assert_allclose(start[:2], place[:2], atol=0.003)
