"""Write two files of one run as a laboratory has them: a regulator's log, and a camera's angles.

The index finger of RBO Hand 2 is inflated and let go, at two rates and with holds. Its rubber
stiffens, which the base model lacks. The log has semicolons, decimal commas and mbar every 20 ms;
the camera degrees every 50 ms, and a clock that is 1.2 s late.
"""

import argparse
from pathlib import Path

import numpy as np

from model_lab.experiments.forward import Forward
from model_lab.importing.geometry import finger_of_hand
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import effect_classes

KNOTS = (0, 2, 6, 8, 12, 14, 15, 18, 19, 20, 24, 28, 30, 34, 40, 42)  # [s]
PRESSURES = (0, 0, 45, 45, 0, 0, 30, 30, 0, 0, 45, 20, 20, 45, 0, 0)  # [kPa] at these times
LATE = 1.2  # [s]
STIFFENING = {"c2": 0.05}  # [-] Yeoh's second coefficient
NOISE = 0.5  # [deg]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("out/two_files"))
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    time = np.arange(0.0, KNOTS[-1], 0.02)
    pressure = np.interp(time, KNOTS, PRESSURES)
    angle = np.degrees(bent(time, 1e3 * pressure))
    seen = np.arange(0.0, KNOTS[-1], 0.05)
    measured = np.interp(seen, time, angle) + np.random.default_rng(1).normal(0.0, NOISE, len(seen))
    write(folder / "druck.csv", "Zeit [s];Druck [mbar]", time, 10.0 * pressure)
    write(folder / "winkel.csv", "Zeit [s];Winkel [°]", seen + LATE, measured)
    print(f"written: {folder / 'druck.csv'}, {folder / 'winkel.csv'}")


def bent(time: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Tip angle (samples,) [rad] at pressures [Pa]."""
    name, entry = finger_of_hand("rbo_hand_2:index", [])
    sizes = {key: np.asarray(value) for key, value in entry.items()}
    run = Run("r1", name, "r1", 293.15, {"time": time, "pressure": pressure})
    data = MeasurementSet("free_bending", "", {name: Specimen(name, sizes)}, (run,))
    effect = effect_classes()["yeoh_stiffening"](**STIFFENING)
    return Forward(data, fixed=[effect], free_calibration=False).predict(np.zeros((1, 0)))[0]


def write(path: Path, header: str, *columns: np.ndarray) -> None:
    """Write columns with semicolons and decimal commas."""
    rows = (";".join(f"{value:.3f}" for value in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([header, *rows]).replace(".", ",") + "\n", encoding="cp1252")


if __name__ == "__main__":
    main()
