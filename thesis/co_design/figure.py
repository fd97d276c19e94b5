"""Figure of the co-design: learning curves, held-out success, both hands."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from softhand_common.documents.output_file import write_file
from softhand_model.hand.hand import load_hand
from thesis.co_design import hands
from thesis.co_design.arms import ARMS
from thesis.co_design.hands import hand_text
from thesis.co_design.statistics import interval
from thesis.frame import Axes, Figure, Results

COLORS = {"co-design": "tab:green", "motion": "tab:blue", "hand": "tab:orange", "random": "0.5"}
OTHER = "tab:red"  # negative controls
UNITS = {"taper": (1.0, ""), "thumb_angle": (180.0 / np.pi, "deg"), "palm_wall_ratio": (1.0, "")}
IN_MM = (1e3, "mm")
WIDTHS, TABLE_WIDTH = (2.6, 1.0), 2.3  # of both views of a hand, on one scale, and of the table


def draw_courses(axes: Axes, results: Results) -> None:
    """Best score over trials: thin lines for seeds, a thick one for their mean."""
    for arm in ARMS:
        found = [one["course"] for one in results["searches"].values() if one["arm"] == arm.name]
        curves = [np.array(curve, float) for curve in found]
        for curve in curves:
            axes.step(*curve.T, where="post", color=COLORS[arm.name], alpha=0.3, linewidth=0.8)
        mean = np.mean([curve[:, 1] for curve in curves], axis=0)
        axes.step(curves[0][:, 0], mean, where="post", color=COLORS[arm.name], label=arm.name)
    shipped = np.mean([one["training"]["score"] for one in results["shipped"]])
    axes.axhline(shipped, color="k", linestyle=":", label="shipped pair")
    axes.set(xlabel="trials", ylabel="best score in training (1.25: all)", ylim=(0.0, 1.3))
    axes.legend(fontsize=8, loc="lower right")


def draw_shares(axes: Axes, shares: Mapping[str, Sequence[float]]) -> None:
    """Held-out success of each arm's winners: dots for seeds, mean and interval."""
    for place, (name, values) in enumerate(shares.items()):
        found = interval(values)
        low, high = np.clip(found[1:], 0.0, 1.0)
        color = COLORS.get(name, "k" if name == "shipped" else OTHER)
        axes.plot([place] * len(values), values, ".", color=color, alpha=0.5)
        spread = [[found.mean - low], [high - found.mean]]
        axes.errorbar(place + 0.15, found.mean, spread, marker="o", capsize=3, color=color)
    axes.set_xticks(range(len(shares)), list(shares), rotation=25, ha="right", fontsize=9)
    axes.set(ylabel="held-out success", ylim=(-0.02, 1.02))


def draw_hands(figure: Figure, chosen: Mapping[str, Mapping[str, float]]) -> None:
    """Hands by their numbers, drawn to the same scale, with the numbers."""
    from pneuflex_sim.pictures.hand_picture import draw_beside

    with tempfile.TemporaryDirectory() as folder:
        made = {}
        for name, values in chosen.items():
            path = Path(folder) / f"{name}.yaml"
            write_file(path, hand_text(values))
            made[name] = load_hand(path)
    axes = figure.subplots(1, 2 * len(made) + 1, width_ratios=[*WIDTHS * len(made), TABLE_WIDTH])
    draw_beside(axes[:-1], made)
    axes[-1].set_axis_off()
    rows = [_row(variable.name, chosen.values()) for variable in hands.VARIABLES]
    table = axes[-1].table(rows, colLabels=["", *chosen], loc="center", edges="horizontal")
    table.auto_set_font_size(False)
    table.set_fontsize(8)
    table.auto_set_column_width(range(1 + len(chosen)))


def _row(name: str, chosen: object) -> list[str]:
    scale, unit = UNITS.get(name, IN_MM)
    words = f"{name.replace('_', ' ')} [{unit}]" if unit else name.replace("_", " ")
    return [words, *(f"{scale * values[name]:.3g}" for values in chosen)]  # type: ignore[attr-defined]
