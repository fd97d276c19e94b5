"""What is kept of bodies from one model of a search to the next."""

from dataclasses import replace

import numpy as np
import pytest

from model_lab.bench.hand_motion_set import hand_motion_set
from model_lab.bench.layouts import hand_pose_set
from model_lab.experiments import kept_bodies
from model_lab.experiments.hand_motion import HandMotion
from model_lab.experiments.hand_pose import HandPose
from model_lab.experiments.kept_bodies import SCALES, Recent, ShapesOverScales
from softhand_model.effects.hand import ActuatorScatter
from softhand_model.effects.hand_parts import MarkerOffset
from softhand_model.effects.load import Gravity
from softhand_model.equilibrium.hand_statics import Shape
from softhand_model.motion.moving_body import MovingBody

WEIGHT = Gravity(mass_scale=1.0)


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    monkeypatch.setattr(kept_bodies, "_SETS", Recent(kept_bodies.MOST_SETS))


@pytest.fixture
def rolled(monkeypatch):
    """Names of the actuators of the bodies that were followed in time."""
    names, roll_runs = [], MovingBody.roll_runs

    def counted(self, *given):
        names.append(self.actuators[0])
        return roll_runs(self, *given)

    monkeypatch.setattr(MovingBody, "roll_runs", counted)
    return names


def moving(name, *protocols):
    data = hand_motion_set(name)
    return replace(data, runs=tuple(run for run in data.runs if run.protocol in protocols))


def at(scale):
    return {"modulus_scale[A]": np.array([scale])}


def test_a_body_without_markers_has_shapes_at_every_scale():
    kept, bare = ShapesOverScales(), Shape(np.zeros((2, 0, 3)), np.zeros((2, 0, 3, 3)))
    for scale in np.linspace(0.9, 1.1, SCALES + 2):
        assert kept.at(lambda _: bare, float(scale)).places.shape == (2, 0, 3)


def test_the_most_recently_used_results_are_kept():
    recent, made = Recent(2), []
    for key in "abacab":
        recent.once(key, lambda key=key: made.append(key))
    assert made == ["a", "b", "c", "b"]


def test_a_model_with_one_actuator_changed_shares_the_other_bodies(rolled):
    data = moving("rbo_hand_2", "step_fingers_up")
    bodies = HandMotion(data, 3, 0.01).predict({}, [WEIGHT]) is not None and len(rolled)
    softer = ActuatorScatter.at(actuator="index")(modulus_factor=0.8)
    found = HandMotion(data, 3, 0.01).predict({}, [WEIGHT, softer])
    assert bodies > 3 and rolled[bodies:] == ["index"]
    kept_bodies._SETS = Recent(1)
    assert (HandMotion(data, 3, 0.01).predict({}, [WEIGHT, softer]) == found).all()


@pytest.mark.parametrize("column", ["pressure.a", "wrist.qx", "time"])
def test_sets_that_are_driven_otherwise_share_nothing(column):
    data = moving("single_finger", "turned_palm_up")
    (run, *_) = data.runs
    moved = replace(run, columns={**run.columns, column: 0.9 * run.columns[column]})
    other = replace(data, runs=(moved,))
    first = HandMotion(replace(data, runs=(run,)), 3, 0.01).predict({}, [WEIGHT])
    found = HandMotion(other, 3, 0.01).predict({}, [WEIGHT])
    kept_bodies._SETS = Recent(1)
    assert (HandMotion(other, 3, 0.01).predict({}, [WEIGHT]) == found).all()
    assert np.abs(found - first).max() > 1e-6


def test_after_many_scales_of_the_modulus_a_polynomial_gives_the_others(rolled):
    data = moving("single_finger", "step_palm_down", "shaken_fingers_up", "turned_palm_up")
    model = HandMotion(data, 5, 0.005)
    for scale in np.linspace(0.97, 1.03, SCALES + 1):
        model.predict(at(scale), [WEIGHT])
    count = len(rolled)
    found = {scale: model.predict(at(scale), [WEIGHT]) for scale in (0.851, 0.93, 1.013, 1.149)}
    assert len(rolled) == count
    kept_bodies._SETS = Recent(1)
    for scale, places in found.items():
        exact = HandMotion(data, 5, 0.005).predict(at(scale), [WEIGHT])
        assert 0.0 < np.abs(places - exact).max() < 1e-7
    model.predict(at(1.2), [WEIGHT])  # beyond what is usual
    assert len(rolled) == count + 5


def test_poses_too_are_polynomials_of_the_modulus_within_a_tenth_of_a_micrometre():
    data = hand_pose_set()
    moved = MarkerOffset.at(marker="index_tip")(x=2e-3, y=-1e-3, z=3e-3)
    model = HandPose(data)
    for scale in np.linspace(0.9, 1.1, SCALES + 2):
        found = model.predict(at(scale), [WEIGHT, moved])
    kept_bodies._SETS = Recent(1)
    exact = HandPose(data).predict(at(1.1), [WEIGHT, moved])
    assert 0.0 < np.abs(found - exact).max() < 1e-7


def test_a_shape_that_no_polynomial_follows_is_calculated():
    asked, over = [], ShapesOverScales()

    def kinked(scale):
        asked.append(scale)
        return Shape(np.full((1, 1, 3), abs(scale - 1.0)), np.zeros((1, 1, 3, 3)))

    for scale in np.linspace(0.9, 1.1, SCALES + 5):
        assert over.at(kinked, scale).places[0, 0, 0] == abs(scale - 1.0)
    assert len(asked) == SCALES + 5 + SCALES + 2
