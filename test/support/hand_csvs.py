"""Files of a hand that held poses, as other people's rigs write them."""

import numpy as np
from scipy.spatial.transform import Rotation

from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

HAND, SEGMENTS = "rbo_hand_2", 5
CHANNELS = "abcd"
TIPS = ("thumb", "index", "middle", "ring", "little")
HIGHEST = 1e3 * np.array([40.0, 40.0, 30.0, 30.0])  # [Pa]
WRISTS = ((0.0, 0.0, 0.0), (0.0, np.pi / 2, 0.0), (1.2, -0.4, 0.8))  # roll, pitch, yaw [rad]
POSES = 5


def poses(seed=0):
    """Pressures (runs, poses, channels) [Pa] and places (runs, poses, tips, 3) [m] of the tips in
    the frame of the wrist, in the statics of the hand.
    """
    random = np.random.default_rng(seed)
    pressures = HIGHEST * random.uniform(0.2, 1.0, (len(WRISTS), POSES, len(CHANNELS)))
    places = [_tips(one, rpy) for one, rpy in zip(pressures, WRISTS, strict=True)]
    return pressures, np.array(places)


def _tips(pressures, rpy):
    hand = load_hand(HAND)
    down = Rotation.from_euler("xyz", rpy).inv().apply([0.0, 0.0, -9.81])
    bodies = settled_hand(hand, Model(), SEGMENTS, pressures.T, np.tile(down, (len(pressures), 1)))
    found = {
        name: body.point(shape, name, 1.0, np.zeros(3))
        for body, shape in bodies
        for name in body.joints
        if name in TIPS
    }
    return np.stack([found[tip] for tip in TIPS], axis=1)


def hand_header():
    """Names of the columns of `one_row_a_pose`, in s, kPa and mm."""
    places = (f"{tip}_tip.{axis} [mm]" for tip in TIPS for axis in "xyz")
    return ["time [s]", *(f"pressure.{channel} [kPa]" for channel in CHANNELS), *places]


def table(path, header, rows, comma=",", decimal=".", above=()):
    """Write a text file of a header, lines above it, and rows of numbers."""
    lines = [*above, comma.join(header)]
    for row in rows:
        lines.append(comma.join(f"{value:.7f}".replace(".", decimal) for value in row))
    path.write_text("\n".join(lines) + "\n")
    return path


def one_row_a_pose(folder, header, scales, run_of=None, **dialect):
    """A file a run with a row for each pose, 5 s apart: time, pressures times scales[0], places
    times scales[1], and what `run_of(rpy)` adds to each row.
    """
    files = []
    for number, (blown, seen) in enumerate(zip(*poses(), strict=True)):
        more = run_of(WRISTS[number]) if run_of else ()
        rows = [
            (5.0 * at, *(scales[0] * one), *(scales[1] * tips).ravel(), *more)
            for at, (one, tips) in enumerate(zip(blown, seen, strict=True))
        ]
        files.append(table(folder / f"hold_{number}.csv", header, rows, **dialect))
    return files


def motion_capture(
    folder, late=0.0, turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), rate=50.0, room=0.0
):
    """Two files a run: pressures of a logger, and the export of a motion capture that follows the
    tips in the world, and a body at the wrist whose frame is turned and shifted against the wrist.
    Poses are held for 1.6 s after 0.6 s of motion; the clock of the places is late. room [rad]: by
    which the world is turned about x, -pi/2 where y points up.
    """
    files, own = [], Rotation.from_euler("xyz", turn)
    for number, (blown, seen) in enumerate(zip(*poses(), strict=True)):
        time = np.arange(0.0, 2.2 * POSES, 1.0 / rate)
        knots = np.ravel([(2.2 * at, 2.2 * at + 1e-9 + 0.6) for at in range(POSES)])
        held = np.ravel([(max(at - 1, 0), at) for at in range(POSES)])
        at = np.interp(time, knots, held)
        pressures = np.stack([np.interp(at, range(POSES), one) for one in blown.T], axis=1)
        places = np.stack([np.interp(at, range(POSES), one) for one in seen.reshape(POSES, -1).T])
        wrist = Rotation.from_euler("x", room) * Rotation.from_euler("xyz", WRISTS[number])
        place = np.array([0.4, -0.2, 1.1])
        world = wrist.apply(places.T.reshape(-1, 3)).reshape(len(time), -1) + np.tile(place, 5)
        body = (wrist * own.inv()).as_quat()
        origin = place - (wrist * own.inv()).apply(shift)
        names = ["Frame", "Time", *["wrist"] * 7, *np.repeat(TIPS, 3)]
        kinds = ["", "", *["Rotation"] * 4, *["Position"] * 18]
        axes = ["Frame", "Time (Seconds)", *"XYZWXYZ", *"XYZ" * 5]
        rows = [
            (frame, when + late, *body, *origin, *one)
            for frame, (when, one) in enumerate(zip(time, world, strict=True))
        ]
        above = ["Format Version,1.23", ",".join(names), ",".join(kinds)]
        files.append(table(folder / f"hold{number}_mocap.csv", axes, rows, above=above))
        header = ["t [s]", *(f"{name}{n} [kPa]" for name in ("p", "set") for n in range(1, 5))]
        logged = np.column_stack([time, 1e-3 * pressures, 2e-3 * pressures])
        files.append(table(folder / f"hold{number}_pressure.csv", header, logged))
    return files
