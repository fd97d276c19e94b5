"""How the times of the lab are judged."""

import pytest

import bench.lab  # noqa: F401  (puts the generator on the path)
from bench.hidden.cases import all_cases
from bench.lab.speed import NAMED_SETS, REFUSED_SETS, row_of, text_of


@pytest.mark.parametrize(("judged", "word"), [("processor_seconds", "MISSED"), ("seconds", "met")])
def test_the_median_of_what_is_judged_stands_against_its_target(judged, word):
    row = row_of("refusal", 30.0, [(20.0, 29.0), (25.0, 31.0), (90.0, 80.0)], judged)
    assert (row["seconds"], row["processor_seconds"]) == (25.0, 31.0)
    assert text_of(row).endswith(f": {word})")


def test_the_timed_sets_are_cases_of_the_generator():
    assert {*NAMED_SETS, *REFUSED_SETS} <= {case.name for case in all_cases()}
