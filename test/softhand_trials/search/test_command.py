"""The command of searches."""

from softhand_trials.search.command import main

PROBLEM = """
format: softhand-search/1
name: bowl
objective: search_objectives:bowl
variables: {x: [-1, 1], y: [-5, 5]}
sampler: cma
evaluations: 12
"""


def test_a_search_prints_its_best_values_and_goes_on_from_its_results(tmp_path, capsys):
    path = tmp_path / "problem.yaml"
    path.write_text(PROBLEM)
    words = [str(path), "--out", str(tmp_path / "out"), "--jobs", "0", "--allow-objectives"]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert first.startswith("12 evaluations\nbowl/00") and "\n  x " in first
    before = (tmp_path / "out/results.jsonl").read_bytes()
    assert main(words) == 0
    assert capsys.readouterr().out == first
    assert (tmp_path / "out/results.jsonl").read_bytes() == before


def test_a_problem_that_cannot_be_used_is_said_in_a_line(tmp_path, capsys):
    path = tmp_path / "problem.yaml"
    path.write_text(PROBLEM)
    assert main([str(path)]) == 2
    assert "if you trust the code of its module" in capsys.readouterr().err
    assert main([str(tmp_path / "none.yaml")]) == 2
    assert main([str(path), "--allow-objectives", "--jobs", "-1"]) == 2
    assert "jobs: expected 0 or more, got -1" in capsys.readouterr().err
