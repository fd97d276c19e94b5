"""The command `softhand skin`: a hand that closes in free air, as meshes or pictures."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.pictures.hand_picture import UPRIGHT, hand_at_rest
from pneuflex_sim.pictures.render import Camera, HandState, Renderer
from pneuflex_sim.scene.mesh import write_meshes
from softhand_common.documents.output_file import check_new, written_whole
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import HandDescription, load_hand

SKIN_FOLDER = Path("out/skin")
VIEW_ANGLES = ((90.0, -12.0), (35.0, -15.0))  # yaw and pitch [deg]: on the palm, from the side
DEFAULT_PRESSURE_SHARE = 0.4  # of the pressure limits, where no pressure is given
SKIN_PICTURE_SIZE = (480, 480)
SKIN_CAMERA = Camera(target=(0.0, 0.0, 0.10), distance=0.52, view_angle=32.0)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="softhand skin",
        description="Close a hand in free air, without weight, and write its smooth surface frame "
        "by frame: one mesh file [m] or picture a frame.",
    )
    add = found.add_argument
    add("hand", help="name of a shipped hand or path of its YAML")
    add(
        "--pressure",
        nargs="+",
        type=float,
        metavar="PA",
        help="gauge pressure [Pa] of every channel, or one for all "
        f"({DEFAULT_PRESSURE_SHARE:.0%} of their limits)".replace("%", "%%"),
    )
    add("--frames", type=int, default=5, help="number of frames, open to closed (%(default)s)")
    add(
        "--format",
        choices=("stl", "obj", "png"),
        default="obj",
        help="format of the frames (%(default)s)",
    )
    add("--segments", type=int, default=10, help="segments per actuator (%(default)s)")
    add("--out", type=Path, default=SKIN_FOLDER, help="folder (%(default)s)")
    add("--figure", type=Path, help="write one picture (PNG) of first and last frame instead")
    add("--force", action="store_true", help="overwrite frames or figure of an earlier run")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the frames; returns 0, or 2 when the options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        hand = load_hand(options.hand)
        wanted = pressures(hand, options.pressure)
        if options.figure is not None:
            return _figure(hand, wanted, options)
        return _frames(hand, wanted, options)
    except ValueError as error:
        print(f"softhand skin: {error}", file=sys.stderr)
        return 2


def pressures(
    hand: HandDescription, given: list[float] | None, scale: float = 1.0, unit: str = "Pa"
) -> Array:
    """Gauge pressures (channels,) [Pa] from `given`: one number for all channels or one for each,
    in a unit of `scale` Pa. None: a share of each channel's limit, DEFAULT_PRESSURE_SHARE.

    Raises ValueError for a wrong number of them, and for one that is negative or above its
    channel's limit; `unit` is the unit's name in the message.
    """
    limits = hand.max_pressures()
    if given is None:
        return DEFAULT_PRESSURE_SHARE * limits
    if len(given) not in (1, len(limits)):
        raise ValueError(f"pressure: expected 1 or {len(limits)} numbers, got {len(given)}")
    found = scale * (np.full(len(limits), given[0]) if len(given) == 1 else np.array(given))
    if not np.all((found >= 0.0) & (found <= limits)):
        allowed, got = (", ".join(f"{x:.6g}" for x in row) for row in (limits / scale, given))
        raise ValueError(f"pressure: expected 0 to [{allowed}] {unit}, got [{got}]")
    return found


def _frames(hand: HandDescription, wanted: Array, options: argparse.Namespace) -> int:
    """One file a frame."""
    kind, folder = options.format, options.out
    paths = [folder / f"{hand.name}_{k:03d}.{kind}" for k in range(options.frames)]
    taken = [path for path in paths if path.exists()]
    if taken and not options.force:
        raise ValueError(f"{taken[0]}: expected no earlier run, got one; --force overwrites it")
    folder.mkdir(parents=True, exist_ok=True)
    write = _writer(kind, Renderer(hand, None, "stand", options.segments))
    frames = _closing(hand, wanted, options.frames, options.segments)
    for path, joints in zip(paths, frames, strict=True):
        write(path, joints)
        print(path)
    return 0


def _closing(hand: HandDescription, wanted: Array, frames: int, segments: int) -> Iterator[Array]:
    """Joint orientations (n, 4) of a hand at rest at pressures in even steps up to those wanted."""
    if frames < 2:
        raise ValueError(f"frames: expected 2 or more, got {frames}")
    return hand_at_rest(hand, np.outer(np.linspace(0.0, 1.0, frames), wanted), segments)


def _writer(kind: str, renderer: Renderer) -> Callable[[Path, Array], None]:
    """What writes joints (n, 4) as a file of a kind."""
    if kind == "png":
        return lambda path, joints: _save(path, _views(renderer, joints))
    return lambda path, joints: write_meshes(
        path, {name: mesh for name, (_, mesh) in renderer.skin.parts(joints).items()}
    )


def _figure(hand: HandDescription, wanted: Array, options: argparse.Namespace) -> int:
    """Open and closed side by side."""
    check_new(options.figure, options.force, (".png",))
    renderer = Renderer(hand, None, "stand", options.segments)
    first, *_, last = _closing(hand, wanted, 3, options.segments)
    _save(options.figure, np.hstack([_views(renderer, first), _views(renderer, last)]))
    print(options.figure)
    return 0


def _views(renderer: Renderer, joints: Array) -> NDArray[np.uint8]:
    """Pictures from the palm and from the side, in a row."""
    state = HandState(joints, *UPRIGHT)
    views = [
        renderer.frame(state, SKIN_PICTURE_SIZE, replace(SKIN_CAMERA, yaw=yaw, pitch=pitch))
        for yaw, pitch in VIEW_ANGLES
    ]
    return np.hstack(views)


def _save(path: Path, picture: NDArray[np.uint8]) -> None:
    from matplotlib.image import imsave  # an extra: meshes need no matplotlib

    with written_whole(path) as file:
        imsave(file, picture)


if __name__ == "__main__":
    sys.exit(main())
