"""Variants of a strategy, for negative controls: without phases, with less air, displaced."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from grasp_strategies.strategy import Phase, Strategy, Vector
from softhand_common.documents.quoted import listed

# frames in which a goal stands anew, not from the last one
DISPLACED_FRAMES = ("object", "environment")


def varied(
    strategy: Strategy,
    without: Iterable[str] = (),
    air_scale: float = 1.0,
    displacement: Vector = (0.0, 0.0, 0.0),
) -> Strategy:
    """A modified copy of a strategy.

    Args:
        strategy: the original.
        without: names of the phases that are left out.
        air_scale: factor on commanded air masses and pressures [-]; 0: nothing is inflated.
        displacement: shift (x, y, z) [m] that is added to wrist goals in the frames `object` and
            `environment`.

    Raises:
        ValueError: there is no such phase, or it is the one that is judged; or a factor below 0.
    """
    left_out = tuple(without)
    known = [p.name for p in strategy.phases if p.name != strategy.success.hold_phase]
    unknown = [name for name in left_out if name not in known]
    if unknown:
        raise ValueError(f"without: expected some of {listed(known)}, got {listed(unknown)}")
    if not air_scale >= 0:
        raise ValueError(f"air_scale: expected 0 or more, got {air_scale}")
    kept = (phase for phase in strategy.phases if phase.name not in left_out)
    phases = tuple(_displaced(_with_air(phase, air_scale), displacement) for phase in kept)
    return replace(strategy, phases=phases)


def _with_air(phase: Phase, scale: float) -> Phase:
    masses = {name: scale * mass for name, mass in phase.air_mass.items()}
    pressures = {name: scale * pressure for name, pressure in phase.pressure.items()}
    return replace(phase, air_mass=masses, pressure=pressures)


def _displaced(phase: Phase, displacement: Vector) -> Phase:
    goal = phase.wrist
    if goal is None or goal.frame not in DISPLACED_FRAMES:
        return phase
    x, y, z = (a + b for a, b in zip(goal.position, displacement, strict=True))
    return replace(phase, wrist=replace(goal, position=(x, y, z)))
