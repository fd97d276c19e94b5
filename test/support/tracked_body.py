"""Sets of a hand in the frame of a tracked body that nobody has aligned with the wrist."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation


def in_other_frame(data, turn, shift):
    """The set with its places as a body sees them whose frame is turned (roll, pitch, yaw) [rad]
    and shifted (3,) [m] against the wrist.
    """
    runs, turned = [], Rotation.from_euler("xyz", turn)
    for run in data.runs:
        columns = dict(run.columns)
        for name in data.markers:
            axes = [f"{name}.{axis}" for axis in "xyz"]
            places = np.stack([run.columns[axis] for axis in axes], axis=1)
            columns |= dict(zip(axes, (turned.apply(places) + shift).T, strict=True))
        attitude = Rotation.from_euler("xyz", run.wrist_rpy) * turned.inv()
        rpy = tuple(attitude.as_euler("xyz").tolist())
        runs.append(replace(run, columns=columns, wrist_rpy=rpy))
    return replace(data, runs=tuple(runs))


def freed(data):
    """The set with the frame of its places known by the places alone."""
    specimens = {
        name: replace(one, hand=replace(one.hand, free_frame=True))
        for name, one in data.specimens.items()
    }
    return replace(data, specimens=specimens)
