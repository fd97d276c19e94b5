"""Problems of searches are read with errors that name what is wrong, and run no foreign code."""

import pytest

from softhand_trials.search import load_problem
from softhand_trials.search.objective import find_objective
from softhand_trials.search.problem import Evaluation

TEXT = """
format: softhand-search/1
name: bowl
objective: search_objectives:bowl
variables: {x: [-1, 1], y: [-5, 5]}
sampler: cma
evaluations: 40
seed: 3
settings: {wait: 0.0, model: model.yaml}
"""


@pytest.fixture
def write(tmp_path):
    def written(*changes):
        text = TEXT
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "problem.yaml"
        path.write_text(text)
        return path

    return written


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[-1, 1]", "[1, 1]", "variables.x: expected low and high"),
        ("sampler: cma", "sampler: best", "sampler: expected one of cma, tpe, random"),
        ("evaluations: 40", "evaluations: 0", "evaluations: expected a whole number from 1"),
        ("seed: 3", "start: {z: 1}", "start: z: expected the name of a variable"),
        (
            "seed: 3",
            "start: {x: 1.5}",
            "start: x: expected the name of a variable and a value within",
        ),
        (
            "seed: 3",
            "start: [{x: 1}, {x: 1.5}]",
            "start: x: expected the name of a variable and a value within",
        ),
        ("seed: 3", "enough: little", "enough: expected"),
        ("seed: 3", "generation: 2", "sampler: cma: expected 2 or more variables"),
        ("seed: 3", "sed: 3", "only the keys"),
        ("search_objectives:bowl", "bowl", "expected module:function, got 'bowl'"),
        ("search_objectives:bowl", "'os.path:'", "expected module:function"),
    ],
)
def test_what_cannot_be_searched_is_refused(write, old, new, words):
    with pytest.raises(ValueError, match=words):
        load_problem(write((old, new)), allow_any=True)


def test_one_start_several_and_none_are_read(write):
    for text, starts in (
        ("start: {x: 1}", ({"x": 1.0},)),
        ("start: [{x: 1}, {y: -2}]", ({"x": 1.0}, {"y": -2.0})),
        ("seed: 4", ()),
    ):
        assert load_problem(write(("seed: 3", text)), allow_any=True).starts == starts


def test_code_of_other_modules_is_run_only_when_it_is_allowed(write):
    with pytest.raises(
        ValueError, match="trust the code of its module, run it with --allow-objectives"
    ):
        load_problem(write())
    assert load_problem(write(), allow_any=True).name == "bowl"


def test_an_objective_that_a_package_registers_needs_no_permission(write, tmp_path, monkeypatch):
    about = tmp_path / "bowls-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: bowls\nVersion: 1.0\n")
    points = "[softhand.objectives]\nbowl = search_objectives:bowl\n"
    (about / "entry_points.txt").write_text(points)
    monkeypatch.syspath_prepend(tmp_path)
    assert load_problem(write()).objective == "search_objectives:bowl"
    with pytest.raises(ValueError, match="an installed package registers, got search_objectives:l"):
        load_problem(write(("search_objectives:bowl", "search_objectives:ledge")))


def test_only_marked_functions_are_objectives(write):
    for name in ("search_objectives:not_marked", "os:getpid", "search_objectives:none"):
        with pytest.raises(ValueError, match="expected a function with the decorator `objective`"):
            find_objective(name, allow_any=True)
    with pytest.raises(ValueError, match="expected a module that can be imported"):
        find_objective("grasp_strategies.nowhere:bowl", allow_any=True)


def test_a_file_that_settings_name_belongs_to_the_evaluation(write, tmp_path):
    (tmp_path / "model.yaml").write_text("one")
    problem = load_problem(write(), allow_any=True)
    assert problem.settings == {"wait": 0.0, "model": str(tmp_path / "model.yaml")}
    evaluation = Evaluation(problem, 12, {"x": 0.0, "y": 0.0})
    before = evaluation.digest
    assert evaluation.key == "bowl/0012" and before == evaluation.digest
    (tmp_path / "model.yaml").write_text("two")
    assert evaluation.digest != before
