"""A finger as a rod of PyElastica, which steps it through time until it rests.

PyElastica knows shear and stretch, so both are made so stiff that they do not show; mass and
damping are such that it comes to rest soon. Its elements are as a chain whose joints sit between
them: the rod begins half an element before the base, so that the joints share the whole length but
for half an element at the tip, which carries next to no moment.
"""

from dataclasses import dataclass

import elastica
import numpy as np
from cosserat import Rod

ELEMENTS = 20
STEP = 1.5e-5  # [s]
RAMP, DURATION = 0.1, 0.35  # [s]
SHEAR_STIFFNESS = 4e3  # [N]
STOP_STIFFNESS = 1e5  # [N/m]
LINE_DENSITY = 0.33  # [kg/m]
DAMPING = 80.0  # [1/s]


@dataclass(frozen=True)
class Rested:
    """Place (x, z) [m] of the tip, force [N] of the stop on it, fastest speed [m/s]."""

    tip: np.ndarray
    tip_force: float
    speed: float


class Fingers(
    elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping
):
    """What PyElastica steps."""


class Inflated(elastica.NoForces):
    """Free curvature (n,) [1/m] about y that grows with time to its full size."""

    def __init__(self, curvature):
        super().__init__()
        self.curvature = curvature

    def apply_forces(self, system, time=0.0):
        system.rest_kappa[1] = min(1.0, time / RAMP) * self.curvature


class Stopped(elastica.NoForces):
    """A smooth plane x = level [m] that the tip leans on."""

    def __init__(self, level):
        super().__init__()
        self.level = level

    def apply_forces(self, system, time=0.0):
        system.external_forces[0, -1] -= stop_force(system, self.level)


def stop_force(system, level):
    return STOP_STIFFNESS * max(0.0, system.position_collection[0, -1] - level)


def rest(rod: Rod, level: float | None = None) -> Rested:
    """The weightless rod at rest, its tip on a plane x = level [m] if there is one."""
    edge = rod.length / (ELEMENTS - 0.5)
    fingers = Fingers()
    system = straight_rod(rod, edge)
    fingers.append(system)
    fingers.constrain(system).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    joints = (np.arange(ELEMENTS - 1) + 0.5) * edge
    fingers.add_forcing_to(system).using(Inflated, rod.free_curvature(joints))
    if level is not None:
        fingers.add_forcing_to(system).using(Stopped, level)
    fingers.dampen(system).using(
        elastica.AnalyticalLinearDamper, uniform_damping_constant=DAMPING, time_step=STEP
    )
    fingers.finalize()
    stepper, time = elastica.PositionVerlet(), 0.0
    for _ in range(round(DURATION / STEP)):
        time = stepper.step(fingers, time, STEP)
    return Rested(
        system.position_collection[[0, 2], -1].copy(),
        0.0 if level is None else stop_force(system, level),
        float(np.abs(system.velocity_collection).max()),
    )


def straight_rod(rod: Rod, edge: float) -> elastica.CosseratRod:
    radius = 2.0 * edge
    system = elastica.CosseratRod.straight_rod(
        ELEMENTS,
        np.array([0.0, 0.0, -edge / 2.0]),
        np.array([0.0, 0.0, 1.0]),
        np.array([1.0, 0.0, 0.0]),
        ELEMENTS * edge,
        radius,
        LINE_DENSITY / (np.pi * radius**2),
        youngs_modulus=1e6,
    )
    stiffness = rod.stiffness((np.arange(ELEMENTS - 1) + 0.5) * edge)
    for axis in range(3):
        system.bend_matrix[axis, axis] = stiffness
        system.shear_matrix[axis, axis] = SHEAR_STIFFNESS
    return system
