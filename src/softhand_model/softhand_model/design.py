"""Rules of thumb for dimensioning an actuator (section 3.6.1)."""

from __future__ import annotations

from softhand_model.rubber import USEFUL_STRETCH

LARGEST_WALL = 0.5  # of the height (eq. 3.6)


def wall_for_actuation_ratio(actuation_ratio: float, shear_modulus: float) -> float:
    """Wall d [m] that gives the actuation ratio dkappa/dp [1/(m Pa)]: rule 1 (eq. 3.32).

    >>> round(wall_for_actuation_ratio(1.0 / (8 * 67e3 * 0.002), 67e3), 6)
    0.002
    """
    return 1.0 / (8.0 * shear_modulus * actuation_ratio)


def circumference_for_stiffness(stiffness: float, wall: float, shear_modulus: float) -> float:
    """Circumference c [m] that gives the bending stiffness [N m2]: rule 2 (eq. 3.26).

    >>> round(circumference_for_stiffness(2 * 0.02**3 * 67e3 * 0.002, 0.002, 67e3), 6)
    0.08
    """
    return float(4.0 * (stiffness / (2.0 * shear_modulus * wall)) ** (1.0 / 3.0))


def keeps_its_shape(height: float, width: float, tolerance: float = 0.1) -> bool:
    """Whether the section is square enough not to change shape under pressure: rule 3, h ~ z."""
    return abs(height - width) <= tolerance * max(height, width)


def wall_is_thin(height: float, wall: float) -> bool:
    """Whether the wall spares the rubber: rule 4, d < 0.5*h."""
    return wall < LARGEST_WALL * height


def useful_stretch(max_stretch: float) -> tuple[float, float]:
    """Stretch [-] up to which a rubber should be used, cautious and at most (section 3.3.3)."""
    return USEFUL_STRETCH[0] * max_stretch, USEFUL_STRETCH[1] * max_stretch
