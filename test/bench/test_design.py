"""The bench of design: a request comes through the whole loop, a wrong finger does not."""

from dataclasses import replace

import pytest

from bench.design import materials, sizing
from bench.design.loop import verdict_on
from bench.design.requests import feasible
from bench.design.simulated import from_file, held_against


@pytest.fixture(scope="module")
def design():
    return next(feasible(1, seed=7))


def test_a_request_is_simulated_measured_and_found_adequate(design):
    actuator = from_file(design)
    held = held_against(design, actuator)
    assert max(held.bend, held.force) < 0.02
    found = verdict_on(design, actuator, seed=0)
    assert found["adequate"], found
    assert found["modulus_scale"] == pytest.approx(1.0, abs=0.02)


def test_a_finger_of_a_thicker_wall_is_off_the_requirements(design):
    actuator = from_file(design)
    thick = replace(actuator, wall=lambda x: 1.15 * actuator.wall(x))
    assert held_against(design, thick).bend > 0.05


@pytest.mark.parametrize(
    ("rows", "missed"),
    [
        (lambda: sizing.run(3, 1), ["the same as built", "with the tapers of P10"]),
        (lambda: materials.run(1), []),
    ],
)
def test_sizes_and_tables_meet_their_targets_but_for_those_known_to_be_missed(rows, missed):
    found = [row["name"] for row in rows() if row["met"] is False]
    assert len(found) == len(missed)
    assert all(part in name for part, name in zip(missed, found, strict=True))
