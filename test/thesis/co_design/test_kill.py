"""A killed worker and a killed search lose no finished trial, and the end is the same."""

import json

import made_up_designs
from killed_sweep import RUN_AGAIN, killed_and_run_again


def test_killed_workers_and_a_killed_search_lose_no_finished_trial(tmp_path):
    notes = tmp_path / "notes"
    command = [made_up_designs.__file__, tmp_path / "out", notes]
    output, records = killed_and_run_again(command, tmp_path / "out", 25)
    assert len(records) == made_up_designs.PLAN.budget
    assert len(records) <= len(notes.read_text().splitlines()) <= len(records) + RUN_AGAIN
    undisturbed = made_up_designs.search(tmp_path / "other")
    assert json.loads(output) == [one.score for one in undisturbed]
