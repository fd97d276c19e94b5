"""What the reports of the maps say of made-up regions."""

import numpy as np
import pytest
from made_up_sweep import lines_gripped

from softhand_trials.sweep.results import find_record
from softhand_trials.sweep.trial_task import trial_of
from thesis.__main__ import main
from thesis.chapter_8 import map_evidence, object_map, push_map, surface_map
from thesis.chapter_8.object_map import MAIN, RUBBER, map_plan, placed
from thesis.frame import Job, read_result, save_figure

AXIS = [round(0.01 * k, 3) for k in range(-6, 7)]


def disc(radius, centre=(0.0, 0.0)):
    x, y = np.meshgrid(AXIS, AXIS, indexing="ij")
    return np.hypot(x - centre[0], y - centre[1]) <= radius


# with less friction of the rubber half of the cells, with more all
RUBBED = {
    name: lambda region, more=factor > 1: tallied(
        region | True if more else region & (np.array(AXIS)[:, None] > 0)
    )
    for name, factor in RUBBER.items()
}


def tallied(*regions):
    cells = {str(k): region.astype(int).ravel().tolist() for k, region in enumerate(regions)}
    return {"replicates": cells, "failed": {}}


def maps(regions, **checks):
    main = {name: tallied(*[region] * 4) for name, region in regions.items()}
    sweeps = {MAIN: main}
    for name, change in checks.items():
        sweeps[name] = {object: change(region) for object, region in regions.items()}
    return {"xs": AXIS, "ys": AXIS, "sweeps": sweeps, "engines": [], "steps": []}


def verdicts(report):
    return {found.what: found.met for found in report.findings if found.met is not None}


def pushed(**other):
    radii = dict.fromkeys(push_map.HEADLINE, 0.04) | {"marker": 0.02}
    regions = {name: disc(radius) for name, radius in radii.items()} | other
    return maps(
        regions,
        other_step=tallied,
        other_jitter=lambda region: {"replicates": {"1": tallied(region)["replicates"]["0"]}},
        no_air=lambda region: tallied(np.zeros_like(region)),
        no_advance=lambda region: tallied(region & disc(0.02)),
        **RUBBED,
    )


def test_maps_as_the_thesis_tells_of_meet_every_criterion_of_the_push_grasp():
    report = push_map.report(pushed(), push_map.Parameters())
    assert all(verdicts(report).values()), report.table
    assert len(verdicts(report)) == 9


@pytest.mark.parametrize(
    ("region", "what"),
    [
        (disc(0.01) | disc(0.01, (0.0, 0.04)), "largest component, least share of the successes"),
        (disc(0.05) & ~disc(0.011), "largest hole"),
        (disc(0.011), "smallest region"),
        (disc(-1.0), "objects that succeed somewhere"),
    ],
)
def test_a_tube_with_another_region_misses_a_criterion(region, what):
    report = push_map.report(pushed(tube=region), push_map.Parameters())
    assert verdicts(report)[what] is False


def test_successes_without_air_are_told():
    results = pushed()
    results["sweeps"]["no_air"]["tube"] = tallied(disc(0.01))
    report = push_map.report(results, push_map.Parameters())
    assert verdicts(report)["negative control: 0 kPa"] is False


def test_an_advance_that_enlarges_nothing_is_told():
    results = pushed()
    results["sweeps"]["no_advance"] = results["sweeps"][MAIN]
    report = push_map.report(results, push_map.Parameters())
    assert verdicts(report)["negative control: without the advance"] is False


def surfaces(**other):
    regions = {name: disc(0.04) for name in surface_map.HEADLINE} | other
    results = maps(
        regions,
        no_roll=lambda region: tallied(region & disc(0.02)),
        ptfe_table=lambda region: tallied(region & disc(0.02)),
        **RUBBED,
    )
    for name in surface_map.FUZZY:
        regions = disc(0.03), disc(0.03), disc(0.03), disc(0.04)
        results["sweeps"][MAIN][name] = tallied(*regions)
    return results


def test_maps_as_the_thesis_tells_of_meet_every_criterion_of_the_surface_grasp():
    report = surface_map.report(surfaces(), surface_map.Parameters())
    assert all(verdicts(report).values()), report.table
    assert len(verdicts(report)) == 8


def test_regions_in_other_places_are_told():
    report = surface_map.report(surfaces(tube=disc(0.02, (0.04, 0.04))), surface_map.Parameters())
    found = verdicts(report)
    assert found["centres of the regions"] is False
    assert found["regions that overlap in a cell"] is True


def test_what_yields_is_not_asked_for_a_region():
    report = surface_map.report(surfaces(tissue=disc(-1.0)), surface_map.Parameters())
    assert all(verdicts(report).values())


@pytest.mark.parametrize("module, results", [(push_map, pushed), (surface_map, surfaces)])
def test_each_friction_of_the_rubber_is_a_row_without_a_verdict(module, results):
    report = module.report(results(), module.Parameters())
    rows = {found.what: found for found in report.findings if "rubber" in found.what}
    assert list(rows) == [
        f"friction of the rubber on wood {value:g}, not 0.6" for value in (0.5, 0.7, 1.0)
    ]
    assert {found.met for found in rows.values()} == {None}
    for found, more in zip(rows.values(), (False, True, True), strict=True):
        before, after = map(int, found.ours.split(" of ")[0].split(" -> "))
        assert (after > before) is more and after != before


@pytest.mark.parametrize("upright", [False, True])
def test_objects_touch_both_planes_from_the_quadrant_of_the_thesis(upright):
    swept = placed("tube", upright)
    half_x, half_y = (0.0165, 0.0165) if upright else (0.0165, 0.089)
    assert swept.place == pytest.approx((half_x, -half_y))


def test_a_plan_has_every_cell_once_and_with_jitter():
    given = push_map.Parameters(objects=("marker",), pitch=0.02)
    lines = map_plan("push_map", "rbo_hand_1_push", given).tasks()
    assert len(lines) == 7 * 9 * 2
    by_key = {line.key: line for line in lines}
    once = by_key["push_map/marker/20,-40/0"].placement
    # the hand goes by (20, -40) mm: the object lies at its place minus that
    assert once.offset == pytest.approx((0.0085 - 0.02, -0.069 + 0.04))
    moved = by_key["push_map/marker/20,-40/1"].placement.offset
    assert 0 < abs(moved[0] - once.offset[0]) <= 0.001


def test_a_map_of_two_cells_is_run_drawn_and_played_again_from_its_lines(tmp_path, monkeypatch):
    monkeypatch.setattr(map_evidence, "FINE", 0.004)  # finer than the map, and quick
    given = push_map.Parameters(
        x=(0.0, 0.02),
        y=(-0.02, -0.02),
        pitch=0.02,
        objects=("cylinder",),
        replicates=1,
        checks=("no_air",),
        jobs=0,
        step=0.005,
        fine=1,
        sample=1,
        engines=("pybullet", "mujoco"),
    )
    results = push_map.run(given, Job(tmp_path, lambda what, share: None))
    (cylinder,) = results["sweeps"][MAIN].values()
    assert cylinder["replicates"]["0"] == [1, 1]
    assert verdicts(push_map.report(results, given))["negative control: 0 kPa"] is True
    assert {row["engine"]: row["trials"] for row in results["steps"]} == {
        "pybullet": 1,
        "mujoco": 1,
    }
    (compared,) = results["engines"]
    assert compared["trials"] == 1
    save_figure(push_map, results, push_map.report(results, given), tmp_path / "map.png")
    settings, placement = trial_of(find_record("push_map/cylinder/20,-20", tmp_path))
    assert settings.object_rpy == (0.0, 0.0, 0.0)
    assert placement.offset == pytest.approx((0.0325 - 0.02, -0.0325 + 0.02))


def test_another_object_and_check_are_added_to_the_maps_of_a_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(object_map, "run_tasks", lines_gripped)
    monkeypatch.setattr(map_evidence, "run_tasks", lines_gripped)
    cell = ["--x", "0", "0.02", "--y", "0", "0.02", "--pitch", "0.02", "--replicates", "1"]
    words = ["run", "push_map", "--out", str(tmp_path), *cell]
    main([*words, "--objects", "cylinder", "--checks", "no_air"])
    kept = (tmp_path / MAIN / "results.jsonl").read_text()
    main([*words, "--objects", "tube", "--checks", "no_advance"])
    assert (tmp_path / MAIN / "results.jsonl").read_text().startswith(kept)
    given, results = read_result(tmp_path, push_map)
    assert given.objects == ("cylinder", "tube")
    assert given.checks == ("no_air", "no_advance")
    assert set(results["sweeps"]) - {"main_mujoco"} == {MAIN, *given.checks}
    every = {4 * 2} if "main_mujoco" in results["sweeps"] else set()  # trials, without a sample
    assert {found["trials"] for found in results["engines"]} == every
    assert all(list(found) == ["cylinder", "tube"] for found in results["sweeps"].values())
    capsys.readouterr()
    assert main([*words, "--checks", "no_roll"]) == 2
    assert "checks: expected some of other_step" in capsys.readouterr().err
