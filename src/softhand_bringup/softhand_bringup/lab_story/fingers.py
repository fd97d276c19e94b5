"""The finger of a diagnosis by two models: without and with the diagnosed effects."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.pictures.render import HandState
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.documents.json_document import read_json
from softhand_common.documents.output_file import write_file
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import Node
from softhand_common.numerics.arrays import Array
from softhand_model.model_file import FORMAT as MODEL_FORMAT

DIAGNOSIS_FORMAT = "softhand-diagnosis/1"
PRESSURE_STEPS = 9  # from 0 to the largest measured pressure
FINGER_SEGMENTS, FINGER_STEP, REST_TIME = 10, 0.004, 0.8  # segments, physics step [s], settling [s]
PRESSURE_WINDOW = 0.2  # of the distance of two pressures, within which samples are averaged
FINGER_HAND: dict[str, Any] = {
    "format": "softhand-hand/1",
    "name": "measured_finger",
    "channels": ["a"],
    "mass": 0.2,
    "chains": {
        "finger": {
            "actuators": {"finger": {"type": "specimen", "channel": "a"}},
            "mount": {"parent": "wrist", "position": [0.0, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]},
        }
    },
    "tips": ["finger"],
}
SPECIMEN_KEYS = ("length", "height", "width", "wall", "side_wall", "shear_modulus")  # of a specimen


@dataclass(frozen=True)
class Bent:
    """A finger at rest at k pressures: its layout, states and tip angles (k,) [rad]."""

    layout: HandLayout
    states: list[HandState]
    angles: Array


@dataclass(frozen=True)
class Fingers:
    """Fingers without (`before`) and with (`after`) the diagnosed effects at gauge pressures (k,)
    [Pa], the mean measured angles (k,) [rad] there (NaN without samples), the names of the effects,
    and the length of the finger [m].
    """

    pressures: Array
    before: Bent
    after: Bent
    measured: Array
    effects: tuple[str, ...]
    length: float

    def measured_line(self, number: int) -> Array:
        """Center line (16, 3) [m] of a finger of constant curvature with the measured tip angle at
        the pressure of index `number`.
        """
        angle, share = self.measured[number], np.linspace(0.0, 1.0, 16)
        curved = share * (angle if abs(angle) > 1e-3 else 1e-3)
        radius = self.length / curved[-1]
        return radius * np.stack([1.0 - np.cos(curved), 0.0 * share, np.sin(curved)], axis=1)


def fingers_of(diagnosis: Path, measured: Path) -> Fingers:
    """Fingers from the JSON file of a diagnosis of free bending and from its measurement set.

    Raises ValueError for other files, and for effects that the simulator does not support.
    """
    from model_lab.measurements.load import load_measurements

    found = read_diagnosis(diagnosis)
    data = load_measurements(measured)
    if data.experiment != "free_bending":
        raise ValueError(f"{measured}: expected free_bending, got {data.experiment}")
    name = next(iter(data.specimens))
    runs = [run for run in data.runs if run.specimen == name]
    points = [(run.columns["pressure"], run.columns["tip_angle"]) for run in runs]
    pressure, angle = (np.concatenate(parts) for parts in zip(*points, strict=True))
    pressures = np.linspace(0.0, float(pressure.max()), PRESSURE_STEPS)
    effects = {each["name"]: each["parameters"] for each in found["effects"]}
    with tempfile.TemporaryDirectory() as folder:
        hand = _hand(data.specimens[name].values, float(pressure.max()), Path(folder))
        before = _bent(hand, _model({}, found, Path(folder) / "before.yaml"), pressures)
        after = _bent(hand, _model(effects, found, Path(folder) / "after.yaml"), pressures)
    length = float(data.specimens[name].values["length"])
    near = np.abs(pressure[:, None] - pressures) < PRESSURE_WINDOW * pressures[1]
    seen = [angle[near[:, k]].mean() if near[:, k].any() else np.nan for k in range(PRESSURE_STEPS)]
    return Fingers(pressures, before, after, np.array(seen), tuple(effects), length)


def read_diagnosis(path: Path) -> dict[str, Any]:
    """Effects and calibration in a file of `model-lab diagnose --json`, checked.

    Raises DocumentError for another file.
    """
    node = read_json(path, DIAGNOSIS_FORMAT)
    found = node.mapping()
    if "effects" not in found:
        raise node.error("the key effects", listed(found))
    for effect in found["effects"].items():
        of_effect = effect.mapping()
        for key in ("name", "parameters"):
            if key not in of_effect:
                raise effect.error(f"the key {key}", listed(of_effect))
        of_effect["name"].text()
        for estimate in of_effect["parameters"].mapping().values():
            if "value" not in estimate.mapping():
                raise estimate.error("the key value")
            estimate.mapping()["value"].number()
            if "interval" in estimate.mapping():
                for end in estimate.mapping()["interval"].items():
                    if end.value is not None:  # without bound
                        end.number()
    if "calibration" in found:
        _check_scales(found["calibration"])
    return {key: found[key].value for key in ("effects", "calibration") if key in found}


def _check_scales(calibration: Node) -> None:
    scales = calibration.mapping().get("modulus_scale")
    if scales is None:
        return
    for scale in scales.mapping().values() if isinstance(scales.value, dict) else [scales]:
        scale.positive()


def _hand(specimen: Mapping[str, Any], limit: float, folder: Path) -> str:
    """Write a hand file of a finger with the specimen's dimensions; returns its path."""
    kind = {key: np.asarray(specimen[key]).tolist() for key in SPECIMEN_KEYS}
    kind |= {"max_pressure": 1.05 * limit, "supply_volume": 0.0}
    path = folder / "finger.yaml"
    write_file(path, yaml.safe_dump({**FINGER_HAND, "types": {"specimen": kind}}))
    return str(path)


def _model(effects: dict[str, Any], found: dict[str, Any], path: Path) -> str:
    """Write a model file with these effects and the diagnosed scale, without gravity as in the
    measurements; returns its path.
    """
    entries = [
        {"name": name, "parameters": {key: each["value"] for key, each in values.items()}}
        for name, values in effects.items()
    ]
    content: dict[str, Any] = {"format": MODEL_FORMAT, "base": "pneuflex", "effects": entries}
    scales = found.get("calibration", {}).get("modulus_scale")
    if scales:
        first = next(iter(scales.values())) if isinstance(scales, dict) else scales
        content["calibration"] = {"modulus_scale": first}
    write_file(path, yaml.safe_dump(content))
    return str(path)


def _bent(hand: str, model: str, pressures: Array) -> Bent:
    """Simulate the finger at rest at each gauge pressure [Pa]."""
    config = SimulationConfig(
        hand=hand, scene="stand", model=model, step=FINGER_STEP, segments=FINGER_SEGMENTS
    )
    simulation = Simulation(config)
    try:
        states, angles = [], []
        air, ambient = simulation.air, simulation.ambient
        for pressure_abs in ambient + pressures:
            for _ in range(round(REST_TIME / FINGER_STEP)):
                held = np.array([pressure_abs]), ambient, simulation.temperature
                simulation.set_air_masses(air.masses(*held, simulation.bodies.rotations))
                simulation.step()
            pose = [np.array(part) for part in simulation.wrist_pose()]
            states.append(HandState(simulation.bodies.q.copy(), *pose))
            angles.append(simulation.tip_angles()["finger"])
        return Bent(simulation.shape.layout, states, np.array(angles))
    finally:
        simulation.close()
