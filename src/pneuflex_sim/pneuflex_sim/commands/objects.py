"""The command `softhand objects`: what objects there are, as a table or as one picture."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.bullet import pybullet
from pneuflex_sim.pictures.render import (
    OBJECT_COLOR,
    TABLE_COLOR,
    Camera,
    draw_box,
    draw_mesh,
    draw_object,
    photograph,
)
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.mesh import box, merged
from pneuflex_sim.scene.object_body import Sheet
from pneuflex_sim.scene.objects import ObjectDescription, load_object, load_objects
from softhand_common.documents.output_file import PICTURES, check_new, save_figure

OBJECT_PICTURE_SIZE = (360, 300)  # of one picture [px]
PICTURE_COLUMNS = 6
OBJECT_CAMERA = Camera(
    target=(0.0, 0.0, 0.03), distance=0.42, yaw=60.0, pitch=-32.0, view_angle=33.0
)
FLOOR_HALF_SIZE = (3.0, 3.0, 0.01)  # half extents [m]


def table(objects: list[ObjectDescription]) -> str:
    """Objects as a Markdown table: size [mm], mass [g], material, and what the model leaves out."""
    lines = ["| object | size [mm] | mass [g] | material | in the model |", "|---|---|---|---|---|"]
    lines += [
        f"| `{one.name}` | {size_text(one)} | {1e3 * one.mass:g} | {one.material} | {one.note} |"
        for one in objects
    ]
    return "\n".join(lines)


def size_text(described: ObjectDescription) -> str:
    """Outer size [mm] as text: for a round object its diameter, and its length if it has one; for
    others three lengths.
    """
    sizes = described.dimensions
    if described.shape in ("cylinder", "cup"):
        return f"dia {1e3 * sizes['diameter']:g} x {1e3 * sizes['length']:g}"
    if described.shape == "sphere":
        return f"dia {1e3 * sizes['diameter']:g}"
    if described.geometry.surface is None:
        lengths = 1e3 * np.array(sizes["size"])
    else:
        lengths = 1e3 * np.ptp(described.geometry.surface.vertices, axis=0)
    return " x ".join(f"{length:.4g}" for length in lengths)


def write_contact_sheet(objects: list[ObjectDescription], path: Path) -> None:
    """Pictures of objects as they lie, all from the same distance, with names and sizes."""
    from matplotlib.figure import Figure  # an extra: the table needs no matplotlib

    rows = -(-len(objects) // PICTURE_COLUMNS)
    figure = Figure(figsize=(2.4 * PICTURE_COLUMNS, 2.1 * rows), layout="constrained")
    axes = figure.subplots(rows, PICTURE_COLUMNS, squeeze=False).ravel()
    for axis in axes:
        axis.set_axis_off()
    for axis, one in zip(axes, objects, strict=False):
        axis.imshow(picture(one))
        axis.set_title(f"{one.name}\n{size_text(one)} mm, {1e3 * one.mass:g} g", fontsize=8)
    save_figure(figure, path, dpi=130)


def picture(described: ObjectDescription) -> NDArray[np.uint8]:
    """One object as it lies in the scene."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        draw_box(FLOOR_HALF_SIZE, (0, 0, -FLOOR_HALF_SIZE[2]), (0, 0, 0, 1), TABLE_COLOR, client)
        place = [0.0, 0.0, described.rest_height]
        orientation = Rotation.from_euler("xyz", described.rpy).as_quat().tolist()
        if described.shape == "sheet":
            strips = [
                box(size, np.zeros(3)).moved(middle, tilt)
                for size, middle, tilt in Sheet(described.dimensions).strips_at_first()
            ]
            draw_mesh(merged(strips), place, orientation, OBJECT_COLOR, client)
        else:
            draw_object(described, place, orientation, client)
        return photograph(OBJECT_CAMERA, OBJECT_PICTURE_SIZE, client)
    finally:
        pybullet.disconnect(client)


def main(arguments: list[str] | None = None) -> int:
    """Print the table, or write the picture; returns 0, or 2 for what cannot be used."""
    parser = argparse.ArgumentParser(
        prog="softhand objects", description="Table or picture of objects to grasp."
    )
    parser.add_argument("objects", nargs="*", help="names or files (default: all that are shipped)")
    parser.add_argument("--figure", type=Path, help="picture to write in place of the table")
    parser.add_argument("--force", action="store_true", help="overwrite that picture")
    parser.add_argument("--friction", help="YAML file with pairs of materials of your own")
    options = parser.parse_args(arguments)
    try:
        if options.figure is not None:
            check_new(options.figure, options.force, PICTURES)
        friction = load_friction(options.friction)
        objects = [load_object(name, friction) for name in options.objects or load_objects()]
        if options.figure is not None:
            write_contact_sheet(objects, options.figure)
    except ValueError as error:
        print(f"softhand objects: {error}", file=sys.stderr)
        return 2
    print(table(objects) if options.figure is None else options.figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
