"""The simulated pneumatic box: compressor, valves, chokes, tubes, sensors and their faults."""

from softhand_model.pneumatics.leaks_and_faults import Faults
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant
from softhand_model.pneumatics.valves import CommandWatch

__all__ = ["CommandWatch", "Faults", "PneumaticPlant", "Pneumatics", "load_pneumatics"]
