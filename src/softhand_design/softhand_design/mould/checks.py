"""Checks whether a mould can be printed, filled and opened, measured on its finished files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_design.mould import measure
from softhand_design.mould.measure import Finished
from softhand_design.mould.volume import corrections
from softhand_model.hand.actuator import Actuator

RAYS, WALLS, GAPS = 10_000, 1_000, 500
OVERLAP = 0.1  # of the closed parts [mm3]
VOLUME = 1.0  # of the rubber [%]
DRAFT = (2.8, 3.2)  # [deg], whatever was asked for
WALL = 0.1  # [mm]
GROOVE = 0.1  # of their depth [mm]
STEP = 0.05  # of the step from crest to trough [mm]
STANDS = 0.5  # of the mould's cross section; without a foot the rim's nose has less than a tenth
TOUCHING = 0.005  # parts that touch may seem to overlap by [mm]
MM3 = 1e9  # in a m3


@dataclass(frozen=True)
class Check:
    """A measured value and its limits; None for a limit that does not exist."""

    name: str
    value: float
    unit: str
    low: float | None = None
    high: float | None = None

    @property
    def passed(self) -> bool:
        """Whether the value lies within its limits."""
        above = self.low is None or self.value >= self.low
        return above and (self.high is None or self.value <= self.high)

    @property
    def limits(self) -> str:
        """The limits as text.

        >>> Check("draft", 3.0, "deg", 2.8, 3.2).limits
        '2.8 to 3.2'
        """
        if self.low is not None and self.high is not None:
            same = self.low == self.high
            return f"{self.low:g}" if same else f"{self.low:g} to {self.high:g}"
        if self.low is not None:
            return f">= {self.low:g}"
        return "" if self.high is None else f"<= {self.high:g}"

    def record(self) -> dict[str, Any]:
        """The check as plain data."""
        limits = {"low": self.low, "high": self.high, "passed": self.passed}
        return {"name": self.name, "value": self.value, "unit": self.unit} | limits


def table_row(name: str, value: str, unit: str, limit: str, verdict: str) -> str:
    """A row of a table of checks."""
    return f"{name:<62}{value:>10} {unit:<5}{limit:<14}{verdict}".rstrip()


def check_lines(checks: Sequence[Check]) -> list[str]:
    """Checks as rows of text, below a head."""
    rows = [table_row("check", "value", "", "limit", "")]
    for check in checks:
        verdict = "" if check.passed else "FAILS"
        rows.append(table_row(check.name, f"{check.value:.4g}", check.unit, check.limits, verdict))
    return rows


def shown_failures(checks: Sequence[Check]) -> str:
    """Name, value and limits of checks that were not passed."""
    return "; ".join(
        f"{check.name} {check.value:.3g} {check.unit}".rstrip() + f" (expected {check.limits})"
        for check in checks
    )


@dataclass(frozen=True)
class Volumes:
    """Volumes of rubber [mm3]: `model` of the model's top and side walls, `corrections` that each
    feature adds, `measured` between the parts; and of the chamber [mm3]: `chamber_model` of the
    model, `chamber` as measured.
    """

    model: float
    corrections: dict[str, float]
    measured: float
    chamber_model: float
    chamber: float

    @property
    def expected(self) -> float:
        """The model's rubber with all corrections [mm3]."""
        return self.model + sum(self.corrections.values())


def rubber_volumes(found: Finished, actuator: Actuator) -> Volumes:
    """Volumes of rubber and chamber of a mould, and those of the model."""
    mould = found.mould
    scale = mould.parameters.scale
    listed = corrections(mould)
    model = actuator.rubber_volume() * MM3
    listed["shrinkage"] = (model + sum(listed.values())) * (scale**3 - 1.0)
    return Volumes(
        model, listed, found.cast.volume(), actuator.chamber_volume() * MM3, _chamber(found)
    )


def _chamber(found: Finished) -> float:
    """Volume [mm3] of the core above the plane of the passive layer, without its step, in the cured
    rubber's size.
    """
    mould = found.mould
    line, used = mould.line, mould.parameters
    _, low_y, _, high_x, high_y, high_z = found.core.bounding_box()
    box = found.core.cube((high_x, high_y - low_y, high_z)).translate((0.0, low_y, 0.0))
    risen = (box ^ found.core).decompose()
    # what stands on the plate besides the chambers are crests of the step, lower than any roof
    least = min(float(line.roof(np.linspace(*ends, 9)).min()) for ends in mould.chambers)
    rooms = [part.volume() for part in risen if part.bounding_box()[5] > max(used.step, least / 2)]
    return sum(rooms) / used.scale**3


def check_mould(found: Finished, volumes: Volumes) -> list[Check]:
    """All checks of a mould, and the measured volumes of its rubber."""
    return [*_solids(found), *_opening(found), *_sizes(found, volumes), *_features(found)]


def _solids(found: Finished) -> Iterator[Check]:
    for name, mesh, solid in (
        ("shell", found.shell_mesh, found.shell),
        ("core", found.core_mesh, found.core),
    ):
        yield Check(f"{name}: watertight", float(mesh.is_watertight), "", 1.0)
        yield Check(f"{name}: bodies", float(mesh.body_count), "", 1.0, 1.0)
        yield Check(f"{name}: handles", float(solid.genus()), "", 0.0, 0.0)
        yield Check(f"{name}: volume", float(mesh.volume) / 1e3, "cm3", 1e-3)
    common = (found.shell ^ found.core).volume()
    yield Check("closed parts: overlap", common, "mm3", None, OVERLAP)


def _opening(found: Finished) -> Iterator[Check]:
    for name, solid in (("shell", found.shell), ("core", found.core)):
        entered = measure.plan_rays(solid, RAYS)
        yield Check(f"{name}: undercut, times a ray enters", float(entered.max()), "", None, 1.0)
        gaps = measure.tilted_rays(solid, found.mould, RAYS)
        share = 100.0 * float(np.mean(gaps > 0.0))
        yield Check(f"{name}: undercut, rays caught 1 deg off the pull", share, "%", None, 0.0)
        yield Check(f"{name}: undercut, deepest gap", float(gaps.max()), "mm")
    angle, area = measure.draft_angles(found)
    known = len(angle) > 0  # without any wall the mean is no number and passes no limit
    yield Check("draft, mean", float(angle @ area / area.sum()) if known else np.nan, "deg", *DRAFT)
    yield Check("draft, least", float(angle.min(initial=np.inf)), "deg", *DRAFT)
    yield Check("draft, largest", float(angle.max(initial=-np.inf)), "deg", *DRAFT)


def _sizes(found: Finished, volumes: Volumes) -> Iterator[Check]:
    off = 100.0 * (volumes.measured / volumes.expected - 1.0)
    yield Check("rubber: off the corrected model", off, "%", -VOLUME, VOLUME)
    yield Check("fillet, as large as the chamber allows", found.mould.fillet, "mm")
    measured, wanted = measure.walls(found, WALLS)
    off = float(np.abs(measured - wanted).max())
    yield Check("wall: furthest off the design", off, "mm", None, WALL)
    yield Check("wall: thinnest", float(measured.min()), "mm")
    yield Check("top wall across its slope", float(measure.top_across_slope(found).min()), "mm")
    measured, wanted = measure.end_walls(found)
    off = float(np.abs(measured - wanted).max())
    yield Check("ends: on the middle line off the design", off, "mm", None, WALL)
    measured, due = measure.around_ends(found)
    yield Check("ends: least rubber", float(measured.min()), "mm")
    yield Check("ends: short of plug or side wall", float((due - measured).max()), "mm", None, WALL)


def _features(found: Finished) -> Iterator[Check]:
    used = found.mould.parameters
    near = (used.groove_depth - GROOVE, used.groove_depth + GROOVE)
    depth, nubs = measure.groove_depths(found), measure.nub_heights(found)
    yield Check("grooves: shallowest", float(depth.min()), "mm", *near)
    yield Check("grooves: deepest", float(depth.max()), "mm", *near)
    yield Check("nubs: lowest", float(nubs.min()), "mm", *near)
    yield Check("nubs: highest", float(nubs.max()), "mm", *near)
    gaps, heights = measure.interface_gaps(found, GAPS)
    step = 2.0 * used.step * used.scale
    near = (step - STEP, step + STEP)
    yield Check("interface: step, crest over trough", float(np.ptp(heights)), "mm", *near)
    yield Check("interface: least gap", float(gaps.min()), "mm", -TOUCHING)
    most = used.clearance * used.scale + TOUCHING
    yield Check("interface: largest gap", float(gaps.max()), "mm", None, most)
    yield Check("foot: share of the front it stands on", measure.foot_share(found), "", STANDS)
