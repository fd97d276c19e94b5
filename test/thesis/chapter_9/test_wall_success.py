"""What the report says of made-up successes over the wall's inclination."""

import pytest

from thesis.chapter_9 import wall_success

GIVEN = wall_success.Parameters()
SHARES = {40: 0.1, 45: 0.4, 50: 0.7, 60: 1.0, 70: 0.8, 80: 0.5, 85: 0.4, 90: 0.3}


def trials(shares, by_start=lambda start: 1.0):
    found = []
    for angle, share in shares.items():
        for start in GIVEN.starts:
            held = round(share * GIVEN.replicates * by_start(start))
            found += [
                {
                    "inclination": float(angle),
                    "start": start,
                    "gripped": int(k < held),
                    "cause": "" if k < held else "missed",
                    "phase": "" if k < held else "wrap",
                }
                for k in range(GIVEN.replicates)
            ]
    return found


def judged(shares, control=0, **more):
    control = [{"gripped": control}]
    results = {"trials": trials(shares, **more), "control": control, "engines": [], "steps": []}
    report = wall_success.report(results, GIVEN)
    return {found.what: found.met for found in report.findings if found.met is not None}


def test_successes_as_the_thesis_tells_of_meet_every_criterion():
    found = judged(SHARES)
    assert all(found.values())
    assert len(found) == 11


@pytest.mark.parametrize(
    ("angle", "share", "what"),
    [
        (60, 0.5, "share of successes at 60 deg"),
        (70, 0.3, "share of successes at 70 deg"),
        (90, 0.0, "some success at 90 deg"),
        (40, 0.9, "fewer at 40 than at 60 deg"),
        (50, 0.0, "one peak over the inclination"),
    ],
)
def test_an_inclination_with_another_share_misses_a_criterion(angle, share, what):
    shares = SHARES | {45: 0.9} if angle == 50 else SHARES
    assert judged(shares | {angle: share})[what] is False


def test_a_start_that_matters_and_a_grasp_without_a_wall_are_told():
    far = judged(SHARES, by_start=lambda start: 0.2 if start > 0.13 else 1.0)
    assert far["success over the start before the corner"] is False
    assert judged(SHARES, control=1)["negative control: no wall"] is False


def test_the_object_starts_where_it_is_said_before_the_corner():
    tasks = wall_success.plan(GIVEN).tasks()
    assert len(tasks) == 8 * 5 * 6
    starts = {round(0.15 - task.cell[0], 3) for task in tasks}
    assert starts == set(GIVEN.starts)
    for task in tasks:
        assert task.placement.offset[0] == pytest.approx(task.cell[0], abs=0.0011)
        assert abs(task.placement.yaw) <= wall_success.YAW


def test_a_small_run_lifts_at_the_wall_and_not_without(small, check_small_run):
    check_small_run("wall_success")
    results, report = small("wall_success")
    assert [trial["gripped"] for trial in results["trials"]] == [1]
    assert [trial["gripped"] for trial in results["control"]] == [0]
    assert "100 %" in report.conclusion
    rubbed = [found for found in report.findings if "rubber" in found.what]
    assert [found.what for found in rubbed] == [
        f"friction of the rubber on wood {value:g}, not 0.6, wall at 60 deg"
        for value in (0.5, 0.7, 1.0)
    ]
    assert all(found.ours.endswith(" of 1") for found in rubbed)
