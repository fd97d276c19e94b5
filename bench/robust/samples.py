"""Sound files of formats of which none is shipped that holds every key."""

OBJECT = """format: pneuflex-object/1
name: cup
shape: sheet
size: [0.15, 0.15, 0.0002]
strips: 5
contact_thickness: 0.002
hinge_friction: 2.0e-5
mass: 0.001
material: pet_fibre
rpy: [0, 0, 1.57]
note: text
"""
SCENE = """format: pneuflex-scene/1
object: true
wrist: compliant
wrist_position: [0.0, 0.0, 0.3]
wrist_rpy: [0.0, 0.1, 0.0]
table: {material: wood, edge: 0.2, rolling_resistance: 0.0001}
wall: {material: paper, distance: 0.1, inclination: 70}
"""
MODEL = """format: softhand-model/1
base: pneuflex
calibration: {modulus_scale: {A: 1.03, B: 0.98}}
springs: {bending: curvature, lateral: section, twist: 0.5}
effects:
- {name: gravity, parameters: {mass_scale: 1.0}, std: {mass_scale: 0.1}}
- {name: hysteresis, parameters: {relative_pressure: 0.1, stretch_scale: 0.2}}
"""
BAG_SET = """format: softhand-measurement/1
experiment: free_bending
specimens: {thin: {length: 0.09, height: 0.02, width: 0.02, wall: 0.0025, side_wall: 0.0025}}
runs:
  one:
    specimen: thin
    bag: bag
    topics:
      pressure: {topic: /state, field: 'effort[a]', unit: Pa}
      tip_angle: {topic: /tips, field: 'position[a]', unit: rad}
"""
