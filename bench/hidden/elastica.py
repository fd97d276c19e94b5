"""A blocked finger that bulges between base and gauge: its shape is integrated along the arc.

theta' = kappa, y' = sin(theta), M' = -F*cos(theta), from the straight base; the moment at the base
and the force F are shot for, so that the tip carries no moment and stands where the gauge is. The
tip slides along the gauge. Uniform fingers only.
"""

from __future__ import annotations

import numpy as np

from bench.hidden.plant import Body, Plant

Array = np.ndarray
PIECES = 32  # of the arc, each by a step of fourth order
SHOTS = 12
MISSED = 1e-10  # of the length, and of the moment of the straight finger


def bulging_force(plant: Plant, body: Body, load: Array, unit: Array, straight: Array) -> Array:
    """Force (rows, 1) [N] of fingers under a load (rows, sections) [-] with m = unit*M.

    straight: force of the fingers if they do not bulge.
    """
    if np.ptp(load, axis=1).max() > 1e-9 * np.abs(load).max():
        raise ValueError("expected uniform fingers")
    load, unit, length = load[:, :1], unit[:, :1], body.length
    one = body.rows(np.arange(len(length)))
    scale = np.maximum(np.abs(straight), 1e-9) * length
    moment, force = straight * length, straight

    def missed(moment: Array, force: Array) -> tuple[Array, Array]:
        torque, y = _tip(plant, one, load, unit, moment, force)
        gives = 0.0 if plant.tip_compliance is None else plant.tip_compliance(force)
        return torque / scale, (y - gives) / length

    for _ in range(SHOTS):
        first, second = missed(moment, force)
        if max(np.abs(first).max(), np.abs(second).max()) < MISSED:
            return force
        up, along = 1e-6 * scale, 1e-6 * scale / length
        a, c = (
            (b - n) / up for b, n in zip(missed(moment + up, force), (first, second), strict=True)
        )
        b, d = (
            (b - n) / along
            for b, n in zip(missed(moment, force + along), (first, second), strict=True)
        )
        whole = a * d - b * c
        moment = moment - (d * first - b * second) / whole
        force = force - (a * second - c * first) / whole
    raise ValueError("a blocked finger found no balance")


def _tip(
    plant: Plant, body: Body, load: Array, unit: Array, moment: Array, force: Array
) -> tuple[Array, Array]:
    """Moment [N m] and deflection [m] of the tip (rows, 1) from those of the base."""

    def rates(state: Array) -> Array:
        theta, _, torque = state
        return np.array(
            [_curvature(plant, body, load - unit * torque), np.sin(theta), -force * np.cos(theta)]
        )

    state = np.array([np.zeros_like(load), np.zeros_like(load), moment + np.zeros_like(load)])
    step = body.length / PIECES
    for _ in range(PIECES):
        k1 = rates(state)
        k2 = rates(state + step / 2 * k1)
        k3 = rates(state + step / 2 * k2)
        k4 = rates(state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state[2], state[1]


def _curvature(plant: Plant, body: Body, stress: Array) -> Array:
    """Curvature [1/m] of sections whose rubber carries a stress over G."""
    stretch = np.ones_like(stress)
    for _ in range(40):
        now = plant.elastic(stretch, body)
        slope = (plant.elastic(stretch + 1e-6, body) - now) / 1e-6
        change = np.clip((stress - now) / slope, -0.3, 0.3)
        stretch = np.maximum(stretch + change, 0.2)
        if np.abs(change).max() < 1e-11:
            break
    return (stretch - 1.0) / body.height[:, :1]
