"""The palm as a segment of a cone, which the thesis says it becomes when both of its actuators have
the same pressure (7.3), as a set of poses of the thumb's base.

Curvatures are then proportional to 1/radius, so both arcs bend by the same b per angle of the arc,
and nothing twists: from one end of the palm to the other, its frame moves along a screw of constant
rate. How much the palm bends at a pressure the thesis does not say; here that is the model's own
bend, so that what a model is off by is twist, and what comes of it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.linalg import expm

from softhand_common.documents.output_file import write_file
from softhand_common.numerics.rotations import rotate
from softhand_model.chain.chain import discretise
from softhand_model.chain.segments import BEND_AXIS, arc_angle, mean_radius
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model
from thesis.frame import Array

PALM = "palm"
ARM = 0.020  # [m] from the thumb's base to the markers that show how it is turned
MARKERS = {"base": (0.0, 0.0, 0.0), "base_x": (ARM, 0.0, 0.0), "base_y": (0.0, ARM, 0.0)}
SEGMENTS = 20


def own_bend(hand: HandDescription, pressures: Array) -> Array:
    """How far [rad] the palm of the base model bends with gauge pressures (rows,) [Pa] in both
    arcs, over its whole length, without weight.
    """
    palm = discretise(hand.chain(PALM), SEGMENTS, Model())
    both = np.tile(pressures, (2, 1))
    turns = palm.rest_rotations(both, 1.0, np.full(len(pressures), ROOM_TEMPERATURE))
    return np.asarray(turns[:, :, BEND_AXIS].sum(axis=1))


def cone(hand: HandDescription, bends: Array) -> Array:
    """Places (rows, markers, 3) [m] in the wrist frame of markers on the thumb's base, with the
    palm a segment of a cone that bends by `bends` (rows,) [rad] over its length.
    """
    palm, thumb = hand.chain(PALM), hand.chain("thumb").mount
    arcs = list(palm.actuators.values())
    angle, radius = arc_angle(arcs), mean_radius(arcs)
    start = _frame(np.array(palm.mount.position), rotate(palm.mount.quaternion, np.eye(3)).T)
    mount = _frame(np.array(thumb.position), rotate(thumb.quaternion, np.eye(3)).T)
    marks = np.array([[*offset, 1.0] for offset in MARKERS.values()]).T
    found = []
    for bend in bends:
        screw = np.zeros((4, 4))
        turn = np.array([-palm.turn * angle, bend, 0.0])
        screw[:3, :3] = np.cross(np.eye(3), turn)  # as a matrix
        screw[2, 3] = radius * angle
        found.append((start @ expm(screw) @ mount @ marks)[:3].T)
    return np.array(found)


def _frame(place: Array, axes: Array) -> Array:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = axes, place
    return whole


def write_set(
    folder: Path,
    hand: HandDescription,
    pressures: Array,
    places: Array,
    noise: float,
    title: str,
    with_pressures: bool = True,
) -> None:
    """Write a set of poses in two runs, with all rows in turn.

    pressures (rows, channels) [Pa]. places (rows, markers, 3) [m] of the markers, in the wrist
    frame. noise [m]: stated uncertainty of each coordinate; none is added. with_pressures: False
    leaves the pressures out, as a picture does.
    """
    channels = [f"pressure.{name}" for name in hand.channels] if with_pressures else []
    marks = [f"{name}.{axis}" for name in MARKERS for axis in "xyz"]
    units = [f"  {name}: {{unit: kPa}}" for name in channels]
    units += [f"  {name}: {{unit: mm}}" for name in marks]
    sure = [f"  {name}: {1e3 * noise:g}" for name in marks]
    placed = [
        f"  {name}: {{actuator: thumb, at: 0.0, offset: {list(offset)}}}"
        for name, offset in MARKERS.items()
    ]
    runs = {"even": slice(0, None, 2), "odd": slice(1, None, 2)}
    lines = [
        "format: softhand-measurement/1",
        "experiment: hand_pose",
        f"title: {title}",
        "specimens: {hand: {hand: " + hand.name + "}}",
        *("markers:", *placed, "columns:", *units, "noise:", *sure, "runs:"),
        *(
            f"  {name}: {{specimen: hand, protocol: {name}, wrist_rpy: [0.0, 0.0, 0.0], "
            f"file: {name}.csv}}"
            for name in runs
        ),
    ]
    write_file(folder / "experiment.yaml", "\n".join(lines) + "\n")
    for name, rows in runs.items():
        table = [",".join(channels + marks)]
        for pressure, place in zip(pressures[rows], places[rows], strict=True):
            given = (1e-3 * pressure).tolist() if with_pressures else []
            table.append(",".join(f"{v:.6g}" for v in [*given, *(1e3 * place).ravel()]))
        write_file(folder / f"{name}.csv", "\n".join(table) + "\n")
