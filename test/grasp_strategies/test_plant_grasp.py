"""A shipped grasp by the box's valves beside the same one by imposed air."""

import pytest
from plant_scene import PlantScene

from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.simulation import Simulation, SimulationConfig

LIFT, LOST = 0.175, 0.015  # of the wrist, and what the object may settle in the hand [m]


@pytest.mark.parametrize("seed", [0, 1])
def test_the_surface_constrained_grasp_is_firm_by_the_valves_too(seed):
    config = SimulationConfig(hand="rbo_hand_2", step=0.004, seed=seed, object_mass_scale=1.0)
    scene = PlantScene(Simulation(config))
    result = Sequencer(scene, load_strategy("surface_constrained")).run()
    scene.close()
    assert result.gripped, result.reason
    assert result.lift_height > LIFT - LOST
