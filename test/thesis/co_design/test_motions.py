"""Motions by eleven numbers: with the shipped ones, over a cylinder, the shipped strategy."""

import numpy as np
import pytest

from grasp_strategies.strategy import load_strategy
from pneuflex_sim.scene.objects import load_object
from thesis.co_design import motions

SHIPPED = load_strategy("surface_constrained")


def made(values, tmp_path, finger_length=0.09):
    path = tmp_path / "motion.yaml"
    values = motions.SHIPPED | values
    path.write_text(motions.strategy_text(values, finger_length, "rbo_hand_2"), encoding="utf-8")
    return load_strategy(path)


def test_the_shipped_numbers_give_the_course_of_the_shipped_strategy(tmp_path):
    ours = made({}, tmp_path)
    approach, shipped = ours.phases[0].wrist, SHIPPED.phases[0].wrist
    centre = np.array([0.0, 0.0, load_object("cylinder").rest_height])
    assert approach.position == pytest.approx(centre + shipped.position, abs=1e-4)
    assert approach.rpy == pytest.approx(shipped.rpy)
    for mine, theirs in zip(ours.phases[1:], SHIPPED.phases[1:8], strict=True):
        assert mine.air_mass == theirs.air_mass
        assert (mine.wrist, mine.speed, mine.air_ramp) == (
            theirs.wrist,
            theirs.speed,
            theirs.air_ramp,
        )
        assert [c.threshold for c in mine.until] == [c.threshold for c in theirs.until]
    assert ours.success == SHIPPED.success


def test_a_motion_never_looks_at_the_object(tmp_path):
    frames = {phase.wrist.frame for phase in made({}, tmp_path).phases if phase.wrist}
    assert "object" not in frames


def test_longer_fingers_begin_as_far_over_the_table(tmp_path):
    short, long = (
        made({}, tmp_path, length).phases[0].wrist.position[2] for length in (0.07, 0.11)
    )
    assert long - short == pytest.approx(0.04 * np.cos(np.pi / 4), abs=1e-6)


def test_air_goes_to_the_palm_or_to_the_fingers_first(tmp_path):
    palm, fingers = (made({"lead": lead}, tmp_path).phases[2].air_mass for lead in (5e-5, -3e-5))
    assert palm == pytest.approx({"c": 5e-5, "d": 4.3e-5})  # no more than in the end
    assert fingers == pytest.approx({"a": 3e-5, "b": 1e-5})
