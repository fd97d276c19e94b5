"""A Gymnasium environment in which a soft hand learns to grasp; importing it registers
`softhand/Grasp-v0`.
"""

import gymnasium

from softhand_gym.environment import GraspEnv
from softhand_gym.randomisation import Randomisation

ENVIRONMENT_ID = "softhand/Grasp-v0"

gymnasium.register(
    ENVIRONMENT_ID,
    entry_point="softhand_gym.environment:GraspEnv",
    vector_entry_point="softhand_gym.processes:in_processes",
)

__all__ = ["ENVIRONMENT_ID", "GraspEnv", "Randomisation"]
