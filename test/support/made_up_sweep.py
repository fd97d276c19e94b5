"""A sweep whose trials all succeed without being simulated; its file is a real one."""

from pathlib import Path

from grasp_strategies.sweep.results import Results, read_results


def all_gripped(plan, folder, jobs):
    """In place of `run_sweep`."""
    lines = plan.lines()
    with Results(Path(folder), lines) as results:
        for line in lines:
            results.append(line.describe() | {"outcome": "gripped", "cause": ""})
    found = {record["key"]: record for record in read_results(Path(folder))}
    return [found[line.key] for line in lines]
