"""Ranges of the sizes of a soft hand, so that a value in other units is refused on loading.

The ranges are wider than any pneumatic hand needs, from fingers of a few millimetres to arms of two
metres, from gels to stiff polyurethane. Most span less than a thousand times or end where the same
number in mm, kPa, g or ml begins: P10's 90 mm, 67 kPa, 15 g and 0.94 ml are all outside.
"""

import math

from softhand_common.documents.yaml_document import Bounds

LENGTH = Bounds(0.002, 2.0, "m")  # along an actuator, a strut or a sheet; as of meshes to grasp
SECTION_SIZE = Bounds(0.0003, 0.3, "m")  # height and width; 0.3 is also the smallest in mm
CIRCUMFERENCE = Bounds(0.001, 1.0, "m")
WALL_THICKNESS = Bounds(2e-5, 0.05, "m")  # from a balloon's skin on
SIDE_WALL_THICKNESS = Bounds(0.0, 0.05, "m")  # 0: bellows and pouches have none
THICKNESS = Bounds(2e-5, 0.05, "m")  # of struts and sheets
BREADTH = Bounds(0.001, 1.0, "m")  # of struts and sheets
PLATE_SIZE = Bounds(0.0005, 1.0, "m")
POSITION_RANGE = Bounds(-2.0, 2.0, "m")
ANGLE_RANGE = Bounds(-2.0 * math.pi, 2.0 * math.pi, "rad")
SHEAR_MODULUS = Bounds(1e3, 1e8, "Pa")  # a gel: 1 kPa; Dragon Skin: 50 to 200 kPa; PUR: 30 MPa
YOUNGS_MODULUS = Bounds(5e3, 1e12, "Pa")  # of the same rubbers, plastics and metals
LIMIT_PRESSURE = Bounds(1e3, 1e7, "Pa")  # actuators of 1 kPa are pouches, of 5 MPa hydraulic
SUPPLY_VOLUME = Bounds(0.0, 1e-3, "m3")  # 0: nothing is connected; 1 l is 80 m of a 4 mm tube
DENSITY = Bounds(100.0, 2e4, "kg/m3")  # foam to metal
HAND_MASS = Bounds(1e-3, 20.0, "kg")

FLAT_PART = {  # a strut or a sheet
    "length": LENGTH,
    "width": BREADTH,
    "thickness": THICKNESS,
    "modulus": YOUNGS_MODULUS,
    "density": DENSITY,
}
