"""A killed worker and a killed search lose no finished evaluation and repeat none."""

from killed_sweep import RUN_AGAIN, killed_and_run_again

from softhand_trials.search import load_problem, run_search

PROBLEM = """
format: softhand-search/1
name: bowl
objective: search_objectives:bowl
variables: {{x: [-1, 1], y: [-5, 5]}}
sampler: cma
evaluations: 64
settings: {{wait: 0.02, runs: {runs}}}
"""


def test_killed_workers_and_a_killed_search_lose_nothing_and_the_end_is_the_same(tmp_path):
    path, folder, runs = tmp_path / "problem.yaml", tmp_path / "out", tmp_path / "runs"
    runs.mkdir()
    path.write_text(PROBLEM.format(runs=runs))
    words = [path, "--out", folder, "--jobs", "2", "--allow-objectives"]
    command = ["-m", "softhand_trials.search.command", *words]
    output, records = killed_and_run_again(command, folder, 20)
    assert "64 evaluations" in output
    assert len(records) == 64
    assert 64 <= len((runs / "notes").read_text().splitlines()) <= 64 + RUN_AGAIN
    undisturbed = run_search(load_problem(path, allow_any=True), tmp_path / "other", jobs=0)
    values = {record["key"]: record["values"] for record in records}
    assert values == {record["key"]: record["values"] for record in undisturbed.records}
