"""A strategy with times and ways that tests know in closed form."""

import textwrap

import pytest

from grasp_strategies.strategy import load_strategy

STRATEGY = """
format: softhand-strategy/1
name: test_grasp
description: go over the object, close, lift, hold, put down
hand: rbo_hand_2
phases:
  - name: approach
    wrist: {frame: object, position: [0, 0, 0.1], rpy: [0, 1.5707963267948966, 0]}
    duration: 0.5
    air_mass: {a: 0, b: 0, c: 0, d: 0}
  - name: close
    air_mass: {a: 4.0e-5, b: 2.0e-5, c: 2.0e-5, d: 2.0e-5}
    air_ramp: 0.4
    until: {air_mass_error: {below: 1.0e-6}}
    time_out: 2.0
  - name: lift
    wrist: {frame: wrist_level, position: [0, 0, 0.12]}
    speed: 0.2
  - name: hold
    duration: 1.2
  - name: lower
    wrist: {frame: wrist_level, position: [0, 0, -0.12]}
    duration: 0.6
    option: lower_and_release
  - name: release
    air_mass: {a: 0, b: 0, c: 0, d: 0}
    option: lower_and_release
"""


@pytest.fixture
def write_strategy(tmp_path):
    """Write a strategy file, the usual one with texts replaced; returns its path."""

    def write(*replacements, text=STRATEGY):
        for old, new in replacements:
            assert old in text, f"{old!r} is not in the strategy"
            text = text.replace(old, new)
        path = tmp_path / "test_grasp.yaml"
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return path

    return write


@pytest.fixture
def make_strategy(write_strategy):
    """The usual strategy with texts replaced, read from its file."""
    return lambda *replacements, **kw: load_strategy(write_strategy(*replacements, **kw))
