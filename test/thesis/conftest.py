"""Small runs of the experiments, each made once; tests of their figures share them."""

from functools import cache

import pytest

from thesis import frame
from thesis.chapter_4.boxes import calibrated


def quiet(what, share):
    """Progress that nobody hears."""


@pytest.fixture(scope="session")
def once():
    """Calibrations, each made once: several experiments of chapter 4 begin with the same."""
    return cache(calibrated)


@pytest.fixture(scope="session")
def small(once, tmp_path_factory):
    """Results and report of the small run of an experiment, by its name."""
    kept = {}

    def make(name):
        if name not in kept:
            module = frame.experiment(name)
            if hasattr(module, "calibrated"):
                patch.setattr(module, "calibrated", once)
            given = dict(getattr(module, "SMALL", {}))
            if hasattr(frame.parameters_of(module), "seed"):
                given["seed"] = 1
            parameters = frame.parameters_of(module, given)
            results = module.run(parameters, frame.Job(tmp_path_factory.mktemp(name), quiet))
            kept[name] = results, module.report(results, parameters)
        return kept[name]

    with pytest.MonkeyPatch.context() as patch:
        yield make


@pytest.fixture
def check_small_run(small, tmp_path):
    """What every experiment has to give: finite figures, a verdict in a line, and a picture."""

    def check(name):
        results, report = small(name)
        module = frame.experiment(name)
        assert len(report.findings) >= 3 or name == "wall_thickness"
        assert all(found.value is None or abs(found.value) < 1e300 for found in report.findings)
        assert report.conclusion.endswith(".") and "\n" not in report.conclusion
        frame.write_result(tmp_path, module, frame.NoParameters(), results, report)
        assert "NaN" not in (tmp_path / "result.json").read_text()
        frame.save_figure(module, results, report, tmp_path / "figure.png")
        assert (tmp_path / "figure.png").stat().st_size > 5000

    return check
