"""A hand at rest over pressure, drawn to scale: its channels in colours, with dimensions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from pneuflex_sim.pictures.render import Camera, HandState, Renderer
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_model.chain.volumes import FreeVolumes
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import HandDescription

MILLI, KILO = 1e-3, 1e3
CHANNEL_PLOT_COLORS = tuple(f"C{k}" for k in range(10))  # of the channels
CAMERA_DISTANCE = 4.0  # [m] of the camera: what is 5 cm nearer looks 1.3 % larger
PIXELS_A_MM = 3.0
OVERSAMPLING = 2  # pixels that become one
HAND_BORDER = 0.012  # [m] around the hand
LEGEND_MARGIN = 0.015  # between legend and panels, share of the height
HAND_FIGURE_DPI = 110
INCHES_A_METRE = 22.0
HAND_CAPTION = "free air, no weight, no contact: what meets is drawn passing through"
UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])  # pose of the wrist
FREE_AIR_STEP = 0.002  # [s]
DRAWN_SEGMENTS = 5  # per actuator, by default
RAMP_TIME, SETTLE_TIME = 0.4, 0.8  # [s] between two pressures


def air_masses_at(hand: HandDescription, pressures: Array) -> Array:
    """Air (channels,) [kg above rest] in a free hand at gauge pressures (channels,) [Pa]."""
    return FreeVolumes(hand).air_masses(pressures)


def hand_at_rest(hand: HandDescription, pressures: Array, segments: int) -> Iterator[Array]:
    """Joint orientations (n, 4) of a weightless hand at rest, at each of the gauge pressures (k,
    channels) [Pa], which it takes one after the other, starting without pressure.
    """
    simulation = Simulation(
        SimulationConfig(
            hand=hand, scene="stand", model="base", step=FREE_AIR_STEP, segments=segments
        )
    )
    try:
        before = np.zeros(len(hand.channels))
        for wanted in pressures:
            after = air_masses_at(hand, wanted) if wanted.any() else np.zeros_like(before)
            if np.any(after != before):
                _fill(simulation, before, after)
            before = after
            yield simulation.bodies.q.copy()
    finally:
        simulation.close()


def _fill(simulation: Simulation, before: Array, after: Array) -> None:
    """Ramp the air masses (channels,) [kg] from `before` to `after`, and let the hand come to
    rest.
    """
    for k in range(round((RAMP_TIME + SETTLE_TIME) / FREE_AIR_STEP)):
        way = min(1.0, (k + 1) * FREE_AIR_STEP / RAMP_TIME)
        simulation.set_air_masses(before + way * (after - before))
        simulation.step()


@dataclass(frozen=True)
class View:
    """A level view: yaw of the camera [deg], the axis of the wrist that runs to the right (its
    name, index and sign), and the direction towards the light.
    """

    title: str
    yaw: float
    axis: str
    index: int
    sign: int
    light: tuple[float, float, float]


HAND_VIEWS = (
    View("from the palm", 90.0, "y", 1, 1, (1.6, -0.6, 1.2)),
    View("from the side", 180.0, "x", 0, -1, (0.6, 1.6, 1.2)),
)


def draw_hand(
    hand: HandDescription, pressures: Array, joints: Sequence[Array], segments: int
) -> Figure:
    """Picture of a hand at several pressures.

    pressures (k, channels) [Pa], gauge. joints: joint orientations (n, 4) at each pressure. Each
    pressure has one column: above, the view of the palm (along -x of the wrist); below, the view
    from the thumb's side (along -y).
    """
    renderer = Renderer(hand, None, "stand", segments, _colors(hand))
    corners = [_corners(renderer, q) for q in joints]
    low = np.min([corner[0] for corner in corners], axis=0) - HAND_BORDER
    high = np.max([corner[1] for corner in corners], axis=0) + HAND_BORDER
    figure, axes = _sheet(low, high, len(joints))
    for column, (wanted, q) in enumerate(zip(pressures, joints, strict=True)):
        axes[0][column].set_title(_pressure_text(hand, wanted), fontsize=10)
        for row, view in enumerate(HAND_VIEWS):
            picture = _photograph(renderer, q, view, low, high)
            _place(axes[row][column], picture, view, low, high)
            _measure(axes[row][column], view, *corners[column])
    _explain(figure, hand)
    return figure


def draw_beside(axes: Sequence[Axes], hands: Mapping[str, HandDescription]) -> None:
    """Draw hands at rest, by their titles, to one scale: each in two of the `axes`, first seen from
    the palm, then from the thumb's side.
    """
    renderers = [
        Renderer(hand, None, "stand", DRAWN_SEGMENTS, _colors(hand)) for hand in hands.values()
    ]
    joints = [
        next(hand_at_rest(hand, np.zeros((1, len(hand.channels))), DRAWN_SEGMENTS))
        for hand in hands.values()
    ]
    corners = [_corners(*both) for both in zip(renderers, joints, strict=True)]
    low = np.min([corner[0] for corner in corners], axis=0) - HAND_BORDER
    high = np.max([corner[1] for corner in corners], axis=0) + HAND_BORDER
    for number, title in enumerate(hands):
        for panel, view in zip(axes[2 * number : 2 * number + 2], HAND_VIEWS, strict=True):
            picture = _photograph(renderers[number], joints[number], view, low, high)
            _place(panel, picture, view, low, high)
            _measure(panel, view, *corners[number])
            panel.set_title(title, fontsize=10)


def channel_colors(hand: HandDescription) -> dict[str, str]:
    """Colour of each channel, by name."""
    return {
        name: CHANNEL_PLOT_COLORS[k % len(CHANNEL_PLOT_COLORS)]
        for k, name in enumerate(hand.channels)
    }


def _colors(hand: HandDescription) -> dict[str, tuple[float, float, float, float]]:
    """Colour of each actuator's surface."""
    colors = channel_colors(hand)
    return {
        name: to_rgba(colors[channel])
        for chain in hand.chains
        for name, channel in chain.channels.items()
    }


def _corners(renderer: Renderer, joints: Array) -> tuple[Array, Array]:
    """Least and greatest coordinates (3,) [m] of all surfaces."""
    points = np.vstack([mesh.vertices for _, mesh in renderer.skin.parts(joints).values()])
    return points.min(axis=0), points.max(axis=0)


def _photograph(
    renderer: Renderer, joints: Array, view: View, low: Array, high: Array
) -> NDArray[np.uint8]:
    """Picture of the box between two corners (3,) [m]."""
    size = high - low
    wide, tall = (OVERSAMPLING * round(PIXELS_A_MM / MILLI * size[k]) for k in (view.index, 2))
    camera = Camera(
        tuple(0.5 * (low + high)),
        CAMERA_DISTANCE,
        view.yaw,
        0.0,
        float(np.degrees(2.0 * np.arctan(0.5 * size[2] / CAMERA_DISTANCE))),
        view.light,
    )
    fine = renderer.frame(HandState(joints, *UPRIGHT), (wide, tall), camera)
    blocks = fine.reshape(tall // OVERSAMPLING, OVERSAMPLING, wide // OVERSAMPLING, OVERSAMPLING, 3)
    return blocks.mean(axis=(1, 3)).astype(np.uint8)


def _sheet(low: Array, high: Array, columns: int) -> tuple[Figure, NDArray]:
    """An empty figure to scale, and its axes (2, columns)."""
    wide = INCHES_A_METRE * max((high - low)[view.index] for view in HAND_VIEWS) + 0.7
    tall = INCHES_A_METRE * (high - low)[2] + 0.6
    figure = Figure(
        figsize=(columns * wide, 2.0 * tall + 1.2), dpi=HAND_FIGURE_DPI, layout="constrained"
    )
    return figure, figure.subplots(2, columns, squeeze=False)


def _place(axes: Axes, picture: NDArray[np.uint8], view: View, low: Array, high: Array) -> None:
    """The picture on axes in mm."""
    across = np.array([low[view.index], high[view.index]])[:: view.sign] / MILLI
    axes.imshow(picture, extent=(*across, low[2] / MILLI, high[2] / MILLI))
    axes.set_xlabel(f"{view.axis} [mm], {view.title}", fontsize=8)
    axes.set_ylabel("z [mm]", fontsize=8)
    axes.tick_params(labelsize=7)


def _measure(axes: Axes, view: View, low: Array, high: Array) -> None:
    """Arrows over the whole width and height between two corners (3,) [m], with lengths [mm]."""
    left, right = low[view.index] / MILLI, high[view.index] / MILLI
    bottom, top = low[2] / MILLI, high[2] / MILLI
    gap = 0.5 * HAND_BORDER / MILLI
    beside = right + gap if view.sign > 0 else left - gap
    for start, stop in (((left, top + gap), (right, top + gap)), ((beside, bottom), (beside, top))):
        axes.annotate("", start, stop, arrowprops={"arrowstyle": "<->", "lw": 0.7})
        x, y = np.mean([start, stop], axis=0)
        axes.text(
            x,
            y,
            f"{np.linalg.norm(np.subtract(start, stop)):.0f}",
            fontsize=7,
            rotation=90 if start[0] == stop[0] else 0,
            ha="center",
            va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        )


def _pressure_text(hand: HandDescription, pressures: Array) -> str:
    if not pressures.any():
        return "at rest"
    if np.ptp(pressures) == 0.0:
        return f"{pressures[0] / KILO:.3g} kPa"
    named = zip(hand.channels, pressures, strict=True)
    return ", ".join(f"{name} {pressure / KILO:.3g}" for name, pressure in named) + " kPa"


def _explain(figure: Figure, hand: HandDescription) -> None:
    """Add the legend of channels by colour, and the sizes of the actuators."""
    fed: dict[str, list[str]] = {name: [] for name in hand.channels}
    kinds: dict[str, Actuator] = {}
    for chain in hand.chains:
        for name, actuator in chain.actuators.items():
            fed[chain.channels[name]].append(name)
            kinds[actuator.name] = actuator
    colors = channel_colors(hand)
    patches = [
        Patch(color=colors[name], label=f"{name}: {', '.join(actuators)}")
        for name, actuators in fed.items()
    ]
    figure.suptitle(
        "\n".join([hand.name, *(_sizes(actuator) for actuator in kinds.values())]), fontsize=8
    )
    legend = figure.legend(
        handles=patches, loc="lower center", ncols=2, fontsize=8, title=HAND_CAPTION
    )
    legend.get_title().set_fontsize(8)
    share = legend.get_window_extent().height / figure.bbox.height + LEGEND_MARGIN
    figure.set_layout_engine("constrained", rect=(0.0, share, 1.0, 1.0 - share))


def _sizes(actuator: Actuator) -> str:
    """One line of an actuator's sizes."""
    ends = np.array([0.0, actuator.length])
    high, wide, wall, _ = (
        " to ".join(dict.fromkeys(f"{size / MILLI:.3g}" for size in sizes))
        for sizes in actuator.sides(ends)
    )
    return (
        f"{actuator.name}: {actuator.length / MILLI:.3g} mm long, {high} mm high, {wide} mm wide, "
        f"wall {wall} mm, G {actuator.shear_modulus / KILO:.3g} kPa, "
        f"up to {actuator.max_pressure / KILO:.3g} kPa"
    )
