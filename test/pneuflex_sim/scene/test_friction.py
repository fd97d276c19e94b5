"""The table of friction: symmetric pairs, and the product of two coefficients is the pair."""

from dataclasses import replace

import numpy as np
import pytest

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import ENGINES
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.objects import load_objects
from pneuflex_sim.scene.scenes import Table, load_scene, load_scenes
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.effects.hand_parts import Friction
from softhand_model.model_file import Model

OWN = """
format: pneuflex-friction/1
pairs:
  rubber: {steel: 0.45, rubber: 0.81}
  steel: {wood: 0.2}
"""


def test_pairs_are_found_in_either_order():
    table = load_friction()
    assert table.pair("wood", "latex") == table.pair("latex", "wood") == 0.7


def test_the_products_are_the_pairs(tmp_path):
    (tmp_path / "own.yaml").write_text(OWN)
    table = load_friction(tmp_path / "own.yaml")
    assert table.hand**2 == pytest.approx(0.81)
    steel = table.towards_hand("steel")
    assert table.hand * steel == pytest.approx(0.45)
    assert table.hand * table.towards_hand("wood") == pytest.approx(0.6)
    assert steel * table.towards_object("wood", "steel") == pytest.approx(0.2)


def test_pairs_of_ones_own_stand_on_top_of_the_shipped(tmp_path):
    (tmp_path / "own.yaml").write_text(OWN)
    own, shipped = load_friction(tmp_path / "own.yaml"), load_friction()
    assert shipped.pair("rubber", "rubber") == 1.0 and "steel" not in shipped.materials
    assert own.pair("wood", "latex") == shipped.pair("wood", "latex")


def test_the_shipped_table_has_every_pair_of_the_shipped_objects_and_scenes():
    table = load_friction()
    for scene in load_scenes().values():
        for part in filter(None, (scene.table, scene.wall)):
            assert table.pair("rubber", part.material) > 0
            for described in load_objects().values():
                assert table.pair(described.material, part.material) > 0
                assert table.pair(described.material, "rubber") > 0


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("rubber: {wood: 0.5}\n  wood: {rubber: 0.4}", "wood.rubber: expected every pair once"),
        (
            "rubber: {wood: 0}",
            "pairs.rubber.wood: expected a number at least 0.001 and at most 10",
        ),
        ("rubber: 0.5", "pairs.rubber: expected a mapping, got 0.5"),
        ("{}\nrubber_range: [0.5]", "rubber_range: expected 2 numbers"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused_with_its_place(tmp_path, text, named):
    path = tmp_path / "own.yaml"
    path.write_text(f"format: pneuflex-friction/1\npairs:\n  {text}\n")
    with pytest.raises(ValueError, match=f"own.yaml:.: .*{named}"):
        load_friction(path)


def test_a_pair_that_is_not_there_is_refused_with_the_materials():
    with pytest.raises(ValueError, match="of wood on steel in .*, got none; .* cardboard, .* wood"):
        load_friction().pair("wood", "steel")


def test_the_range_of_the_shipped_rubber_holds_its_values_and_stays_with_pairs_of_ones_own(
    tmp_path,
):
    (tmp_path / "own.yaml").write_text(OWN)
    low, high = load_friction().rubber_range
    assert low < 1.0 < high
    assert load_friction(tmp_path / "own.yaml").rubber_range == (low, high)


def test_the_friction_of_the_rubber_is_scaled_and_nothing_else(simulate):
    """As the engine has it: the product of what two bodies have."""
    simulation = simulate(object="tape_dispenser", segments=2, rubber_friction_scale=0.5)
    client, table = simulation.engine.world.client, load_friction()

    def of(body, link=-1):
        return pybullet.getDynamicsInfo(body, link, physicsClientId=client)[1]

    tables = sorted(of(body) for body in simulation.engine.fixed_names)
    finger, box = of(simulation.bodies.ids[0], 0), of(simulation.engine.object_id)
    assert finger * box == pytest.approx(0.5 * table.pair("rubber", "polyolefin"))
    products = sorted([0.5 * table.pair("rubber", "wood") / finger, 0.3 / box])
    assert tables == pytest.approx(products)
    assert simulation.friction.pair("rubber", "rubber") == table.pair("rubber", "rubber")


def slid_way(heading=0.0, **config):
    """How far a box slides on the table from 0.5 m/s on [m] at a heading [rad], under a hand high
    above.
    """
    simulation = Simulation(
        SimulationConfig(object="tape_dispenser", step=0.002, segments=2, **config)
    )
    client, body = simulation.engine.world.client, simulation.engine.object_id
    for _ in range(50):
        simulation.step()
    start = simulation.object_pose()[0]
    velocity = [0.5 * np.cos(heading), 0.5 * np.sin(heading), 0.0]
    pybullet.resetBaseVelocity(body, velocity, [0, 0, 0], physicsClientId=client)
    for _ in range(400):
        simulation.step()
    way = float(np.linalg.norm(simulation.object_pose()[0] - start))
    simulation.close()
    return way


def test_friction_of_all_pairs_is_scaled_together():
    usual, slippery = slid_way(), slid_way(friction_scale=0.5)
    assert slippery == pytest.approx(2 * usual, rel=0.03)  # v^2 / (2 mu g)
    assert usual > 0.02


@pytest.mark.parametrize("degrees", [0.0, 22.5, 45.0])
def test_a_box_slides_as_far_in_all_directions(degrees):
    """v^2/(2 mu g), with 0.3 of polyolefin on wood; a pyramid has 0.42 at 45 deg."""
    assert slid_way(np.radians(degrees)) == pytest.approx(0.25 / (2 * 0.3 * 9.80665), rel=0.04)


def test_scaled_friction_leaves_the_resistance_to_rolling_and_comes_back():
    simulation = Simulation(SimulationConfig(object="marker", scene="edge", segments=2))
    client, bodies = (
        simulation.engine.world.client,
        range(pybullet.getNumBodies(simulation.engine.world.client)),
    )

    def coefficients():
        found = [pybullet.getDynamicsInfo(body, -1, physicsClientId=client) for body in bodies]
        return np.array([(info[1], info[6]) for info in found])

    usual = coefficients()
    simulation.place_object((0.0, 0.0), 1.0, friction_scale=1.21)
    assert coefficients() == pytest.approx(usual * (1.1, 1 / 1.1))
    assert usual[:, 1].max() > 0
    simulation.place_object((0.0, 0.0), 1.0)
    assert np.array_equal(coefficients(), usual)
    simulation.close()


def crept(simulation, share):
    """How far [m] a box creeps within 0.3 s when it is pushed by a share [-] of its weight."""
    simulation.reset()
    for _ in range(50):
        simulation.step()
    start = simulation.object_pose()[0]
    for _ in range(150):
        simulation.push_object(np.array([share * 9.80665 * simulation.object_mass, 0.0, 0.0]))
        simulation.step()
    return float(np.linalg.norm((simulation.object_pose()[0] - start)[:2]))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("table", "factor"), [("rubber", 0.7), ("rubber", 1.4), ("wood", 0.7)])
def test_a_box_slides_on_rubber_at_mu_m_g_with_the_friction_of_the_model(
    simulate, engine, table, factor
):
    """On wood as without the effect, which is of the rubber alone."""
    scene = replace(load_scene("table"), table=Table(table))
    model = Model(effects=(Friction(factor=factor),))
    simulation = simulate(
        object="tape_dispenser",
        object_offset=(0.0, 1.0),
        step=0.002,
        segments=2,
        scene=scene,
        model=model,
        engine=engine,
    )
    expected = load_friction().pair("polyolefin", table) * (factor if table == "rubber" else 1.0)
    assert crept(simulation, 0.95 * expected) < 1e-3
    slid = 0.5 * 0.1 * expected * 9.80665 * 0.3**2  # (1.1 - 1) mu g t^2/2
    assert crept(simulation, 1.1 * expected) == pytest.approx(slid, rel=0.1)
