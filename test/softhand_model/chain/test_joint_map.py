"""Bend and twist of the two arcs of the palm."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_model.chain.joint_map import bend_and_twist, parallel_arcs
from softhand_model.hand.actuator import load_actuator

SEGMENTS = 5


def palm(turn=1):
    return parallel_arcs(load_actuator("P10.PalmInner"), load_actuator("P10.PalmOuter"), turn)


def shape(arcs, angles):
    bends, twists = bend_and_twist(arcs, SEGMENTS)
    return np.einsum("jik,jk->i", bends, angles), np.einsum("jik,jk->i", twists, angles)


def test_equal_bends_do_not_twist():
    bend, twist = shape(palm(), np.full((2, SEGMENTS), 0.2))
    assert bend == pytest.approx(np.full(SEGMENTS, 0.2))
    assert twist == pytest.approx(np.zeros(SEGMENTS), abs=1e-15)


def test_an_outer_arc_that_bends_more_twists_with_the_turn():
    """The outer side then rises to +x, which is a positive turn about z where it lies at -y."""
    _, twist = shape(palm(turn=1), np.array([np.full(SEGMENTS, 0.1), np.full(SEGMENTS, 0.3)]))
    _, mirrored = shape(palm(turn=-1), np.array([np.full(SEGMENTS, 0.1), np.full(SEGMENTS, 0.3)]))
    assert np.all(twist > 0)
    assert mirrored == pytest.approx(-twist)


def test_twist_grows_towards_the_tip():
    _, twist = shape(palm(), np.array([np.zeros(SEGMENTS), np.full(SEGMENTS, 0.3)]))
    assert np.all(np.diff(twist) > 0)


def test_shape_has_the_least_elastic_energy():
    """Brute force: bend and twist rate on a fine grid by linear least squares."""
    inner, outer = load_actuator("P10.PalmInner"), load_actuator("P10.PalmOuter")
    angles = np.random.default_rng(3).uniform(0.0, 0.3, (2, SEGMENTS))
    count = 24 * SEGMENTS
    step = np.pi / 2 / count
    free = np.repeat(angles, 24, axis=1) / (np.pi / 2 / SEGMENTS)
    stiffness = [float(inner.stiffness(0)) / 0.0375, float(outer.stiffness(0)) / 0.0625]
    tilt = [-0.0125 / 0.0375, 0.0125 / 0.0625]
    # unknowns: bend rate of each cell, twist rate at its far edge (zero at the base)
    cells = np.eye(count)
    growth = (cells - np.eye(count, k=-1)) / step
    rows = [np.sqrt(stiffness[j]) * np.hstack([cells, tilt[j] * growth]) for j in range(2)]
    torsion = np.sqrt(sum(stiffness)) * (cells + np.eye(count, k=-1)) / 2
    matrix = np.vstack([*rows, np.hstack([0 * cells, torsion])])
    wanted = np.concatenate([np.sqrt(stiffness[j]) * free[j] for j in range(2)] + [np.zeros(count)])
    found = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    bend, twist = shape(palm(), angles)
    assert bend == pytest.approx(found[:count].reshape(SEGMENTS, -1).sum(axis=1) * step, abs=2e-4)
    middle = torsion @ found[count:] / np.sqrt(sum(stiffness))
    assert twist == pytest.approx(middle.reshape(SEGMENTS, -1).sum(axis=1) * step, abs=2e-4)


def test_without_torsional_stiffness_both_arcs_bend_freely():
    """The fibres' tilt then makes up the difference: t = (beta_o - beta_i)/S, linear in phi."""
    slack = replace(palm(), decay=1e-4)
    rate = slack.twist_rate(np.array([0.4, 0.8]), np.zeros(1), np.array([np.pi / 2]))
    radius, gap = 0.05, 0.025
    factor = 0.0375 * 0.0625 / (radius * gap)
    assert rate == pytest.approx(factor * np.array([0.4, 0.8]), rel=1e-6)
