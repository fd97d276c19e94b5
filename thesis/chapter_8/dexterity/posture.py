"""Postures of an empty hand: channels are brought to pressures, then closed.

The channels of palm and thumb are filled first, as in section 8.2.2, then those of the fingers, or
the other way round; section 8.2.1 does not say which. Pressures follow their ramps exactly, as with
valves of unlimited flow (our simplification: through the box's chokes the channel of three fingers
takes longer than its ramp). Then the valves close and the air stays in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grasp_strategies.in_process_scene import InProcessScene, build_scene
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_trials.search import objective
from thesis.chapter_8.dexterity.kapandji import (
    FORCE,
    OTHER_RADII,
    RADIUS,
    SLOW,
    TARGETS,
    THUMB,
    THUMB_TIP,
    Snapshot,
    Target,
    Verdict,
    judge,
)

Array = NDArray[np.float64]

HAND = "rbo_hand_2"
FOUR, SEVEN, RIGID = "four_channels", "seven_channels", "rigid_palm"
HANDS = (FOUR, SEVEN, RIGID)
PALM = "palm"
THUMB_FIRST = "thumb_first"  # name of the variable that sets the order
STIFF = 1e3  # factor on the shear modulus of actuators that are as good as rigid
RAMP, SETTLE, LASTING = 1.0, 0.5, 1.0  # of each of two ramps, before closing, and closed [s]
STEP, SEGMENTS = 0.005, 8
SPREAD = 0.02  # largest change of a pressure when a posture is repeated, as a share
RING_COUNT = 5  # outlines of the thumb's end of which the distance to a place is taken

# cost [mm]: what is not touched costs at least as much as the radius
NO_CONTACT, NOT_TOUCHED = 5.0, 8.0
A_NEWTON, A_SPEED, MOST_SPEED = 2.0, 10.0, 5.0  # [mm/N], [mm s/rad], [mm]
A_DETOUR = 0.25  # of what the way along the skin is longer than that through the air [-]
A_FACTOR = 3.0  # cost [mm] of a speed that is e times what is allowed


def hand_variant(name: str) -> HandDescription:
    """RBO Hand 2 as it is, with a channel for each actuator, or with actuators of the palm that do
    not bend. Raises ValueError for another name.
    """
    hand = load_hand(HAND)
    if name == SEVEN:
        chains = tuple(
            replace(chain, channels={actuator: actuator for actuator in chain.actuators})
            for chain in hand.chains
        )
        return replace(hand, channels=hand.actuator_names, chains=chains)
    if name == RIGID:
        palm = hand.chain(PALM)
        stiff = {
            key: replace(part, shear_modulus=STIFF * part.shear_modulus)
            for key, part in palm.actuators.items()
        }
        changed = replace(palm, actuators=stiff)
        return replace(hand, chains=tuple(changed if c.name == PALM else c for c in hand.chains))
    if name != FOUR:
        raise ValueError(f"hand: expected one of {', '.join(HANDS)}, got {name!r}")
    return hand


def first_channels(hand: HandDescription) -> Array:
    """Mask (channels,) of the channels that are filled first: those of the palm and of the chains
    mounted on it.
    """
    first = [
        channel
        for chain in hand.chains
        for channel in chain.channels.values()
        if chain.turn or chain.mount.parent == PALM
    ]
    return np.array([channel in first for channel in hand.channels])


class PosedHand:
    """A hand upright in the air, taken to postures from its rest.

    Args:
        variant: of the hand, see `hand_variant`.
        step: of the physics [s].
        segments: an actuator.
    """

    def __init__(self, variant: str = FOUR, step: float = STEP, segments: int = SEGMENTS) -> None:
        hand = hand_variant(variant)
        self.scene: InProcessScene = build_scene(
            hand=hand, scene="stand", step=step, segments=segments, finger_contact=True
        )
        self.limits = hand.max_pressures()
        self._first = first_channels(hand)
        self._start = self.scene.save()

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return self.scene.channels

    def take(self, pressures: Array, thumb_first: bool = True) -> tuple[Snapshot, Snapshot]:
        """Bring the channels to gauge pressures [Pa], those of palm and thumb before those of the
        fingers or after them; snapshots when the valves close, and one second later.

        Raises ValueError for pressures beyond the limits, RuntimeError when the simulation
        diverges.
        """
        if (pressures < 0).any() or (pressures > self.limits + 1e-6).any():
            raise ValueError(f"pressures: expected 0 to {self.limits} Pa, got {pressures}")
        simulation = self.scene.simulation
        simulation.restore(self._start)
        begin = simulation.time + np.where(self._first == thumb_first, 0.0, RAMP)
        masses = np.zeros(len(pressures))
        for _ in range(round((2 * RAMP + SETTLE) / simulation.step_size)):
            share = np.clip((simulation.time - begin) / RAMP, 0.0, 1.0)
            masses = self._masses(share * pressures)
            simulation.set_air_masses(masses)
            simulation.step()
        closed = self._seen()
        for _ in range(round(LASTING / simulation.step_size)):
            simulation.step()
        return closed, self._seen()

    def _masses(self, pressures: Array) -> Array:
        """Air (channels,) [kg above rest] that has these gauge pressures in the present posture."""
        simulation = self.scene.simulation
        return np.asarray(
            simulation.air.masses(
                simulation.ambient + pressures,
                simulation.ambient,
                simulation.temperature,
                simulation.bodies.rotations,
            )
        )

    def _seen(self) -> Snapshot:
        speed = float(np.abs(self.scene.simulation.bodies.v).max())
        return Snapshot(tuple(self.scene.finger_contacts()), speed)

    def joints(self) -> Array:
        """Joint orientations (n, 4) now."""
        return self.scene.simulation.bodies.q.copy()

    def gap(self, target: Target) -> float:
        """Distance [m] of the thumb's end from a place, through the air."""
        skin, q = self.scene.skin, self.joints()
        length = skin.length(THUMB)
        end = skin.points(THUMB, np.linspace(length - THUMB_TIP, length, RING_COUNT), q)
        place = skin.point(target.finger, target.share, target.side, q)
        return float(np.linalg.norm(end - place, axis=1).min())

    def close(self) -> None:
        """Free the simulation."""
        self.scene.close()


@lru_cache(maxsize=1)
def posed_hand(variant: str, step: float, segments: int) -> PosedHand:
    """The hand of the latest settings; each process keeps one."""
    return PosedHand(variant, step, segments)


@objective
def touch_place(values: Mapping[str, float], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Objective of the Kapandji test: how far the thumb's end is from touching a place.

    Args:
        values: gauge pressure [Pa] by channel; a channel that is not named stays empty.
            `thumb_first`: above 0.5, as if it is left out, palm and thumb are filled first.
        settings: `place` (1 to 8), `hand` (see `hand_variant`), `step` [s], `segments`, `draw`:
            seeds of a change of each pressure by up to `spread` (`SPREAD`), as a share.

    Returns:
        `cost` [mm] (see `cost`); verdicts by radius [mm], other fingers touched, and joint speed
        [rad/s].
    """
    target = TARGETS[int(settings["place"]) - 1]
    closed, later, gap = _taken(values, settings, target, settings.get("draw"))
    return _record(target, closed, later, gap)


@objective
def hold_place(values: Mapping[str, float], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Objective of a longer search: as `touch_place`, but a posture that touches is repeated with
    pressures changed by each of the seeds `draws`. Its cost is then that of all of these.

    Returns:
        as `touch_place`; `runs` is the number of simulations, `held` how many of them touch; `cost`
        [mm] is at most the radius if all do.
    """
    target = TARGETS[int(settings["place"]) - 1]
    first: dict[str, Any] = {}
    costs: list[float] = []
    held = 0
    for draw in (None, *settings["draws"]):
        closed, later, gap = _taken(values, settings, target, draw)
        found = _record(target, closed, later, gap)
        first = first or found
        held += found["touched"]
        costs.append(found["cost"] if found["touched"] else missed(target, closed, later, gap))
        if not first["touched"]:
            break
    whole = np.mean(costs if held == len(costs) else np.maximum(costs, NOT_TOUCHED))
    return first | {"cost": float(whole), "runs": len(costs), "held": held}


def _taken(
    values: Mapping[str, float],
    settings: Mapping[str, Any],
    target: Target,
    draw: Sequence[int] | None,
) -> tuple[Snapshot, Snapshot, float]:
    """Snapshots of a posture, and the thumb's distance [m] from the place through the air."""
    hand = posed_hand(
        str(settings.get("hand", FOUR)),
        float(settings.get("step", STEP)),
        int(settings.get("segments", SEGMENTS)),
    )
    pressures = np.array([values.get(name, 0.0) for name in hand.channels])
    if draw is not None:
        spread = float(settings.get("spread", SPREAD))
        share = np.random.default_rng(draw).uniform(-spread, spread, len(pressures))
        pressures = np.minimum((1.0 + share) * pressures, hand.limits)
    try:
        closed, later = hand.take(pressures, values.get(THUMB_FIRST, 1.0) > 0.5)
    except RuntimeError:
        posed_hand.cache_clear()  # the engine has diverged
        raise
    return closed, later, hand.gap(target)


def _record(target: Target, closed: Snapshot, later: Snapshot, gap: float) -> dict[str, Any]:
    verdict = judge(target, closed, later)
    return {
        "cost": cost(verdict, gap, later.speed),
        "touched": verdict.touched,
        "reason": verdict.reason,
        "distance": verdict.distance,
        "gap": gap,
        "force": verdict.force,
        "speed": later.speed,
        "others": list(verdict.others),
        "at_radius": {
            f"{1e3 * radius:g}": judge(target, closed, later, radius).touched
            for radius in sorted((RADIUS, *OTHER_RADII))
        },
    }


def missed(target: Target, closed: Snapshot, later: Snapshot, gap: float) -> float:
    """Cost [mm] of a posture that does not touch, with a slope in each thing that is missed.

    Beside the place it is as in `cost`. Within the radius, where the distance is no longer what is
    missed, that is left out, and what speed, force and the earlier snapshot miss is added: a speed
    by its logarithm, as it is often just above what is allowed.
    """
    verdict, before = judge(target, closed, later), judge(target, closed, closed)
    if verdict.distance is None or verdict.distance > RADIUS:
        return cost(verdict, gap, later.speed)
    low, high = FORCE
    found = NOT_TOUCHED + A_DETOUR * 1e3 * verdict.distance
    found += A_NEWTON * max(0.0, verdict.force - high) + max(0.0, 1.0 - verdict.force / low)
    away = np.inf if before.distance is None else before.distance
    found += min(NO_CONTACT, max(0.0, 1e3 * (away - RADIUS)))
    return found + min(MOST_SPEED, A_FACTOR * float(np.log(max(later.speed, SLOW) / SLOW)))


def cost(verdict: Verdict, gap: float, speed: float) -> float:
    """Cost [mm] of a posture.

    A touch costs its distance along the skin. Any other posture costs the distance through the air
    plus the radius plus a penalty; the penalty of a contact on the wrong side is higher than that
    of one beside the place, and highest without contact.

    Args:
        verdict: of the judge.
        gap: distance through the air [m].
        speed: of the fastest joint [rad/s].

    >>> cost(Verdict(True, "", 0.003, 0.2, ()), 0.002, 0.0)
    3.0
    """
    if verdict.touched and verdict.distance is not None:
        return 1e3 * verdict.distance
    found = 1e3 * gap + NOT_TOUCHED + A_NEWTON * max(0.0, verdict.force - FORCE[1])
    along = np.inf if verdict.distance is None else verdict.distance
    found += min(NO_CONTACT, A_DETOUR * 1e3 * max(0.0, along - gap))
    return found + min(MOST_SPEED, A_SPEED * max(0.0, speed - SLOW))
