"""The pretended pneumatic box: valves, chokes, tubes, supply and sensors of the bench."""

from softhand_model.pneumatics.command_watch import CommandWatch
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant

__all__ = ["CommandWatch", "PneumaticPlant", "Pneumatics", "load_pneumatics"]
