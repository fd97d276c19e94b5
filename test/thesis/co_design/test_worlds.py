"""Trials of designs: the same world for all at a seed, another one held out; the score."""

from itertools import pairwise

import pytest

from softhand_trials.sweep.task import run_task
from thesis.co_design.plan import NIGHT, PLANS
from thesis.co_design.trials import Physics, Shared, design_of
from thesis.co_design.worlds import score, trials_of

ONE, OTHER = design_of({}), design_of({"finger_wall": 0.003})


def worlds(design, world=NIGHT.training, seed=1, **more):
    return {
        line.key.partition("/")[2]: (line.shared.object, line.shared.modulus_scale, line.placement)
        for line in trials_of("x", design, world, seed, **more)
    }


def test_all_designs_of_a_seed_meet_the_same_world_and_those_of_another_do_not():
    assert worlds(ONE) == worlds(OTHER)
    assert not set(map(repr, worlds(ONE).values())) & set(map(repr, worlds(ONE, seed=2).values()))


def test_a_rung_takes_objects_in_turns_and_the_next_goes_on():
    first, all_of_them = worlds(ONE, numbers=range(5)), worlds(ONE)
    assert {name for name, *_ in first.values()} == set(NIGHT.training.objects)
    assert first.items() <= all_of_them.items()
    assert len(all_of_them) == NIGHT.rungs[-1] == 40


def test_the_held_out_world_has_other_objects_friction_and_rubber():
    assert not set(NIGHT.training.objects) & set(NIGHT.held_out.objects)
    held = worlds(ONE, NIGHT.held_out).values()
    assert len(held) == 80
    assert {modulus for _, modulus, _ in held} == {0.85, 1.15}
    assert {placement.friction_scale for *_, placement in held} == {0.7, 1.3}
    assert all(0.95 <= modulus <= 1.05 for _, modulus, _ in worlds(ONE).values())


def test_trials_of_one_scene_follow_each_other():
    for world in (NIGHT.training, NIGHT.held_out):
        shared = [line.settings for line in trials_of("x", ONE, world, 1)]
        changes = sum(one != other for one, other in pairwise(shared))
        assert changes == len(set(shared)) - 1


def test_the_night_fits_its_hours():
    searches = len(NIGHT.seeds) * 4 + len(NIGHT.control_seeds)
    judged = (searches + 2 * len(NIGHT.seeds)) * (40 + 80)
    assert searches * NIGHT.budget + judged + 200 <= 21_200
    assert set(PLANS) == {"night", "small"}


@pytest.mark.parametrize(
    ("shares", "expected"),
    [
        ({"a": 1.0, "b": 1.0}, 1.25),
        ({"a": 1.0, "b": 0.0}, 0.5),
        ({"a": 1.0, "b": 0.5, "c": 0.5, "d": 0.0, "e": 1.0}, 0.6 + 0.25 * 0.25 * 0.5 / 1.25),
    ],
)
def test_the_worst_quarter_of_the_objects_counts_besides(shares, expected):
    records = [
        {"object": name, "outcome": "gripped" if k < 2 * share else "none"}
        for name, share in shares.items()
        for k in range(2)
    ]
    assert score(records) == pytest.approx(expected)


def test_a_grasp_that_was_lost_breaks_ties_and_no_more():
    none, lost = ({"object": "a", "outcome": outcome} for outcome in ("none", "lost"))
    assert 0.0 == score([none] * 40) < score([none] * 39 + [lost]) < 0.025
    assert score([{"object": "a", "error": "diverged"}]) == 0.0


def test_a_real_trial_grips_gives_the_same_again_and_its_digest_tells_designs_apart():
    (line,) = trials_of("x", ONE, NIGHT.training, 1, [4])
    assert line.shared.object == "cylinder"
    records = [run_task(line) for _ in range(2)]
    assert records[0]["outcome"] == "gripped"
    times = ("wall_time", "cpu_time")
    kept = [{k: v for k, v in record.items() if k not in times} for record in records]
    assert kept[0] == kept[1]
    other = line.__class__(line.key, Shared(OTHER, *line.shared[1:]), line.placement)
    fine = line.__class__(
        line.key, line.shared._replace(physics=Physics(0.002, 10, True)), line.placement
    )
    assert len({line.digest, other.digest, fine.digest}) == 3
