"""A simulated day at the rig: specimens, runs in order, noise; written as a set of files."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from . import physics
from .physics import Effects, Finger
from .protocols import KINDS, course

OUTPUTS = {"free_bending": "tip_angle", "blocked_tip": "tip_force", "uniaxial": "stress"}
UNITS = {  # columns as written: unit and its size in SI units
    "time": ("s", 1.0),
    "pressure": ("kPa", 1e3),
    "tip_angle": ("deg", np.pi / 180),
    "tip_force": ("N", 1.0),
    "stretch": ("", 1.0),
    "stress": ("kPa", 1e3),
}
STEPS_A_SAMPLE = 12  # of the simulation


@dataclass
class Run:
    """A run as it is played: what, on which specimen, when of the day, and what was recorded."""

    name: str
    specimen: str
    protocol: str
    corners: np.ndarray
    temperature: float
    data: pd.DataFrame | None = None


@dataclass(frozen=True)
class Noise:
    """Sizes relative to the set's largest output (input for `pressure`)."""

    white: float
    wander: float
    gain: float
    zero: float
    step: float
    pressure: float


@dataclass
class Rig:
    """A set before it is written. `true` has the real modulus, `stated` what the file says."""

    experiment: str
    true: dict[str, Finger]
    stated: dict[str, dict]
    runs: list[Run]
    samples: int
    noise: Noise
    says_noise: bool
    effects: Effects = field(default_factory=dict)
    units: dict[str, tuple[str, float]] = field(default_factory=lambda: dict(UNITS))
    largest: float = 1.0  # output of the base model, SI

    @property
    def inputs(self) -> str:
        """Name of the column of the input."""
        return "stretch" if self.experiment == "uniaxial" else "pressure"

    @property
    def output(self) -> str:
        """Name of the column of the output."""
        return OUTPUTS[self.experiment]


def new_rig(
    rng: np.random.Generator,
    experiment: str = "free_bending",
    specimens: int | None = None,
    protocols: int | None = None,
    repeats: int | None = None,
    peak_angle: float | None = None,
) -> Rig:
    """A rig with random specimens, protocols, noise and calibration, nothing hidden."""
    count = specimens or int(rng.choice([1, 1, 2, 3]))
    if experiment != "free_bending":
        count = min(count, 2)
    true = {f"s{k}": _finger(rng, experiment) for k in range(count)}
    stated = {name: _stated(finger) for name, finger in true.items()}
    scale = float(rng.uniform(0.9, 1.1))
    true = {name: physics.scaled(finger, scale) for name, finger in true.items()}
    peak = _peak(rng, experiment, true, peak_angle)
    runs = _session(
        rng,
        list(true),
        peak,
        protocols or int(rng.integers(2, 5)),
        repeats or int(rng.choice([2, 2, 3])),
        experiment == "uniaxial",
    )
    rig = Rig(
        experiment, true, stated, runs, int(rng.integers(60, 140)), _noise(rng), rng.random() < 0.5
    )
    rig.largest = max(np.abs(y).max() for y in outputs(rig, {}))
    return rig


def _finger(rng: np.random.Generator, experiment: str) -> Finger:
    height = rng.uniform(0.014, 0.024)
    taper = experiment == "free_bending" and rng.random() < 0.25
    return Finger(
        length=round(rng.uniform(0.07, 0.13), 4),
        height=round(height, 4),
        tip_height=round(height * rng.uniform(0.6, 0.85), 4) if taper else round(height, 4),
        width=round(height * rng.uniform(0.8, 1.3), 4),
        wall=round(rng.uniform(0.0018, 0.0045), 4),
        side_wall=round(rng.uniform(0.0015, 0.0035), 4),
        modulus=float(rng.choice([67e3, 80e3, 120e3, 170e3])),
        mass=round(rng.uniform(0.02, 0.06), 4),
        mount=str(rng.choice(["bending_plane_level", "base_up", "base_down"], p=[0.8, 0.1, 0.1])),
    )


def _stated(finger: Finger) -> dict:
    height: float | list = finger.height
    if finger.tip_height != finger.height:
        height = [[0.0, finger.height], [finger.length, finger.tip_height]]
    return {
        "length": finger.length,
        "height": height,
        "width": finger.width,
        "wall": finger.wall,
        "side_wall": finger.side_wall,
        "shear_modulus": finger.modulus,
        "mass": finger.mass,
        "mount": finger.mount,
        "batch": "A",
    }


def _peak(rng, experiment: str, true: dict[str, Finger], peak_angle: float | None) -> float:
    """Largest pressure [Pa], or stretch, of the session: the softest finger bends to an angle."""
    if experiment == "uniaxial":
        return float(rng.uniform(1.6, 2.8))
    angle = peak_angle or float(np.deg2rad(rng.uniform(80, 190)))
    pressures = np.linspace(0, 400e3, 400)
    return float(
        min(
            np.interp(angle, physics.tip_angle(finger, {}, pressures, pressures)[0], pressures)
            for finger in true.values()
        )
    )


def _session(rng, specimens: list[str], peak: float, protocols: int, repeats: int, strip: bool):
    """Runs in the order of the day: each round plays every protocol on every specimen once."""
    kinds = list(rng.permutation(KINDS)[:protocols])
    plans = {}
    for k, kind in enumerate(kinds):
        share = 1.0 if k == 0 else rng.uniform(0.5, 0.95)
        top = (peak - 1) * share if strip else peak * share
        plans[f"{kind}_{k}"] = course(kind, top, rng.uniform(6, 40), rng)
    temperature = 293.15 + rng.uniform(-1, 1)
    runs: list[Run] = []
    for _ in range(repeats):
        for specimen in specimens:
            for protocol, corners in plans.items():
                mine = corners * [1.0, rng.normal(1, 0.005)] + [0.0, 1.0 if strip else 0.0]
                warm = round(temperature + rng.uniform(-0.2, 0.2), 2)
                runs.append(Run(f"run{len(runs) + 1:02d}", specimen, protocol, mine, warm))
    return runs


def _noise(rng: np.random.Generator) -> Noise:
    return Noise(
        white=rng.uniform(0.002, 0.008),
        wander=rng.uniform(0.0005, 0.003),
        gain=rng.uniform(0.001, 0.006),
        zero=rng.uniform(0.0005, 0.003),
        step=rng.choice([0.0, 0.001, 0.003]),
        pressure=rng.uniform(0.0002, 0.001),
    )


def outputs(rig: Rig, effects: Effects, scale: float = 1.0) -> list[np.ndarray]:
    """Output of each run in SI units at the times of its samples, without noise.

    scale: on every modulus, as a calibration would put it there.
    """
    before = dict.fromkeys(rig.true, 0)
    largest: dict[str, np.ndarray | None] = dict.fromkeys(rig.true)
    found = []
    for run in rig.runs:
        finger = physics.scaled(rig.true[run.specimen], scale)
        fine = np.linspace(0, run.corners[-1, 0], (rig.samples - 1) * STEPS_A_SAMPLE + 1)
        drive = np.interp(fine, *run.corners.T)
        count = before[run.specimen]
        if rig.experiment == "free_bending":
            y, largest[run.specimen] = physics.tip_angle(
                finger, effects, fine, drive, count, run.temperature, largest[run.specimen]
            )
        elif rig.experiment == "blocked_tip":
            y = physics.tip_force(finger, effects, fine, drive, count, run.temperature)
        else:
            past = largest[run.specimen]
            most = 1.0 if past is None else float(past[0])
            y, most = physics.tension(finger.modulus, effects, fine, drive, count, most)
            largest[run.specimen] = np.array([most])
        before[run.specimen] += 1
        found.append(y[::STEPS_A_SAMPLE])
    return found


def record(rig: Rig, rng: np.random.Generator) -> None:
    """Play all runs and keep what the sensors show, in SI units, as each run's `data`."""
    noise = rig.noise
    for run, y in zip(rig.runs, outputs(rig, rig.effects), strict=True):
        count = len(y)
        time = np.linspace(0, run.corners[-1, 0], count)
        drive = np.interp(time, *run.corners.T)
        shown = y * rng.normal(1, noise.gain) + rng.normal(0, noise.zero) * rig.largest
        shown = shown + noise.white * rig.largest * rng.standard_normal(count)
        shown = shown + noise.wander * rig.largest * _wander(count, rng)
        if rig.inputs == "pressure":
            scatter = noise.pressure * drive.max() * rng.standard_normal(count)
            drive = physics.pressure_reading(rig.effects, drive) + scatter
        else:
            drive = (drive + 1e-4 * rng.standard_normal(count)).clip(1.0)
        if "saturation" in rig.effects:
            shown = np.minimum(shown, rig.effects["saturation"]["limit"])
        step = noise.step * rig.largest
        shown = np.round(shown / step) * step if step else shown
        run.data = pd.DataFrame({"time": time, rig.inputs: drive, rig.output: shown})


def _wander(count: int, rng: np.random.Generator) -> np.ndarray:
    """Slow noise of unit size: a few cosines of random phase."""
    t = np.linspace(0, 1, count)
    waves = [np.cos(np.pi * k * t + rng.uniform(0, 2 * np.pi)) / k for k in (1, 2, 3)]
    return np.sum(waves, axis=0)


def floor(rig: Rig) -> float:
    """Expected size of the noise [SI] of the recorded output."""
    n = rig.noise
    return rig.largest * float(
        np.sqrt(n.white**2 + n.wander**2 * 0.7 + (n.gain * 0.6) ** 2 + n.zero**2 + n.step**2 / 12)
    )


def write(rig: Rig, folder: Path) -> None:
    """Write the recorded runs as a set: experiment.yaml and one CSV file for each run."""
    folder.mkdir(parents=True, exist_ok=True)
    runs = {}
    for run in rig.runs:
        require_data(run)
        table = pd.DataFrame({c: run.data[c] / rig.units[c][1] for c in run.data})
        table.to_csv(folder / f"{run.name}.csv", index=False, float_format="%.6g")
        runs[run.name] = {
            "specimen": run.specimen,
            "temperature": run.temperature,
            "protocol": run.protocol,
            "file": f"{run.name}.csv",
        }
    document = {
        "format": "softhand-measurement/1",
        "experiment": rig.experiment,
        "specimens": rig.stated,
        "columns": {c: {"unit": rig.units[c][0]} for c in ("time", rig.inputs, rig.output)},
        "runs": runs,
    }
    if rig.says_noise:
        sigma = rig.noise.white * rig.largest / rig.units[rig.output][1]
        document["noise"] = {rig.output: float(f"{sigma:.3g}")}
    (folder / "experiment.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def require_data(run: Run) -> None:
    """Raise ValueError if the run was not played."""
    if run.data is None:
        raise ValueError(f"{run.name}: expected a recorded run; call `record` before `write`")


def scarce(rig: Rig, count: int) -> Rig:
    """The rig with the first `count` runs alone."""
    return replace(rig, runs=rig.runs[:count])
