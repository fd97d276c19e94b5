"""The balance of load and rubber, followed from rest: free bending and the blocked tip.

Every step is solved by Newton's method with a numerical slope, started from the step before, so
that the root is the one that is connected to rest. Sections are solved together with the tip force
(blocked) or with the weight of what lies beyond them (hanging).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.hidden.elastica import bulging_force
from bench.hidden.plant import Body, Plant

Array = np.ndarray
TOLERANCE = 1e-9
ON_THE_WAY = 1e-3
GRAVITY = 9.81
STRIDES = 8  # load increments of a solution without memory


@dataclass
class Step:
    """State of the solution: stretch (rows, sections) and tip force (rows, 1)."""

    stretch: Array
    force: Array


def stretches(
    plant: Plant, body: Body, dt: Array, pressure: Array, temperature: Array, blocked: bool
) -> tuple[Array, Array]:
    """Stretch (rows, steps, sections) and tip force (rows, steps).

    dt (rows,) [s], pressure (rows, steps) in the chamber, temperature (rows,).
    """
    if stepwise(plant, blocked):
        if plant.bulges:
            raise ValueError("expected a finger that bulges to have no memory")
        return _stepped(plant, body, dt, pressure, temperature, blocked)
    return _without_memory(plant, body, pressure, temperature, blocked)


def stepwise(plant: Plant, blocked: bool) -> bool:
    """Whether the solution has to follow time: sections that share a load soften together."""
    coupled = blocked or bool(plant.mass_scale or plant.tip_mass)
    return plant.remembers or (plant.softening is not None and coupled)


def tip_angle(stretch: Array, body: Body) -> Array:
    """Angle of the tip (rows, steps) [rad]."""
    return np.einsum("rks,rs->rk", stretch - 1.0, body.weights / body.height)


def _stepped(
    plant: Plant, body: Body, dt: Array, pressure: Array, temperature: Array, blocked: bool
) -> tuple[Array, Array]:
    rows, steps = pressure.shape
    shape = body.height.shape
    for memory in (plant.modes, plant.loop):
        if memory is not None:
            memory.reset(shape)
    state = Step(np.ones(shape), np.zeros((rows, 1)))
    found = np.empty((rows, steps, shape[1]))
    forces = np.empty((rows, steps))
    unit = plant.moment_unit(temperature[:, None], body)
    for k in range(steps):
        step = (dt if k else np.zeros(rows))[:, None]
        load = plant.load(pressure[:, k : k + 1], temperature[:, None], body)
        state = _solve(plant, body, load, unit, step, state, blocked)
        _commit(plant, body, state.stretch, step)
        found[:, k], forces[:, k] = state.stretch, state.force[:, 0]
    return found, forces


def _without_memory(
    plant: Plant, body: Body, pressure: Array, temperature: Array, blocked: bool
) -> tuple[Array, Array]:
    """All samples at once, loaded in a few strides from rest."""
    rows, steps = pressure.shape
    sections = body.height.shape[1]
    index = np.repeat(np.arange(rows), steps)
    wide, warm = body.rows(index), temperature[index][:, None]
    unit = plant.moment_unit(warm, wide)
    final = plant.load(pressure.reshape(-1, 1), warm, wide)
    state = Step(np.ones_like(final), np.zeros((rows * steps, 1)))
    for part in np.arange(1, STRIDES + 1) / STRIDES:
        goal = TOLERANCE if part == 1 else ON_THE_WAY
        state = _solve(plant, wide, part * final, unit, np.zeros((1, 1)), state, blocked, goal)
    if blocked and plant.bulges:
        state.force = bulging_force(plant, wide, final, unit, state.force)
    return state.stretch.reshape(rows, steps, sections), state.force.reshape(rows, steps)


def _commit(plant: Plant, body: Body, stretch: Array, dt: Array) -> None:
    if plant.modes is not None:
        plant.modes.commit(plant.elastic(stretch, body), dt)
    if plant.loop is not None:
        plant.loop.commit(stretch)
    if plant.softening is not None:
        plant.softening.commit(stretch)


def _stress(plant: Plant, body: Body, stretch: Array, dt: Array) -> Array:
    elastic = plant.elastic(stretch, body)
    total = elastic + plant.side_stress(stretch, body)
    if plant.modes is not None:
        total = total + plant.modes.trial(elastic, dt)
    if plant.loop is not None:
        total = total + plant.loop.trial(stretch)
    return total


def _solve(
    plant: Plant,
    body: Body,
    load: Array,
    unit: Array,
    dt: Array,
    state: Step,
    blocked: bool,
    goal: float = TOLERANCE,
) -> Step:
    stretch, force = state.stretch, state.force
    arm = body.length - body.x
    for _ in range(60):
        stress = _stress(plant, body, stretch, dt)
        slope = (_stress(plant, body, stretch + 1e-6, dt) - stress) / 1e-6
        rest = load - stress
        if plant.mass_scale or plant.tip_mass:
            rest = rest - unit * _weight_moment(plant, body, stretch)
        if blocked:
            force = _tip_force(plant, body, stretch, rest, slope, unit, force)
            rest = rest - unit * force * arm
        change = np.clip(rest / slope, -0.15, 0.15)
        stretch = np.maximum(stretch + change, 0.05)
        if np.max(np.abs(change)) < goal:
            break
    return Step(stretch, force)


def _tip_force(
    plant: Plant, body: Body, stretch: Array, rest: Array, slope: Array, unit: Array, force: Array
) -> Array:
    """Force that holds the tip's small deflection at zero, or at what the gauge yields."""
    arm = body.length - body.x
    share = body.weights * arm / body.height
    free = (share * (stretch - 1.0 + rest / slope)).sum(axis=1, keepdims=True)
    per_force = (share * unit * arm / slope).sum(axis=1, keepdims=True)
    if plant.tip_compliance is None:
        return free / per_force
    for _ in range(20):
        gap = free - per_force * force - plant.tip_compliance(force)
        more = plant.tip_compliance(force + 1e-5) - plant.tip_compliance(force)
        force = force + gap / (per_force + more / 1e-5)
    return force


def _weight_moment(plant: Plant, body: Body, stretch: Array) -> Array:
    """Moment [N m] at each section of the weight beyond it, positive when it straightens."""
    kappa_dx = (stretch - 1.0) / body.height * body.weights
    angle = np.cumsum(kappa_dx, axis=1) - kappa_dx / 2
    lateral_dx = np.sin(angle) * body.weights
    lateral = np.cumsum(lateral_dx, axis=1) - lateral_dx / 2
    place = 2 * body.x / body.length - 1
    per_length = body.mass * plant.mass_scale * GRAVITY / body.length
    weight = per_length * (1 + plant.mass_tilt * place) * body.weights
    beyond = _tail(lateral * weight) - lateral * _tail(weight)
    tip = lateral_dx.sum(axis=1, keepdims=True)
    beyond = beyond + plant.tip_mass * GRAVITY * (tip - lateral)
    return body.uphill * beyond


def _tail(parts: Array) -> Array:
    """Sum from the middle of each section to the tip."""
    return np.cumsum(parts[:, ::-1], axis=1)[:, ::-1] - parts / 2
