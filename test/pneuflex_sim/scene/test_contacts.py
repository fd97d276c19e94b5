"""Contacts: names, order and direction, against the weight they carry."""

from math import radians, tan

import numpy as np
import pytest

from grasp_strategies.in_process_scene import build_scene
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.scene.contacts import OBJECT, by_pair
from pneuflex_sim.scene.scenes import SceneDescription, Wall
from softhand_trials.trials import TrialSettings, run_trial, started_scene

GRAVITY = np.array([0.0, 0.0, -9.80665])


def on_object(contacts):
    """Sum of the whole forces (3,) [N] on the object."""
    forces = [contact.force * np.array(contact.normal) + contact.friction for contact in contacts]
    sides = [1.0 if contact.first == OBJECT else -1.0 for contact in contacts]
    return np.array(sides) @ np.array(forces)


def on_slope(simulate, inclination):
    """A box on a wooden plane, put there from 2 mm above it, after two seconds."""
    wall = Wall("wood", -0.3, inclination)
    scene = SceneDescription("slope", None, wall, True, True, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    height = 0.3 * tan(radians(inclination)) + 0.002
    simulation = simulate(scene=scene, object="tape_dispenser", object_offset=(0, 0, height))
    for _ in range(2000):
        simulation.step()
    return simulation


@pytest.mark.parametrize("inclination", [5.0, 12.0])
def test_the_forces_on_a_box_at_rest_on_a_slope_are_its_weight_and_no_more(simulate, inclination):
    simulation = on_slope(simulate, inclination)
    contacts = simulation.object_contacts()
    weight = simulation.object_mass * GRAVITY
    np.testing.assert_allclose(on_object(contacts), -weight, atol=2e-3)
    # of which friction is what points down- or uphill
    rubbing = np.linalg.norm(np.sum([contact.friction for contact in contacts], axis=0))
    assert rubbing == pytest.approx(np.linalg.norm(weight) * np.sin(radians(inclination)), rel=0.02)


def test_the_table_carries_the_weight_of_the_object(simulate):
    simulation = simulate(step=0.002, object_mass_scale=1.5)
    for _ in range(200):
        simulation.step()
    contacts = simulation.contacts()
    assert set(by_pair(contacts)) == {"object/table"}
    carried = sum(contact.force for contact in contacts)
    assert carried == pytest.approx(1.5 * 0.106 * 9.80665, rel=0.01)
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


def test_the_forces_on_an_object_in_the_hand_are_its_weight_and_no_more():
    settings = TrialSettings(step=0.005)
    assert run_trial(1, settings).result.gripped
    simulation = started_scene(settings).scene.simulation
    contacts = simulation.object_contacts()
    assert OBJECT not in {contact.first for contact in contacts}  # the hand is
    weight = simulation.object_mass * GRAVITY
    np.testing.assert_allclose(on_object(contacts), -weight, atol=0.01)
    by_normals = sum(contact.force * np.array(contact.normal) for contact in contacts)
    rubbing = np.linalg.norm(by_normals + on_object(contacts))
    assert rubbing > 0.25 * np.linalg.norm(weight)  # the fingers rub, too


def test_what_touches_the_object_are_the_sides_of_its_contacts():
    scene = build_scene(hand="rbo_hand_2", object="tissue", step=0.005)
    strategy, seen = load_strategy("surface_constrained"), set()

    def compare(watch):
        contacts = scene.simulation.object_contacts()
        sides = {side for contact in contacts for side in (contact.first, contact.second)}
        assert watch.last.touching == sides - {OBJECT}
        seen.update(watch.last.touching)
        return ""

    Sequencer(scene, strategy, decided=compare).run()
    assert {"table"} < seen
    scene.close()
