"""When a proposed experiment counts as having broken a tie."""

import pytest

import bench.lab  # noqa: F401  (puts the generator on the path)
from bench.lab.planning import broken, proposed, tied_with_truth


def answer(*names):
    effects = [{"name": names[0]}] if names else []
    return {"effects": effects, "tied": [list(names[1:])] if names else []}


def record(before, after=None):
    made = {"expected": {"names": [["tube_lag"]]}, "before": before}
    return made if after is None else {**made, "after": after}


@pytest.mark.parametrize(
    ("after", "expected"),
    [
        (answer("tube_lag"), True),
        (answer("hysteresis", "tube_lag"), True),
        (answer("hysteresis"), False),
        (answer("hysteresis", "tube_lag", "viscoelasticity"), False),
        (answer(), False),
    ],
)
def test_a_tie_is_broken_when_fewer_names_are_left_with_the_truth(after, expected):
    made = record(answer("hysteresis", "viscoelasticity", "tube_lag"), after)
    assert tied_with_truth(made) and proposed(made)
    assert broken(made) is expected


def test_sets_without_the_truth_in_a_tie_or_without_a_proposal_do_not_count():
    assert not tied_with_truth(record(answer("tube_lag")))
    assert not tied_with_truth(record(answer("hysteresis", "viscoelasticity")))
    assert not proposed(record(answer("tube_lag", "hysteresis")))
