"""What to do next, as lines for the shell: what tells apart, what adds, what learns the rest."""

from argparse import Namespace
from pathlib import Path

import pytest

from model_lab.cli.lines import after_diagnosis, after_learning
from model_lab.diagnosis.result import ADEQUATE, EFFECTS_MISSING, UNEXPLAINED

SET = Path("a set")


def given(**changes):
    """Arguments as they are parsed."""
    plain = {"data": SET, "model": "linear", "effects": [], "free_modulus": False}
    return Namespace(**plain | {"allow_effect_files": False} | changes)


def after(verdict, names=(), tied=(), left=1.0, mended=None, **changes):
    """The lines after a diagnosis that leaves so many noise floors."""
    effects = [Namespace(name=name) for name in names]
    planned = {} if any(tied) else None
    found = Namespace(verdict=verdict, effects=effects, tied=tied, next_experiment=planned)
    found.rmse_after, found.noise_floor, found.verdict_mended = left, 1.0, mended
    return after_diagnosis(given(**changes), found)


def test_nothing_is_to_be_done_about_a_model_that_is_adequate():
    assert after(ADEQUATE) == []


def test_what_nothing_known_explains_is_learned_with_the_same_model_and_effects():
    (line,) = after(UNEXPLAINED, effects=["own.py"], free_modulus=True)
    assert line == (
        "model-lab learn 'a set' --model linear --free-modulus --effects own.py --out my_effect.py"
    )


def test_nothing_is_learned_of_a_set_with_several_outputs():
    found = Namespace(verdict=UNEXPLAINED, effects=[], tied=[], next_experiment=None)
    found.rmse_after, found.noise_floor, found.verdict_mended = 9.0, 1.0, None
    assert after_diagnosis(given(), found, may_learn=False) == []


def test_effects_are_added_one_to_the_model_with_the_other_and_much_of_a_rest_is_learned():
    lines = after(EFFECTS_MISSING, ["creep", "gravity"], [(), ()], left=2.1)
    assert lines == [
        "model-lab add creep --data 'a set' --model linear --out model.yaml",
        "model-lab add gravity --data 'a set' --model model.yaml --out model_2.yaml",
        "model-lab learn 'a set' --model model_2.yaml --out my_effect.py",
    ]
    assert len(after(EFFECTS_MISSING, ["creep"], [()], left=1.9)) == 1


def test_what_is_tied_is_told_apart_first():
    lines = after(EFFECTS_MISSING, ["creep"], [("ageing",)])
    assert [line.split()[1] for line in lines] == ["plan", "add"]


@pytest.mark.parametrize("allowed", [False, True])
def test_curves_are_added_and_their_files_are_allowed_from_the_second_on(allowed):
    files = [Path("mine.py"), Path("mine_2.py")]
    first, second = after_learning(given(allow_effect_files=allowed), files)
    assert first.endswith("--out mine.yaml") and ("--allow" in first) == allowed
    assert "add mine_2 --effects mine_2.py --data 'a set' --model mine.yaml" in second
    assert second.count("--allow-effect-files") == 1


def test_nothing_is_learned_from_what_happened_between_runs():
    assert after(UNEXPLAINED, mended=ADEQUATE) == []
