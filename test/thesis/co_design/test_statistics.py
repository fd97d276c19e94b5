"""The sentence follows from paired intervals over the seeds, whatever one would like."""

import pytest

from thesis.co_design.statistics import gain, helps, interval, sentence

BOTH = [0.70, 0.74, 0.69, 0.72, 0.75]


def shares(motion, hand):
    """Held-out success where co-design is so much better than either arm."""
    spread = [0.02, -0.01, 0.0, 0.01, -0.02]
    less = {"motion": motion, "hand": hand}
    return {"co-design": BOTH} | {
        name: [one - by + more for one, more in zip(BOTH, spread, strict=True)]
        for name, by in less.items()
    }


def test_co_design_helps_when_it_is_better_than_both_arms_by_intervals_above_zero():
    found = shares(0.10, 0.30)
    assert helps(found)
    said = sentence(found, 1936)
    assert said.startswith("Co-design helps at this budget (1,936 trials a search, 5 seeds): ")
    assert "+10 points (+8 to +12) over motion alone" in said and "+30 points" in said


@pytest.mark.parametrize(("motion", "hand"), [(0.01, 0.30), (0.10, 0.0), (-0.2, 0.3), (0.0, 0.0)])
def test_one_arm_that_it_does_not_beat_is_enough_for_not_shown(motion, hand):
    found = shares(motion, hand)
    assert not helps(found)
    said = sentence(found, 1936)
    assert "was not shown to help at this budget" in said
    assert said.endswith("It was worse than motion alone.") is (motion < 0.0)


def test_one_seed_shows_nothing():
    found = {"co-design": [1.0], "motion": [0.0], "hand": [0.0]}
    assert not helps(found)


def test_pairing_takes_out_what_seeds_share():
    easy_and_hard = [0.9, 0.2, 0.6, 0.4, 0.7]
    found = {"co-design": easy_and_hard, "motion": [one - 0.1 for one in easy_and_hard]}
    assert gain(found, "motion").low == pytest.approx(0.1)
    assert interval(easy_and_hard).low < 0.3


def test_the_interval_is_students():
    # mean 0.5, deviation 0.1, n = 3: 4.303 times 0.1/sqrt(3)
    found = interval([0.4, 0.5, 0.6])
    assert found.high - found.mean == pytest.approx(4.3027 * 0.1 / 3**0.5, rel=1e-4)


def test_the_interval_covers_the_truth_as_often_as_it_says():
    import numpy as np

    random = np.random.default_rng(0)
    inside = [
        found.low <= 0.1 <= found.high
        for found in (interval(random.normal(0.1, 0.05, 5)) for _ in range(1000))
    ]
    assert 0.93 <= np.mean(inside) <= 0.97
