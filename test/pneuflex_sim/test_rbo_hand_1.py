"""RBO Hand 1 at the pressure it grasps with, under the model file that is meant for it."""

import warnings

import numpy as np
import pytest

from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.dynamics.joint_springs import STOP_ANGLE
from thesis.chapter_3_and_5.stand import fill

GRASPING, RISE = 210e3, 0.8  # [Pa] of section 8.1.2, and [s] to get there


@pytest.mark.parametrize("step", [0.002, 0.005])
def test_empty_hand_curls_up_at_rest_without_a_joint_at_its_stop(step):
    config = SimulationConfig(
        hand="rbo_hand_1", scene="stand", model="rbo_hand_1", segments=10, step=step
    )
    simulation = Simulation(config)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a joint that pressure bends beyond its stop
        for k in range(round(2.5 * RISE / step)):
            fill(simulation, np.array([GRASPING * min(1.0, k * step / RISE)]))
            simulation.step()
    assert np.abs(simulation.bodies.rotations).max() < 0.6 * STOP_ANGLE
    assert np.abs(simulation.bodies.v).max() < 0.5
    assert simulation.stops.lowest > 250e3
    for turned in simulation.tip_angles().values():
        assert turned == pytest.approx(2.0 * 0.120 / 0.01742, rel=0.02)
    simulation.close()
