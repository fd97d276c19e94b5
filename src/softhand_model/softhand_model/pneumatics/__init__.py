"""The pretended pneumatic box: compressor, valves, chokes, tubes, sensors and their faults."""

from softhand_model.pneumatics.command_watch import CommandWatch
from softhand_model.pneumatics.faults import Faults
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant

__all__ = ["CommandWatch", "Faults", "PneumaticPlant", "Pneumatics", "load_pneumatics"]
