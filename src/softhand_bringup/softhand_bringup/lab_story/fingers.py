"""Two fingers of a diagnosis: by the model before the effects that were named, and with them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from pneuflex_sim.hand.layout import HandLayout
from pneuflex_sim.pictures.render import HandState
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.model_file import FORMAT as MODEL_FORMAT

Array = NDArray[np.float64]

FORMAT = "softhand-diagnosis/1"
PRESSURES = 9  # steps up to the largest measured
SEGMENTS, STEP, REST = 10, 0.004, 0.8  # of the finger [s]
NEAR = 0.2  # of a step of pressure, within which samples count as measured there
HAND: dict[str, Any] = {
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
OWN = ("length", "height", "width", "wall", "side_wall", "shear_modulus")  # of a specimen


@dataclass(frozen=True)
class Bent:
    """A finger at rest at several pressures: its layout, states and tip angles (k,) [rad]."""

    layout: HandLayout
    states: list[HandState]
    angles: Array


@dataclass(frozen=True)
class Fingers:
    """Fingers before and after at gauge pressures (k,) [Pa], the mean angles (k,) [rad] that were
    measured there, NaN where nothing was; effects that were named; length [m] of the finger.
    """

    pressures: Array
    before: Bent
    after: Bent
    measured: Array
    effects: tuple[str, ...]
    length: float

    def measured_line(self, number: int) -> Array:
        """Middle line (k, 3) [m] of a finger that is bent evenly to the measured angle."""
        angle, share = self.measured[number], np.linspace(0.0, 1.0, 16)
        curved = share * (angle if abs(angle) > 1e-3 else 1e-3)
        radius = self.length / curved[-1]
        return radius * np.stack([1.0 - np.cos(curved), 0.0 * share, np.sin(curved)], axis=1)


def fingers_of(diagnosis: Path, measured: Path) -> Fingers:
    """Fingers of a diagnosis (JSON) of free bending, and of the set that it was made from.

    Raises ValueError for other files, and for effects that the simulator does not know.
    """
    from model_lab.measurements.load import load_measurements

    found = _read(diagnosis)
    data = load_measurements(measured)
    if data.experiment != "free_bending":
        raise ValueError(f"{measured}: expected free_bending, got {data.experiment}")
    name = next(iter(data.specimens))
    runs = [run for run in data.runs if run.specimen == name]
    points = [(run.columns["pressure"], run.columns["tip_angle"]) for run in runs]
    pressure, angle = (np.concatenate(parts) for parts in zip(*points, strict=True))
    pressures = np.linspace(0.0, float(pressure.max()), PRESSURES)
    effects = {each["name"]: each["parameters"] for each in found["effects"]}
    with tempfile.TemporaryDirectory() as folder:
        hand = _hand(data.specimens[name].values, float(pressure.max()), Path(folder))
        before = _bent(hand, _model({}, found, Path(folder) / "before.yaml"), pressures)
        after = _bent(hand, _model(effects, found, Path(folder) / "after.yaml"), pressures)
    length = float(data.specimens[name].values["length"])
    near = np.abs(pressure[:, None] - pressures) < NEAR * pressures[1]
    seen = [angle[near[:, k]].mean() if near[:, k].any() else np.nan for k in range(PRESSURES)]
    return Fingers(pressures, before, after, np.array(seen), tuple(effects), length)


def _read(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as reason:
        raise ValueError(f"{path}: expected a diagnosis as JSON, got {reason}") from reason
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise ValueError(f"{path}: expected the format {FORMAT}, got another")
    return found


def _hand(specimen: Mapping[str, Any], limit: float, folder: Path) -> str:
    """A file of a finger with the specimen's dimensions."""
    kind = {key: np.asarray(specimen[key]).tolist() for key in OWN}
    kind |= {"max_pressure": 1.05 * limit, "supply_volume": 0.0}
    path = folder / "finger.yaml"
    path.write_text(yaml.safe_dump({**HAND, "types": {"specimen": kind}}))
    return str(path)


def _model(effects: dict[str, Any], found: dict[str, Any], path: Path) -> str:
    """A model file of the diagnosis with these effects; without weight, as in the lab's frame."""
    entries = [
        {"name": name, "parameters": {key: each["value"] for key, each in values.items()}}
        for name, values in effects.items()
    ]
    content: dict[str, Any] = {"format": MODEL_FORMAT, "base": "pneuflex", "effects": entries}
    scales = found.get("calibration", {}).get("modulus_scale")
    if scales:
        first = next(iter(scales.values())) if isinstance(scales, dict) else scales
        content["calibration"] = {"modulus_scale": first}
    path.write_text(yaml.safe_dump(content))
    return str(path)


def _bent(hand: str, model: str, pressures: Array) -> Bent:
    """The finger at rest at each gauge pressure [Pa]."""
    config = SimulationConfig(hand=hand, scene="stand", model=model, step=STEP, segments=SEGMENTS)
    simulation = Simulation(config)
    try:
        states, angles = [], []
        air, ambient = simulation.air, simulation.ambient
        for pressure_abs in ambient + pressures:
            for _ in range(round(REST / STEP)):
                held = np.array([pressure_abs]), ambient, simulation.temperature
                simulation.set_air_masses(air.masses(*held, simulation.bodies.rotations))
                simulation.step()
            pose = [np.array(part) for part in simulation.wrist_pose()]
            states.append(HandState(simulation.bodies.q.copy(), *pose))
            angles.append(simulation.tip_angles()["finger"])
        return Bent(simulation.shape.layout, states, np.array(angles))
    finally:
        simulation.close()
