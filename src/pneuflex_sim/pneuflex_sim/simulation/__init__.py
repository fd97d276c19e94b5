"""The simulator without ROS, and its configuration."""

from pneuflex_sim.simulation.config import SimulationConfig
from pneuflex_sim.simulation.simulation import Simulation

__all__ = ["Simulation", "SimulationConfig"]
