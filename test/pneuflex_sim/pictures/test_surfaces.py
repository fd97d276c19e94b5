"""Surfaces of a scene as triangles, and arrows of contact forces."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.pictures.object_surface import MOST_TRIANGLES, object_mesh
from pneuflex_sim.pictures.skin import HandSkin
from pneuflex_sim.pictures.surfaces import (
    METRES_PER_NEWTON,
    PRESSURE_LIMIT_COLOR,
    UNPRESSURIZED_COLOR,
    SceneSurfaces,
    contact_line,
    pressure_color,
    total_arrow,
    total_force,
)
from pneuflex_sim.scene.contacts import Contact
from pneuflex_sim.scene.mesh import tube, write_meshes
from pneuflex_sim.scene.objects import load_object, load_objects


def volume(corners):
    a, b, c = np.moveaxis(corners.reshape(-1, 3, 3), 1, 0)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


@pytest.fixture
def closing(simulate, mass_for_pressure):
    simulation = simulate(step=0.005)
    simulation.command_wrist(np.array([0.02, 0.03, 0.25]), np.array([0.0, 0.6, 0.0, 0.8]))
    masses = mass_for_pressure(simulation, [60e3, 0.0, 20e3, 20e3])
    for _ in range(100):
        simulation.set_air_masses(masses)
        simulation.step()
    return simulation


def test_actuators_are_where_the_fine_skin_is_and_as_large(closing):
    shown, fine = SceneSurfaces(closing).now(), HandSkin(closing.shape)
    position, orientation = closing.wrist_pose()
    assert orientation[1] > 0.3
    for name in closing.hand.actuator_names:
        corners, _ = shown[name]
        exact = fine.actuator(name, closing.bodies.q).moved(
            position, Rotation.from_quat(orientation).as_matrix()
        )
        assert volume(corners) == pytest.approx(exact.volume, rel=0.15)
        np.testing.assert_allclose(
            corners.mean(axis=0), exact.corners.mean(axis=(0, 1)), atol=0.003
        )
        for end in (np.min, np.max):
            np.testing.assert_allclose(end(corners, 0), end(exact.vertices, 0), atol=0.002)


def test_the_number_of_triangles_stays_however_the_hand_moves(closing):
    surfaces = SceneSurfaces(closing)
    before = {name: len(corners) for name, (corners, _) in surfaces.now().items()}
    closing.reset()
    after = {name: len(corners) for name, (corners, _) in surfaces.now().items()}
    assert before == after
    assert {"plate", "sheet", "index_strut", "object", "table"} < set(before)


def test_actuators_are_coloured_by_the_pressure_of_their_own_channel(closing):
    shown = SceneSurfaces(closing).now()
    colors = {name: shown[name][1] for name in closing.hand.actuator_names}
    share = closing.pressures() / closing.hand.max_pressures()
    redness = {name: UNPRESSURIZED_COLOR[1] - color[1] for name, color in colors.items()}
    for name, red in redness.items():
        expected = np.clip(share[closing.hand.channel_of(name)], 0, 1) * (
            UNPRESSURIZED_COLOR[1] - PRESSURE_LIMIT_COLOR[1]
        )
        assert red == pytest.approx(expected, abs=1e-5)
    assert np.ptp(list(redness.values())) > 0.1


def test_colours_end_at_no_pressure_and_at_the_limit():
    assert pressure_color(-0.3) == pressure_color(0.0) == UNPRESSURIZED_COLOR
    assert pressure_color(1.7) == pressure_color(1.0) == PRESSURE_LIMIT_COLOR


def test_the_object_is_shown_where_it_is(closing):
    corners, _ = SceneSurfaces(closing).now()["object"]
    place, turn = closing.object_pose()
    local = (corners - place) @ Rotation.from_quat(turn).as_matrix()
    np.testing.assert_allclose(np.abs(local).max(axis=0), closing.object.half_extents, atol=1e-6)


@pytest.mark.parametrize("name", sorted(load_objects()))
def test_surfaces_of_all_objects_are_closed_and_look_outwards(name):
    description = load_object(name)
    mesh = object_mesh(description)
    solid = description.geometry.solid
    if description.shape in ("cylinder", "sphere"):  # of flat faces, so a little smaller
        assert 0.95 * solid.volume < mesh.volume < solid.volume
    assert mesh.volume > 0


def test_a_mesh_of_many_triangles_is_shown_by_its_hull(tmp_path):
    height = np.linspace(-1.0, 1.0, 60)
    around = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    radius = 1.0 - 0.5 * (1.0 - height**2)  # waisted: its hull is larger
    rings = [
        np.column_stack([r * np.cos(around), r * np.sin(around), np.full(60, z)])
        for r, z in zip(radius, height, strict=True)
    ]
    path, fine = tmp_path / "waist.stl", tube(0.05 * np.array(rings))
    write_meshes(path, {"waist": fine})
    (tmp_path / "waist.yaml").write_text(
        "format: pneuflex-object/1\nshape: mesh\nfile: waist.stl\npieces: hull\nmass: 0.1\n"
        "material: wood\n"
    )
    mesh = object_mesh(load_object(tmp_path / "waist.yaml"))
    assert len(fine.indices) > 3 * MOST_TRIANGLES > len(mesh.indices)
    assert mesh.volume == pytest.approx(np.pi * 0.05**2 * 0.1, rel=0.01)


CONTACTS = [
    Contact("index", "index_4", "object", (0.0, 0.0, 0.1), (1.0, 0.0, 0.0), 3.0),
    Contact("index", "index_3", "object", (0.0, 0.4, 0.1), (0.0, -1.0, 0.0), 1.0),
]


def test_lines_begin_at_the_contacts_and_are_as_long_as_their_forces():
    lines = np.reshape([contact_line(contact) for contact in CONTACTS], (-1, 2, 3))
    np.testing.assert_allclose(lines[:, 0], [c.position for c in CONTACTS])
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    np.testing.assert_allclose(length, [3 * METRES_PER_NEWTON, METRES_PER_NEWTON])


def test_the_arrow_of_a_pair_is_the_vector_sum_at_the_weighted_place():
    start, end = total_arrow(CONTACTS)
    np.testing.assert_allclose(start, [0.0, 0.1, 0.1])
    np.testing.assert_allclose((end - start) / METRES_PER_NEWTON, [3.0, -1.0, 0.0])


def test_friction_turns_the_lines_and_the_arrow():
    rubbing = [replace(CONTACTS[0], friction=(0.0, 0.0, -4.0))]
    for start, end in (np.reshape(contact_line(rubbing[0]), (2, 3)), total_arrow(rubbing)):
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
