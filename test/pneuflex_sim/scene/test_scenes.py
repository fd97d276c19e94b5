"""Scenes as data: names, files of one's own, the wall's inclination, and what is refused."""

import math

import pytest

from pneuflex_sim.scene.scenes import load_scene, load_scenes
from pneuflex_sim.simulation import Simulation, SimulationConfig

OWN = """
format: pneuflex-scene/1
table: {material: paper}
wall: {material: wood, distance: 0.2, inclination: 70}
object: true
wrist: compliant
wrist_position: [0, 0, 0.4]
wrist_rpy: [0, 2.356, 0]
"""


def test_the_names_there_are():
    assert list(load_scenes()) == ["table", "stand", "held", "press", "edge", "wall"]


def test_the_wall_leans_as_its_inclination_says():
    wall = load_scene("wall").inclined(60).wall
    assert wall.normal == pytest.approx((-math.sqrt(0.75), 0.0, 0.5))
    assert load_scene("wall").wall.normal == pytest.approx((-1.0, 0.0, 0.0))


def test_a_scene_of_ones_own_by_path(tmp_path):
    (tmp_path / "shelf.yaml").write_text(OWN)
    scene = load_scene(tmp_path / "shelf.yaml")
    assert (scene.name, scene.table.material, scene.wall.inclination) == ("shelf", "paper", 70.0)


def test_parameters_choose_scene_object_and_inclination(simulate):
    simulation = simulate(
        hand="single_finger", object="marker", scene="wall", wall_inclination=45.0, step=0.005
    )
    assert simulation.scene.wall.inclination == 45.0
    simulation.place_object((simulation.scene.wall.distance - 0.0030, 0.0), 1.0)  # 0.4 mm too far
    simulation.step()
    assert {contact.first for contact in simulation.object_contacts()} == {"table", "wall"}


def test_an_object_offset_is_where_a_reset_brings_it_back_to(simulate):
    simulation = simulate(
        hand="single_finger", object="sunglasses", object_offset=(0.02, -0.01), step=0.005
    )
    first = simulation.object_pose()
    simulation.place_object((0.05, 0.03), 2.0)
    assert simulation.object_pose()[0][:2] == pytest.approx([0.05, 0.03])
    for _ in range(10):
        simulation.step()
    simulation.reset()
    assert simulation.object_pose()[0][:2] == pytest.approx([0.05, 0.03])
    simulation.place_object((0.02, -0.01), 1.0)
    for before, now in zip(first, simulation.object_pose(), strict=True):
        assert now == pytest.approx(before)


@pytest.mark.parametrize("name", ["tissue", "water_balloon", "paper_cup"])
def test_a_snapshot_with_the_object_repeats_bit_for_bit(simulate, name):
    simulation = simulate(hand="single_finger", object=name, scene="edge", step=0.005)
    simulation.place_object((-0.03, 0.0, 0.02), 1.0)
    saved, ends = simulation.save(), []
    for _ in range(2):
        simulation.restore(saved)
        for _ in range(60):
            simulation.step()
        ends.append([*simulation.object_pose()[0], *simulation.object_pose()[1]])
    assert ends[0] == ends[1]


@pytest.mark.parametrize("part", ["table", "wall"])
def test_a_material_without_friction_is_refused_with_file_and_key(tmp_path, part):
    old = {"table": "paper", "wall": "wood"}[part]
    path = tmp_path / "own.yaml"
    path.write_text(OWN.replace(f"material: {old}", "material: butter"))
    named = rf"own.yaml:.: {part}.material: expected one of .*friction.yaml\), got 'butter'"
    with pytest.raises(ValueError, match=named):
        Simulation(SimulationConfig(hand="single_finger", scene=str(path)))


def test_materials_of_ones_own_come_with_their_friction(tmp_path, simulate):
    scene, pairs = tmp_path / "own.yaml", tmp_path / "pairs.yaml"
    scene.write_text(OWN.replace("paper", "butter").replace("wood", "butter"))
    pairs.write_text(
        "format: pneuflex-friction/1\npairs:\n  butter: {rubber: 0.1, polyolefin: 0.05}\n"
    )
    simulation = simulate(
        hand="single_finger", scene=str(scene), object="marker", friction=str(pairs), step=0.005
    )
    assert simulation.friction.pair("butter", simulation.object.material) == 0.05
    with pytest.raises(ValueError, match=r"(butter|cardboard) on (butter|cardboard).*pairs.yaml"):
        simulate(hand="single_finger", scene=str(scene), object="cylinder", friction=str(pairs))


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (
            "distance: 0.2",
            "distance: far",
            "own.yaml:.: wall.distance: expected a number from -10 to 10",
        ),
        ("inclination: 70", "inclination: 2", "wall.inclination: expected a number at least 5"),
        (
            "wrist: compliant",
            "wrist: soft",
            "own.yaml:.: wrist: expected one of compliant, rigid",
        ),
        ("object: true", "", "own.yaml:.: document: expected the key object"),
        ("{material: paper}", "{edge: 0.1}", "own.yaml:.: table: expected the key material"),
        ("format: pneuflex-scene/1", "", "own.yaml:.: document: expected the key `format`"),
    ],
)
def test_a_scene_that_cannot_be_used_is_refused_with_its_place(tmp_path, old, new, named):
    (tmp_path / "own.yaml").write_text(OWN.replace(old, new))
    with pytest.raises(ValueError, match=named):
        load_scene(tmp_path / "own.yaml")


@pytest.mark.parametrize(
    ("config", "named"),
    [
        ({"scene": "table", "wall_inclination": 60.0}, "expected a scene with a wall, got table"),
        ({"scene": "wall", "wall_inclination": 2.0}, "wall_inclination: expected 5 to 120 deg"),
    ],
)
def test_an_inclination_that_cannot_be_is_refused(config, named):
    with pytest.raises(ValueError, match=named):
        Simulation(SimulationConfig(hand="single_finger", **config))
