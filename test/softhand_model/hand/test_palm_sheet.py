"""The palm sheet as an arch, against a finite-element beam."""

import numpy as np
import pytest

from softhand_model.hand.palm_sheet import PalmSheet, arch_compliance

WHOLE = PalmSheet(0.1, 0.08, 0.005, 600e3, np.pi, (0, 0, 0), (0, 0, 0))


def frame_element(length, heading, stretch, bend):
    """Stiffness (6, 6) of a straight beam of two nodes (x, y, turn) in the plane."""
    k = np.zeros((6, 6))
    k[np.ix_([0, 3], [0, 3])] = stretch / length * np.array([[1, -1], [-1, 1]])
    k[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = (
        bend
        / length**3
        * np.array(
            [
                [12, 6 * length, -12, 6 * length],
                [6 * length, 4 * length**2, -6 * length, 2 * length**2],
                [-12, -6 * length, 12, -6 * length],
                [6 * length, 2 * length**2, -6 * length, 4 * length**2],
            ]
        )
    )
    c, s = np.cos(heading), np.sin(heading)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    both = np.kron(np.eye(2), turn)
    return both.T @ k @ both


def crown_sinking(angle, elements=200):
    """Sinking of the crown of a clamped arch of radius 1, E*I = 1, under a force of 1."""
    phi = np.linspace(-0.5, 0.5, elements + 1) * angle
    nodes = np.stack([np.sin(phi), np.cos(phi)], axis=1)
    total = np.zeros((3 * (elements + 1),) * 2)
    for k, way in enumerate(np.diff(nodes, axis=0)):
        at = slice(3 * k, 3 * k + 6)
        length = np.linalg.norm(way)
        total[at, at] += frame_element(length, np.arctan2(way[1], way[0]), 1e8, 1.0)
    load = np.zeros(len(total))
    load[3 * (elements // 2) + 1] = -1.0
    free = slice(3, -3)
    return -np.linalg.solve(total[free, free], load[free])[3 * (elements // 2) + 1 - 3]


@pytest.mark.parametrize("angle", [np.pi / 2, 1.2, np.pi])
def test_the_arch_sinks_as_a_frame_of_straight_beams_does(angle):
    assert arch_compliance(angle) == pytest.approx(crown_sinking(angle), rel=5e-3)


def test_stiffness_grows_with_the_cube_of_the_thickness_and_falls_with_that_of_the_length():
    thick = PalmSheet(0.1, 0.08, 0.010, 600e3, np.pi, (0, 0, 0), (0, 0, 0))
    long = PalmSheet(0.2, 0.08, 0.005, 600e3, np.pi, (0, 0, 0), (0, 0, 0))
    assert thick.stiffness() == pytest.approx(8 * WHOLE.stiffness())
    assert long.stiffness() == pytest.approx(WHOLE.stiffness() / 8)


def test_a_sheet_of_100_mm_bent_by_half_a_turn_rises_by_its_radius():
    assert WHOLE.rise == pytest.approx(0.1 / np.pi)
    arch = WHOLE.profile(201)
    assert np.linalg.norm(np.diff(arch, axis=0), axis=1).sum() == pytest.approx(0.1, rel=1e-4)
    assert arch[[0, -1], 0] == pytest.approx([0.0, 0.0], abs=1e-12)
