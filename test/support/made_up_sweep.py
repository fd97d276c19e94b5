"""A sweep whose trials all succeed without being simulated; its file is a real one."""

from pathlib import Path

from softhand_trials.sweep.results import Results


def lines_gripped(lines, folder, jobs, name=""):
    """In place of `run_tasks`."""
    with Results(Path(folder), lines) as results:
        for line in lines:
            results.append(line.describe() | {"outcome": "gripped", "cause": ""})
        return [results.records[line.key] for line in lines]
