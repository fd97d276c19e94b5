"""The two pictures of a grasp, drawn from its bag: quantities over time, and a contact sheet."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from softhand_bringup.bags.reading import Bag, Command, latest_index
from softhand_common.documents.output_file import save_figure
from softhand_common.numerics.arrays import Array

matplotlib.use("Agg")  # also without a display
if TYPE_CHECKING:  # PyBullet talks to the terminal when it is imported
    from pneuflex_sim.pictures.render import HandState
COMMAND_TOPIC = "/pneumaticbox/command"
STATE_TOPIC = "/pneumaticbox/state"
OBJECT_TOPIC = "/scene/object_pose"
WRIST_TOPIC = "/wrist/pose"
JOINTS_TOPIC = "/hand/joint_states"
PHASE_TOPIC = "/grasp/phase"
BETWEEN_GRASPS = ("idle", "done")  # what the sequencer publishes before and after a grasp

HAND_LENGTH = 0.2  # of an upright hand [m]
FRAME_COUNT = 8
FRAME_SIZE = (560, 420)  # [pixels]
PHASE_MARGIN = 0.5  # [s] shown before the first and after the last phase


def commanded_masses(commands: Sequence[Command], channels: Sequence[str], time: Array) -> Array:
    """Commanded air mass of every channel (k, n) [kg] at the times (k,) [s].

    A command replaces earlier ones from its start on. Between its points the mass is interpolated
    linearly, beginning with the value commanded before; the last point is held. Before the first
    command the mass is zero, the filling at rest.

    Args:
        commands: commands in order of reception; their positions are masses [kg].
        channels: names of the channels, in the order of the columns; a channel that a command does
            not name keeps its earlier command.
        time: rising times [s].
    """
    masses = np.zeros((len(time), len(channels)))
    for command in commands:
        after = time >= command.start
        for column, channel in enumerate(channels):
            if channel in command.names and command.position.size:
                points = command.position[:, command.names.index(channel)]
                begin = float(np.interp(command.start, time, masses[:, column]))
                masses[after, column] = _follow(command, points, begin, time[after])
    return masses


def _follow(command: Command, points: Array, begin: float, time: Array) -> Array:
    times = command.time_from_start
    if times[0] > 0.0:
        times, points = np.concatenate([[0.0], times]), np.concatenate([[begin], points])
    return np.interp(time - command.start, times, points)


@dataclass(frozen=True)
class Phase:
    """A phase of the strategy with its start and end [s]."""

    name: str
    start: float
    end: float


def phases(texts: Sequence[tuple[float, str]], end: float) -> list[Phase]:
    """Phases from the messages of `grasp/phase`; each lasts until the next, the last until `end`.

    >>> phases([(0.5, "idle"), (1.0, "approach"), (3.0, "close"), (4.0, "done")], 5.0)[1]
    Phase(name='close', start=3.0, end=4.0)
    """
    ends = [*(time for time, _ in texts[1:]), end]
    spans = zip(texts, ends, strict=False)  # without texts there is no span either
    return [Phase(name, start, stop) for (start, name), stop in spans if name not in BETWEEN_GRASPS]


def draw_grasp(bag: Bag, path: Path) -> None:
    """Draw commanded and contained air mass, gauge pressure and object height over time, with the
    phases.

    Raises:
        ValueError: a required topic has no messages.
    """
    state, height = bag.joints(STATE_TOPIC), bag.poses(OBJECT_TOPIC)
    marks = phases(bag.texts(PHASE_TOPIC), float(state.time[-1]))
    commanded = commanded_masses(bag.commands(COMMAND_TOPIC), state.names, state.time)
    figure, (air, pressure, lift) = plt.subplots(
        3, 1, figsize=(10, 8), sharex=True, layout="constrained", height_ratios=(3, 2, 2)
    )
    for column, channel in enumerate(state.names):
        color = f"C{column}"
        air.plot(state.time, 1e6 * commanded[:, column], "--", color=color, linewidth=1)
        air.plot(state.time, 1e6 * state.position[:, column], color=color, label=channel)
        pressure.plot(state.time, 1e-3 * state.effort[:, column], color=color, label=channel)
    lift.plot(height.time, 1e3 * (height.position[:, 2] - height.position[0, 2]), color="k")
    air.set_ylabel("air mass above rest [mg]\ndashed: commanded, solid: contained")
    pressure.set_ylabel("gauge pressure [kPa]")
    lift.set_ylabel("object above start [mm]")
    lift.set_xlabel("simulated time [s]")
    air.legend(title="channel", loc="center left")
    _mark_phases((air, pressure, lift), marks)
    save_figure(figure, path, dpi=110)
    plt.close(figure)


def _mark_phases(axes: Sequence[Axes], marks: Sequence[Phase]) -> None:
    for number, phase in enumerate(marks):
        for axis in axes:
            axis.axvspan(
                phase.start, phase.end, color="0.5", alpha=0.12 * (number % 2), linewidth=0
            )
        axes[0].annotate(
            phase.name,
            (0.5 * (phase.start + phase.end), 1.02),
            xycoords=("data", "axes fraction"),
            rotation=30,
            fontsize=8,
            annotation_clip=False,
        )
    if marks:
        axes[0].set_xlim(max(0.0, marks[0].start - PHASE_MARGIN), marks[-1].end)


def frame_times(marks: Sequence[Phase], last: float, count: int = FRAME_COUNT) -> Array:
    """Times of the pictures (count,) [s]: the ends of the phases, from which times are left out or
    to which times are added until there are `count`.

    Of too many ends, those closest to the end before them are left out; if there are too few, the
    longest gaps are halved.

    >>> frame_times([Phase("a", 0.0, 1.0), Phase("b", 1.0, 4.0)], 4.0, 4).tolist()
    [1.0, 1.75, 2.5, 4.0]
    """
    times = sorted({min(phase.end, last) for phase in marks})
    if len(times) < 2:
        times = [0.0, last]
    while len(times) > count:
        del times[1 + int(np.argmin(np.diff(times)))]
    while len(times) < count:
        gap = int(np.argmax(np.diff(times)))
        times.insert(gap + 1, 0.5 * (times[gap] + times[gap + 1]))
    return np.array(times)


def draw_frames(
    bag: Bag,
    path: Path,
    hand: str,
    object_name: str,
    scene: str,
    wall_inclination: float | None = None,
) -> None:
    """Draw one picture with rendered frames of the grasp, each with its phase and time.

    Args:
        bag: bag of the grasp.
        path: file of the picture.
        hand, object_name, scene: names or files with which the grasp was recorded.
        wall_inclination: inclination of the wall [deg]; None: that of the scene.

    Raises:
        ValueError: a required topic has no messages, or a name does not exist.
    """
    from pneuflex_sim.pictures.render import Camera, Renderer
    from pneuflex_sim.scene.scenes import load_scene

    joints = bag.joints(JOINTS_TOPIC)
    marks = phases(bag.texts(PHASE_TOPIC), float(joints.time[-1]))
    times = frame_times(marks, float(joints.time[-1]))
    segments = recorded_segments(hand, joints.names)
    shown = load_scene(scene).inclined(wall_inclination)
    yaw = 62.0 if shown.wall is None else -62.0  # on the free side of a wall
    if shown.table is None:  # the object is held in the air
        target = _middle(bag.poses(WRIST_TOPIC).position, HAND_LENGTH / 2)
    else:
        target = _centre(bag.poses(OBJECT_TOPIC).position)
    camera = Camera(target=target, distance=0.55, yaw=yaw, pitch=-16.0)
    renderer = Renderer(hand, object_name, shown, segments)
    frames = [renderer.frame(state, FRAME_SIZE, camera) for state in recorded_states(bag, times)]
    _save_sheet(frames, [_caption(marks, time) for time in times], path)


def recorded_states(bag: Bag, times: Array) -> list[HandState]:
    """The latest recorded state at each of these times (k,) [s].

    Raises:
        ValueError: a required topic has no messages.
    """
    from pneuflex_sim.pictures.render import HandState
    from pneuflex_sim.urdf import joint_orientations

    joints = bag.joints(JOINTS_TOPIC)
    wrist, thing = bag.poses(WRIST_TOPIC).at(times), bag.poses(OBJECT_TOPIC).at(times)
    return [
        HandState(
            joint_orientations(joints.position[row]),
            wrist.position[k],
            wrist.orientation[k],
            thing.position[k],
            thing.orientation[k],
        )
        for k, row in enumerate(latest_index(joints.time, times))
    ]


def _centre(path: Array) -> tuple[float, float, float]:
    """The camera's target [m] in all pictures: the start, at half the height of the lift."""
    x, y, _ = path[0].tolist()
    _, _, z = _middle(path, 0.04)
    return x, y, z


def _middle(path: Array, above: float) -> tuple[float, float, float]:
    """Center of the bounding box of a path (k, 3) [m], moved up by `above` [m]."""
    x, y, z = (0.5 * (path.min(axis=0) + path.max(axis=0))).tolist()
    return x, y, z + above


def recorded_segments(hand: str, joint_names: Sequence[str]) -> int:
    """Number of segments of each actuator in a recorded run, found from the names of its joints.

    Raises ValueError when no number of segments gives these joints.
    """
    from pneuflex_sim.hand.layout import build_layout
    from pneuflex_sim.urdf import joint_names as names_of
    from softhand_model.hand.hand import load_hand
    from softhand_model.model_file import load_model

    for segments in range(1, 16):
        if names_of(build_layout(load_hand(hand), segments, load_model(None))) == list(joint_names):
            return segments
    raise ValueError(
        f"hand: expected a recording of {hand}, got one with {len(joint_names)} other joints; name "
        "the hand that was recorded"
    )


def _caption(marks: Sequence[Phase], time: float) -> str:
    name = next((m.name for m in marks if m.start <= time <= m.end), "")
    return f"{name}  {time:.2f} s".strip()


def _save_sheet(frames: Sequence[NDArray[np.uint8]], captions: Sequence[str], path: Path) -> None:
    columns = 4 if len(frames) > 6 else 3
    rows = -(-len(frames) // columns)
    width, height = FRAME_SIZE
    figure, axes = plt.subplots(
        rows, columns, figsize=(3.4 * columns, (3.4 * height / width + 0.3) * rows),
        squeeze=False, layout="constrained",
    )  # fmt: skip
    for axis in axes.flat:
        axis.axis("off")
    for axis, frame, caption in zip(axes.flat, frames, captions, strict=False):
        axis.imshow(frame)
        axis.set_title(caption, fontsize=9)
    save_figure(figure, path, dpi=150)
    plt.close(figure)


def main(arguments: list[str] | None = None) -> int:
    """Draw both pictures of a bag: `python -m softhand_bringup.figures <bag> <folder>`."""
    parser = argparse.ArgumentParser(
        prog="softhand figures", description="Draw the pictures of a grasp."
    )
    parser.add_argument("bag", type=Path)
    parser.add_argument("folder", type=Path, help="where grasp.png and frames.png go")
    parser.add_argument("--hand", default="rbo_hand_2")
    parser.add_argument("--object", default="cylinder")
    parser.add_argument("--scene", default="table")
    parser.add_argument("--wall-inclination", type=float, help="of the scene's wall [deg]")
    options = parser.parse_args(arguments)
    try:
        with Bag(options.bag) as bag:
            options.folder.mkdir(parents=True, exist_ok=True)
            draw_grasp(bag, options.folder / "grasp.png")
            draw_frames(
                bag,
                options.folder / "frames.png",
                options.hand,
                options.object,
                options.scene,
                options.wall_inclination,
            )
    except (OSError, ValueError) as error:
        print(f"figures: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
