"""Settings of the contact solver: the three of Table 5.1 in PyBullet's terms.

The thesis' solver stops at a precision (1e-2, 1e-4, 1e-5) or after a number of iterations (100,
500, 2000) and over-relaxes (1.5, 1.3, 1.0). PyBullet's stops at a residual of velocities or after
its iterations, and does not over-relax; it starts from the impulses of the step before, so it needs
fewer. docs/simulator.md tabulates what the settings do to a grasp.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SolverSettings:
    """Iterations a step at most, and the residual [m/s, squared and summed] that ends them early.

    Raises ValueError for fewer than one iteration or a residual below zero.
    """

    iterations: int = 30
    residual: float = 1e-7

    def __post_init__(self) -> None:
        if self.iterations < 1:
            raise ValueError(f"iterations: expected 1 or more, got {self.iterations}")
        if not self.residual >= 0:
            raise ValueError(f"residual: expected 0 or more, got {self.residual}")


SETTINGS = {
    "fast": SolverSettings(15, 1e-4),
    "default": SolverSettings(),
    "stable": SolverSettings(100, 0.0),
}


def solver_settings(name: str) -> SolverSettings:
    """The settings of a name; raises ValueError that lists the names there are.

    >>> solver_settings("stable").iterations
    100
    """
    if name not in SETTINGS:
        raise ValueError(f"solver: expected one of {', '.join(SETTINGS)}; got {name!r}")
    return SETTINGS[name]
