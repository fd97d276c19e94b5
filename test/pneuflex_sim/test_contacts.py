"""Contacts: names, order and direction, against the weight they carry."""

import numpy as np
import pytest

from pneuflex_sim.contacts import by_pair, normal_forces


def test_the_table_carries_the_weight_of_the_object(simulate):
    simulation = simulate(step=0.002, object_mass_scale=1.5)
    for _ in range(200):
        simulation.step()
    contacts = simulation.contacts()
    assert set(by_pair(contacts)) == {"object/table"}
    assert normal_forces(contacts)["table"] == pytest.approx(1.5 * 0.106 * 9.80665, rel=0.01)
    for contact in contacts:
        assert contact.normal[2] == pytest.approx(-1)  # towards the first side, the table


def test_fingers_on_the_table_are_named_and_pushed_up(simulate):
    simulation = simulate(step=0.002, object_offset=(0.3, 0.3))
    simulation.command_wrist(np.array([0, 0, 0.125]), np.array([0.0, 0.92388, 0.0, 0.38268]))
    for _ in range(1000):
        simulation.step()
    pairs = by_pair(simulation.contacts())
    fingers = {f"{name}/table" for name in ("index", "middle", "ring", "little")}
    assert fingers <= set(pairs)
    pushed = sum(contact.force for pair in fingers for contact in pairs[pair])
    assert pushed == pytest.approx(simulation.wrist_wrench()[0][2], rel=0.05)
    for pair in fingers:
        assert all(c.normal[2] == pytest.approx(1) and c.segment for c in pairs[pair])


def test_the_objects_contacts_are_those_of_all_that_touch_it(simulate):
    simulation = simulate(step=0.002)
    simulation.command_wrist(np.array([-0.057, 0, 0.11]), np.array([0.0, 0.92388, 0.0, 0.38268]))
    for _ in range(800):
        simulation.set_air_masses(
            np.array([7.1e-5, 2.4e-5, 5.3e-5, 4.3e-5]) * min(1, simulation.time)
        )
        simulation.step()
    own = by_pair(simulation.object_contacts())
    everything = by_pair(simulation.contacts())
    assert own == {pair: found for pair, found in everything.items() if "object" in pair}
    assert any(pair.endswith("/object") for pair in own)
