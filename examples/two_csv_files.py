"""Write two files of one run as a laboratory has them: a regulator's log, and a camera's angles.

The index finger of RBO Hand 2 is inflated and let go, at two rates and with holds. Its rubber
stiffens, which the base model lacks. The log has semicolons, decimal commas and mbar every 20 ms;
the camera degrees every 50 ms, and a clock that is 1.2 s late.
"""

import argparse
from pathlib import Path

import numpy as np

import model_lab as lab
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

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
    log, camera = folder / "druck.csv", folder / "winkel.csv"
    time, seen = np.arange(0.0, KNOTS[-1], 0.02), np.arange(0.0, KNOTS[-1], 0.05)
    write(log, "Zeit [s];Druck [mbar]", time, 10.0 * np.interp(time, KNOTS, PRESSURES))
    write(camera, "Zeit [s];Winkel [°]", seen, 0.0 * seen)  # for the times alone
    data = lab.import_files([log, camera], "free_bending", hand="rbo_hand_2:index")
    rubber = Model(effects=(effect_classes()["yeoh_stiffening"](**STIFFENING),))
    (run,) = lab.predict(data, rubber).runs.values()
    noise = np.random.default_rng(1).normal(0.0, NOISE, len(run))
    write(camera, "Zeit [s];Winkel [°]", run["time"] + LATE, run["tip_angle"] + noise)
    print(f"written: {log}, {camera}")


def write(path: Path, header: str, *columns: np.ndarray) -> None:
    """Write columns with semicolons and decimal commas."""
    rows = (";".join(f"{value:.3f}" for value in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([header, *rows]).replace(".", ",") + "\n", encoding="cp1252")


if __name__ == "__main__":
    main()
