"""The simulator without ROS, and what it is told to simulate."""

from pneuflex_sim.simulation.config import SimulationConfig
from pneuflex_sim.simulation.simulation import Simulation

__all__ = ["Simulation", "SimulationConfig"]
