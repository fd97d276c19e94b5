"""The simulated hand at rest: an oracle for the statics of hands."""

from dataclasses import replace

import numpy as np

from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig


def held(model, rpy=(0.0, 0.0, 0.0), segments=5, hand="rbo_hand_2"):
    """A simulation of a hand that a rigid wrist holds in the air."""
    scene = replace(load_scene("stand"), wrist_rpy=rpy)
    return Simulation(SimulationConfig(hand=hand, scene=scene, model=model, segments=segments))


def settled_tips(simulation, pressures, longest=4.0, still=1e-6):
    """Fingertips (3,) [m] in the wrist frame, by name, when no joint turns faster than `still`
    [rad/s] under gauge pressures (channels,) [Pa] that stay.
    """
    pressures_abs = simulation.ambient + np.asarray(pressures, float)
    start = simulation.time
    while simulation.time - start < longest:
        for _ in range(100):
            rotations = simulation.bodies.rotations
            masses = simulation.air.masses(
                pressures_abs, simulation.ambient, simulation.temperature, rotations
            )
            simulation.set_air_masses(masses)
            simulation.step()
        if np.abs(simulation.bodies.v).max() < still:
            return {name: place for name, (place, _) in simulation.fingertips().items()}
    raise RuntimeError(f"the hand still moves after {longest:g} s")
