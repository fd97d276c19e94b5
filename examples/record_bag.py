"""Write bags of a finger as the suite records them: pressures of the driver, angles of a tracker.

The index finger of RBO Hand 2 is inflated slowly to three pressures, each twice. Above 45 kPa it
balloons, which the base model lacks. `python examples/record_bag.py FOLDER` needs no ROS; a
session with the hand leaves the same topics (docs/use/bags.md).
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import model_lab as lab
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

PEAKS = {"low": 40.0, "middle": 55.0, "high": 65.0}  # [kPa]
DURATION, SAMPLES = 24.0, 40  # [s], [-]
NOISE = 0.2  # [deg]
BALLOONING = {"gain": 0.3, "onset": 45e3, "sharpness": 8.0}
START = 1_700_000_000.0  # [s] since 1970
STORE = get_typestore(Stores.ROS2_JAZZY)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("out/bags"))
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(1)
    for name, run in true_runs().items():
        for repeat in (1, 2):
            noise = random.normal(0.0, NOISE, len(run))
            bag = folder / f"{name}_{repeat}"
            write(bag, run["time"], 1e3 * run["pressure"], np.radians(run["tip_angle"] + noise))
            print(f"written: {bag}")


def true_runs() -> dict[str, pd.DataFrame]:
    """What the finger does [s, kPa, deg]."""
    time = np.linspace(0.0, DURATION, SAMPLES)
    course = 1.0 - np.abs(2.0 * time / DURATION - 1.0)
    frames = {
        name: pd.DataFrame({"time": time, "pressure": peak * course, "tip_angle": 0.0 * time})
        for name, peak in PEAKS.items()
    }
    units = {"time": "s", "pressure": "kPa", "tip_angle": "deg"}
    finger = load_hand("rbo_hand_2").chain("index").actuators["index"]
    sizes = {key: getattr(finger, key) for key in ("length", "shear_modulus", "mass")}
    along = np.linspace(0.0, finger.length, 61)
    for key in ("height", "width", "wall", "side_wall"):
        values = np.broadcast_to(getattr(finger, key)(along), along.shape)
        sizes[key] = np.stack([along, values], axis=1).tolist()
    data = lab.from_frames(frames, "free_bending", {"index": sizes}, units)
    model = Model(effects=(effect_classes()["ballooning"](**BALLOONING),))
    return lab.predict(data, model).runs


def write(bag: Path, times: np.ndarray, pressures: np.ndarray, angles: np.ndarray) -> None:
    """Write a rosbag2 folder with pressures [Pa] and tip angles [rad] of one finger."""
    kind = "sensor_msgs/msg/JointState"
    state = STORE.types[kind]
    nothing = np.array([])
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = [
            writer.add_connection(topic, kind, typestore=STORE)
            for topic in ("/pneumaticbox/state", "/hand/tip_angles")
        ]
        for time, pressure, angle in zip(times, pressures, angles, strict=True):
            nanoseconds = round((START + time) * 1e9)
            stamp = STORE.types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
            header = STORE.types["std_msgs/msg/Header"](stamp, "base")
            messages = (
                state(header, ["b"], nothing, nothing, np.array([pressure])),
                state(header, ["index"], np.array([angle]), nothing, nothing),
            )
            for topic, message in zip(topics, messages, strict=True):
                writer.write(topic, nanoseconds, STORE.serialize_cdr(message, kind))


if __name__ == "__main__":
    main()
