"""Sound files of formats of which none is shipped that holds every key."""

import json

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
OBJECT_OF_MESH = """format: pneuflex-object/1
shape: mesh
file: {file}
pieces: hull
mass: 0.1
material: pvc
"""
_TRIAL = {
    "key": "map/ball/0,0/1",
    "digest": "0b4c501399097531",
    "object": "ball",
    "cell": [0.0, 0.0],
    "replicate": 1,
    "settings": {"strategy": "surface_constrained", "step": 0.01, "options": ["slow"]},
    "placement": {"offset": [0.0, 0.001], "mass_scale": 1.1, "yaw": -0.1, "friction_scale": 0.9},
    "outcome": "gripped",
    "lift_height": 0.1,
    "slip": None,
    "phase": "",
    "cause": "",
    "failed_at": None,
    "wall_time": 1.0,
    "cpu_time": 0.5,
    "versions": {"code": "ed42ea049da4266d", "numpy": "2.4.6"},
}
_FAILED = {"outcome": "none", "cause": "missed", "phase": "close", "failed_at": 0.4}
_PLACES = [(x, y) for x in (0.0, 0.01) for y in (0.0, 0.01)]
_TRIALS = [
    _TRIAL | {"key": f"map/ball/{1e3 * x:g},{1e3 * y:g}/1", "cell": [x, y]} for x, y in _PLACES
]
_TRIALS[1] |= _FAILED
_TRIALS.append({**_TRIAL, "key": "map/cup/0,0/1", "object": "cup", "error": "RuntimeError: no"})
TRIALS = "".join(json.dumps(trial) + "\n" for trial in _TRIALS)
EVALUATIONS = "".join(
    json.dumps(
        {
            "key": f"bowl/{number:04d}",
            "digest": "16fd073dc6e4012f",
            "objective": "thesis.bowl:bowl",
            "values": {"x": 0.1 * number, "y": -0.2},
            "settings": {"draw": [1, 2]},
            "cost": 0.1 * number**2,
            "wall_time": 0.1,
            "cpu_time": 0.1,
            "versions": {"code": "ed42ea049da4266d"},
        }
    )
    + "\n"
    for number in range(3)
)
DIAGNOSIS = json.dumps(
    {
        "format": "softhand-diagnosis/1",
        "verdict": "explained",
        "effects": [{"name": "tube_lag", "parameters": {"time": {"value": 1, "interval": [0, 2]}}}],
        "calibration": {"modulus_scale": {"A": 1.03, "B": 0.98}},
    }
)
TRUTH = json.dumps(
    {
        "effects": [{"name": "tube_lag", "parameters": {"time": 0.1}}],
        "calibration": {"modulus_scale": {"A": 1.03}},
        "noise": 0.01,
        "seed": 3,
    }
)
