"""Report on posture against actuation, and its figure (8.2.3, 8.2.4, Figs 8.14, 8.15)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from thesis.chapter_8.posture_variance import (
    INTERACTION,
    LINEAR,
    Estimate,
    GraspPostures,
    components_to,
    correlations,
    participation_ratio,
)
from thesis.frame import Array, Figure, Finding, Report, Results, number

HELD, EMPTY = "held", "empty"
SIZE = (12.0, 5.6)


def postures(results: Results) -> GraspPostures:
    """The analysis of what was run."""
    return GraspPostures(
        results["actuation"],
        results[HELD],
        results[EMPTY],
        int(results["resamples"]),
        int(results["seed"]),
    )


def told(results: Results) -> Report:
    """Dimensions of postures and actuation, and what of the difference is interaction."""
    found = postures(results)
    mean = {name: getattr(found, name).mean(axis=0) for name in (HELD, EMPTY)}
    counted = {name: components_to(points) for name, points in mean.items()}
    ratios = {name: participation_ratio(points) for name, points in mean.items()}
    findings = [
        _grasps(results),
        Finding(
            "principal components to 95 % of the variance",
            "a picture",
            f"{counted[HELD]} of postures, {counted[EMPTY]} in the empty hand, "
            f"{components_to(found.actuation)} of actuation",
        ),
        Finding(
            "participation ratio",
            "-",
            f"{ratios[HELD]:.2f} of postures, {ratios[EMPTY]:.2f} in the empty hand, "
            f"{participation_ratio(found.actuation):.2f} of actuation",
        ),
        _beyond(found),
        _empty(found),
        _excess(found),
        _unpredicted(found),
        _noise(found),
        _correlated(found),
        *(_human(name, curve) for name, curve in results["human"].items()),
    ]
    return Report(findings, _conclusion(found))


def _conclusion(found: GraspPostures) -> str:
    if found.kind == LINEAR:
        return "Postures span no more dimensions than their actuation, but for noise."
    if found.kind == INTERACTION:
        return (
            "Postures span more dimensions than their actuation, and more than those of the empty "
            "hand: the object adds to them."
        )
    return (
        "Postures span more dimensions than their actuation, but so do those of the empty hand: "
        "that the object adds to them is not shown."
    )


def _grasps(results: Results) -> Finding:
    reasons: dict[str, list[str]] = {}
    for kind in sorted(results["left_out"], key=int):
        reasons.setdefault(results["left_out"][kind], []).append(kind)
    left_out = "; ".join(f"{', '.join(kinds)} ({reason})" for reason, kinds in reasons.items())
    types = ", ".join(map(str, results["types"]))
    ours = f"{len(results['types'])}: {types}; left out: {left_out or 'none'}"
    return Finding("grasps", "31, without 5 and 19", ours, None, len(results["types"]))


def _interval(found: Estimate) -> str:
    return (
        f"{100 * found.value:.2g} % of the variance "
        f"(95 %: {100 * found.low:.2g} to {100 * found.high:.2g})"
    )


def _beyond(found: GraspPostures) -> Finding:
    share = found.beyond[HELD]
    ours = (
        f"{_interval(share)}, {1e3 * found.beyond_length(HELD):.1f} mm, of which the noise floor "
        f"is {100 * found.floor(HELD)[found.channels]:.2g} %; above it: p = {share.p:.2g} (< 0.05)"
    )
    what = f"postures beyond {found.channels} components"
    return Finding(what, "more than actuation", ours, share.shown, 100 * share.value, "%")


def _empty(found: GraspPostures) -> Finding:
    share = found.beyond[EMPTY]
    ours = f"{_interval(share)}, {1e3 * found.beyond_length(EMPTY):.1f} mm"
    return Finding("the same in the empty hand", "-", ours, None, 100 * share.value, "%")


def _excess(found: GraspPostures) -> Finding:
    excess = found.excess
    told = f"{_interval(excess)}, paired bootstrap p = {excess.p:.2g} (< 0.05)"
    ours = told if excess.shown else f"not shown: {told}"
    what = "with object more than in the empty hand"
    return Finding(what, "said, no control", ours, excess.shown, 100 * excess.value, "%")


def _unpredicted(found: GraspPostures) -> Finding:
    shares, excess = found.unpredicted, found.unpredicted_excess
    ours = (
        f"{100 * shares[HELD]:.0f} % of the variance, {100 * shares[EMPTY]:.0f} % in the empty "
        f"hand; more with object: p = {excess.p:.2g}"
    )
    what = "not predicted from the four channels (cross-validated Gaussian process)"
    return Finding(what, "-", ours, None, 100 * shares[HELD], "%")


def _noise(found: GraspPostures) -> Finding:
    rms = {
        name: 1e3 * float(np.sqrt(np.mean((trials[0] - trials[1]) ** 2) / 2.0))
        for name, trials in ((HELD, found.held), (EMPTY, found.empty))
    }
    ours = f"{rms[HELD]:.2f} mm with object, {rms[EMPTY]:.2f} mm without"
    what = "noise of a trial, rms of a coordinate"
    return Finding(what, "0.05 mm of the cameras", ours, None, rms[HELD], "mm")


def _correlated(found: GraspPostures) -> Finding:
    r = correlations(found.actuation)
    first, second = max(
        zip(*np.triu_indices(found.channels, 1), strict=True), key=lambda pair: abs(r[pair])
    )
    what = f"largest correlation of two channels, {'abcd'[first]} and {'abcd'[second]}"
    return number(what, float(r[first, second]), "", "no obvious ones")


def _human(name: str, curve: Sequence[float]) -> Finding:
    beyond = 100 * curve[min(4, len(curve) - 1)]
    to = int(np.argmax(np.array(curve) <= 0.05))
    ours = f"{to} components to 95 %, {beyond:.2g} % beyond four"
    return Finding(f"people: {name}", "like the hand", ours, None, beyond, "%")


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """Residual variances over components; the channels against each other."""
    found = postures(results)
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1.0))
    _draw_residuals(left.subplots(), found, results["human"])
    _draw_channels(right, found.actuation, results["types"])


def _draw_residuals(panel: Any, found: GraspPostures, human: Mapping[str, Sequence[float]]) -> None:
    looks = {HELD: ("tab:blue", "o", "with object"), EMPTY: ("tab:orange", "s", "empty hand")}
    for name, curve in human.items():
        panel.plot(100 * np.array(curve), "-", color="0.7", linewidth=0.8, label=f"people: {name}")
    for name, (color, marker, label) in looks.items():
        curve, low, high = (100 * part for part in found.curve(name))
        panel.plot(curve, marker=marker, color=color, label=f"posture, {label}")
        panel.fill_between(
            range(len(curve)), np.maximum(low, 1e-9), high, color=color, alpha=0.2, linewidth=0
        )
        panel.plot(100 * found.floor(name), ":", color=color, label=f"noise, {label}")
    panel.plot(100 * found.actuation_curve(), "k--", marker="^", label="actuation")
    panel.axvline(found.channels, color="0.8", linewidth=0.8, zorder=0)
    panel.set(yscale="log", xlim=(0, found.held.shape[-1] - 1), ylim=(1e-3, 130))
    panel.set(xlabel="principal components", ylabel="variance that is left [%]")
    panel.set_title(f"{len(found.actuation)} grasps (Fig. 8.14)", fontsize=10)
    panel.legend(fontsize=8)


def _draw_channels(figure: Any, actuation: Array, types: Sequence[int]) -> None:
    count = actuation.shape[1]
    panels, r = figure.subplots(count, count, sharex=True), correlations(actuation)
    figure.suptitle("inflation of the channels, shares of their limits (Fig. 8.15)", fontsize=10)
    for row in range(count):
        for column in range(count):
            panel = panels[row, column]
            panel.set(xticks=(0, 0.5, 1), xlim=(-0.05, 1.05))
            if row == column:
                panel.hist(actuation[:, row], bins=np.linspace(0, 1, 11), color="0.6")
                panel.set_yticks([])
            elif row > column:
                panel.plot(actuation[:, column], actuation[:, row], "ko", markersize=4, alpha=0.4)
                panel.set(yticks=(0, 0.5, 1), ylim=(-0.05, 1.05))
            else:
                panel.text(0.5, 0.5, f"r = {r[row, column]:.2f}", ha="center", va="center")
                panel.set(yticks=[], ylim=(0, 1))
            if column > 0:
                panel.set_yticklabels([])
            if column == 0:
                panel.set_ylabel("abcd"[row])
            if row == count - 1:
                panel.set_xlabel("abcd"[column])
