"""The effect file of a learned curve, for every stage, form and axis."""

import numpy as np
import pytest

from bench.hidden import make_set
from model_lab.diagnosis.search import score_base
from model_lab.experiments.forward import Forward
from model_lab.fitting.problem import pose_problem
from model_lab.learning.candidates import Scene
from model_lab.learning.effect_file import check_name, effect_of, text_of
from model_lab.measurements.load import load_measurements
from softhand_model.effects import effect_classes, effects_in_file
from softhand_model.model_file import load_model

DESIGNS = {"free_bending": "shapes", "blocked_tip": "standard", "uniaxial": "temperatures"}


@pytest.fixture(scope="module", params=DESIGNS)
def scene(request, tmp_path_factory):
    """A set in which nothing is hidden, and what its candidates are made of."""
    folder = tmp_path_factory.mktemp("plain")
    make_set(folder, request.param, [], seed=3, samples=40, runs=6, design=DESIGNS[request.param])
    data = load_measurements(folder)
    problem, _ = pose_problem(data, load_model("base"), effect_classes())
    return Scene.of(problem, score_base(problem).fit)


def test_each_candidate_does_nothing_as_it_starts_and_something_otherwise(scene):
    plain = Forward(scene.data).predict(Forward(scene.data).start()[None])
    shapes = list(scene.shapes(5))
    assert {shape.stage for shape in shapes} >= {"elastic", "load", "output"} or "blocked" in (
        scene.data.experiment
    )
    for shape in shapes:
        forward = Forward(scene.data, effects=[effect_of(shape, "tried")])
        start = forward.start()
        moved = np.where(
            [p.effect == "tried" for p in forward.parameters], 1.05 * start + 0.01, start
        )
        found = forward.predict(np.stack([start, moved]))
        if shape.form != "lag":
            assert found[0] == pytest.approx(plain[0], rel=1e-6, abs=1e-9), shape
        assert np.all(np.isfinite(found)), shape
        assert not np.array_equal(found[0], found[1]), shape


def test_times_since_a_step_end_with_the_longest_rest_and_the_slowest_run_is_no_rest(scene):
    longest, slowest = 0.0, np.inf
    for run in scene.data.runs:
        time, moved = run.columns["time"], np.abs(np.diff(scene.data.driving(run)))
        last = np.maximum.accumulate(np.where(np.append(1.0, moved) > 1e-9, time, -np.inf))
        longest = max(longest, float(np.max(time - last)))
        pace = moved[moved > 1e-9] / np.diff(time)[moved > 1e-9]
        slowest = min(slowest, float(np.median(pace)))
    shapes = [one for one in scene.shapes(5) if one.against == "time_since_step"]
    assert shapes
    for shape in shapes:
        assert shape.places[-1] == pytest.approx(longest, rel=0.15)
    assert scene.slow[0] < 0.7 * slowest


def test_a_file_with_values_passes_the_rehearsal_of_own_effects(scene, tmp_path):
    shape = next(one for one in scene.shapes(4) if one.stage == "output" and one.form == "factor")
    path = tmp_path / "seen.py"
    path.write_text(text_of(shape, "seen", [1.0, 1.1, 1.2, 1.3], [0.01] * 4, " from a set"))
    (effect,) = effects_in_file(path).values()
    assert effect.name == "seen"
    assert [p.typical for p in effect.parameters][1] == pytest.approx((1.08, 1.12))


@pytest.mark.parametrize("name", ["my-effect.py", "class.py", "gravity.py", "effect.txt"])
def test_a_name_that_could_not_be_loaded_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match="expected"):
        check_name(tmp_path / name, force=False)
