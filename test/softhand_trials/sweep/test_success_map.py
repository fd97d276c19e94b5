"""Measures of a success map, on regions whose measures are known."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softhand_trials.sweep.success_map import (
    SuccessMap,
    border_length,
    correlation,
    largest_hole,
    largest_share,
    map_of,
    overlap,
    window_mean,
)

AXIS = 0.01 * np.arange(-10, 11)


def of(region, replicates=3):
    return SuccessMap(AXIS, AXIS, region, np.array([region] * replicates))


def disc(radius):
    x, y = np.meshgrid(AXIS, AXIS, indexing="ij")
    return np.hypot(x, y) <= radius


def test_a_disc_has_its_area_radius_and_centre_and_is_sharp_and_whole():
    found = of(disc(0.061))
    assert found.area == pytest.approx(math.pi * 0.061**2, rel=0.05)
    assert found.equivalent_radius == pytest.approx(0.061, rel=0.03)
    assert_allclose(found.centre, (0.0, 0.0), atol=1e-12)
    assert found.fuzziness == 0.0
    assert largest_share(found.region) == 1.0
    assert largest_hole(found.region) == 0
    assert not found.reaches_border


def test_a_region_at_the_edge_of_the_grid_is_told():
    region = np.zeros((21, 21), bool)
    region[0, 4] = True
    assert of(region).reaches_border


def test_diagonal_neighbours_are_two_components_and_close_no_hole():
    region = np.zeros((21, 21), bool)
    region[3, 4] = region[4, 3] = region[4, 5] = region[5, 4] = True
    assert largest_share(region) == 0.25
    assert largest_hole(region) == 1  # 4-connected: what lies between them cannot get out


def test_a_ring_has_the_hole_that_was_cut():
    region = disc(0.08)
    region[9:11, 9:12] = False
    assert largest_hole(region) == 6


def test_a_border_that_is_unsure_is_fuzzier_than_a_sharp_one():
    inner, outer = disc(0.04), disc(0.052)
    fuzzy = SuccessMap(AXIS, AXIS, inner, np.array([inner, inner, outer]))
    assert fuzzy.fuzziness == (outer.sum() - inner.sum()) / border_length(inner)
    wider = SuccessMap(AXIS, AXIS, inner, np.array([inner, inner, disc(0.065)]))
    assert wider.fuzziness > fuzzy.fuzziness > of(inner).fuzziness


def test_a_window_blurs_one_cell_over_nine_and_keeps_what_is_even():
    one = np.zeros((5, 5), bool)
    one[2, 2] = True
    blurred = window_mean(one)
    assert_allclose(blurred[1:4, 1:4], 1 / 9)
    assert blurred[0].max() == 0.0
    assert_allclose(window_mean(np.ones((5, 5), bool)), 1.0)


def test_shifted_regions_overlap_by_what_they_share():
    region = np.zeros((21, 21), bool)
    region[5:9, 5:9] = True
    shifted = np.roll(region, 2, axis=0)
    assert overlap(region, shifted) == 8 / 24
    assert overlap(region, region) == 1.0
    assert overlap(np.zeros_like(region), np.zeros_like(region)) == 1.0


def test_a_map_correlates_with_itself_and_an_even_one_with_nothing():
    filtered = window_mean(disc(0.05))
    assert correlation(filtered, filtered) == pytest.approx(1.0)
    assert correlation(filtered, -filtered) == pytest.approx(-1.0)
    assert math.isnan(correlation(filtered, np.ones_like(filtered)))
    assert correlation(np.zeros((3, 4)), np.zeros((3, 4))) == 1.0
    assert math.isnan(correlation(np.zeros((3, 4)), np.ones((3, 4))))


def test_an_empty_map_has_no_area_and_no_centre():
    found = of(np.zeros((21, 21), bool))
    assert found.area == 0.0
    assert math.isnan(largest_share(found.region))
    assert math.isnan(found.centre[0])


def test_maps_of_other_shapes_than_their_axes_are_refused():
    region = np.zeros((21, 20), bool)
    with pytest.raises(ValueError, match=r"expected `once` of shape \(21, 21\)"):
        of(region)


def trials(xs, ys, replicates, gripped):
    return [
        {
            "key": f"plan/ball/{x},{y}/{number}",
            "cell": [x, y],
            "replicate": number,
            "outcome": "gripped" if gripped(x, y, number) else "none",
        }
        for number in replicates
        for x in xs
        for y in ys
    ]


def test_a_map_of_records_has_their_cells_whatever_their_order():
    xs, ys = [-0.01, 0.0, 0.01], [0.0, 0.01]
    records = trials(xs, ys, range(3), lambda x, y, number: x == 0.01 and number != 2)
    found = map_of(records[::-1])
    assert_allclose(found.xs, xs)
    assert_allclose(found.ys, ys)
    assert found.once.tolist() == [[False, False], [False, False], [True, True]]
    assert_allclose(found.share, [[0, 0], [0, 0], [0.5, 0.5]])


def test_replicates_stand_in_for_the_trial_without_jitter_and_the_other_way_round():
    alone = map_of(trials([0.0, 0.01], [0.0], [0], lambda x, *_: x > 0))
    assert alone.once.tolist() == alone.replicates[0].tolist() == [[False], [True]]
    jittered = map_of(trials([0.0, 0.01], [0.0], [1, 2], lambda x, y, number: number == 2))
    assert not jittered.once.any() and len(jittered.replicates) == 2


@pytest.mark.parametrize(
    "records",
    [
        trials([0.0], [0.0], [1, 2], lambda *_: True),
        trials([0.0, 0.01], [0.0, 0.01], [1], lambda *_: True)[:-1],
        trials([0.0, 0.01, 0.03], [0.0], [1], lambda *_: True),
        [{"key": "plan/ball/0,0/1", "cell": [0, 0], "replicate": 1, "error": "lost"}],
    ],
    ids=["one cell", "a cell missing", "uneven steps", "no verdict"],
)
def test_what_is_no_whole_grid_has_no_map(records):
    assert map_of(records) is None
