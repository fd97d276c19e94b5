"""Measurements by others, in the folder that SOFTHAND_MEASUREMENTS names; skipped without it.

Sets of experiments that the lab knows are compared and diagnosed; others are refused.
"""

import json
import os
import runpy
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import yaml

from model_lab.cli.main import main
from model_lab.comparison.add import add_effect
from model_lab.diagnosis.diagnose import diagnose
from model_lab.learning.learn import learn
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import OUTPUTS
from model_lab.measurements.save import write_set
from model_lab.report.sentences import verdict_sentence
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

FOLDER = os.environ.get("SOFTHAND_MEASUREMENTS")
SETS = sorted(path.parent for path in Path(FOLDER).glob("*/experiment.yaml")) if FOLDER else []
EXPERIMENT_OF = {
    path: yaml.safe_load((path / "experiment.yaml").read_text(encoding="utf-8"))["experiment"]
    for path in SETS
}
KNOWN = [path for path in SETS if EXPERIMENT_OF[path] in OUTPUTS]
SMALL = [
    path for path in KNOWN if "blocked" not in path.name
]  # of a few seconds; see bench.lab.real
UNKNOWN = [path for path in SETS if EXPERIMENT_OF[path] not in OUTPUTS]
VERDICTS = {"adequate", "effects_missing", "unexplained"}
MOST_SAMPLES = 450  # of a set that is diagnosed here; others are thinned
SCRIPT = Path(__file__).parents[2] / "scripts" / "measure_real_data.py"

pytestmark = pytest.mark.skipif(not SETS, reason="SOFTHAND_MEASUREMENTS names no measurement sets")


@pytest.fixture(params=KNOWN, ids=lambda path: path.name)
def folder(request):
    return request.param


@cache
def _model(folder):
    """Name of the model that the script takes for a set; to find it, the base model is fitted."""
    return runpy.run_path(str(SCRIPT))["fitting_model"](load_measurements(folder))[0]


def _every(step, data):
    """The set with every so many samples of each run."""
    runs = (
        replace(run, columns={name: v[::step] for name, v in run.columns.items()})
        for run in data.runs
    )
    return replace(data, runs=tuple(runs))


def _thinned(data):
    """The set with every n-th sample of each run, and at most four runs."""
    runs = data.runs[:: -(-len(data.runs) // 4)]
    step = -(-sum(run.samples for run in runs) // MOST_SAMPLES)
    return _every(step, replace(data, runs=runs))


def test_compare_measures_the_error_against_a_floor(folder, tmp_path):
    model = _model(folder)
    out = tmp_path / "compare.json"
    assert main(["compare", str(folder), "--model", model, "--json", str(out)]) == 0
    content = json.loads(out.read_text())
    assert 0.0 < content["noise_floor"] < content["rmse_heldout"]


def test_diagnose_comes_to_a_verdict_and_writes_its_report(folder, tmp_path, capsys):
    model = _model(folder)
    write_set(_thinned(load_measurements(folder)), tmp_path / "set")
    out = tmp_path / "diagnose.json"
    given = ["diagnose", tmp_path / "set", "--model", model, "--json", out, "--jobs", 1]
    assert main([str(word) for word in [*given, "--report", tmp_path]]) == 0
    content = json.loads(out.read_text())
    assert content["verdict"] in VERDICTS - {"adequate"}  # a straight line is no model of these
    assert content["noise_floor"] > 0.0
    assert capsys.readouterr().out.startswith("The model ")
    assert "</html>" in (tmp_path / "report.html").read_text()


def test_ladder_sets_models_side_by_side(folder, capsys):
    assert main(["ladder", str(folder), _model(folder)]) == 0
    assert "noise floor" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["compare", "diagnose", "ladder"])
@pytest.mark.parametrize("folder", UNKNOWN, ids=lambda path: path.name)
def test_a_set_of_an_experiment_that_the_lab_does_not_know_is_refused(folder, command, capsys):
    models = ["base"] if command == "ladder" else []
    assert main([command, str(folder), *models]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err == (
        f"model-lab: {folder / 'experiment.yaml'}:2: experiment: expected one of "
        f"{', '.join(OUTPUTS)}, got {EXPERIMENT_OF[folder]!r}\n"
    )


def test_ecoflex_is_stiffened_as_a_yeoh_or_gent_rubber():
    """Known of Ecoflex 00-30 up to stretches of four or five."""
    path = next((path for path in SETS if path.name == "silicone_ecoflex_00_30"), None)
    if path is None:
        pytest.skip("no set silicone_ecoflex_00_30")
    found = diagnose(load_measurements(path), load_model("base")).diagnosis
    best = found.ranking[0]
    assert best.name in ("yeoh_stiffening", "gent_stiffening") and best.plausible
    assert best.rmse_heldout < 0.1 * found.rmse_before


@pytest.mark.parametrize(
    ("name", "family"),
    [
        ("rubber_treloar", {"gent_stiffening", "arruda_boyce"}),
        ("rubber_kawabata", {"second_invariant", "mooney_rivlin"}),
    ],
)
def test_a_rubber_shows_what_the_literature_says_of_it(name, family):
    """The limit of the chains in natural rubber, the second invariant in isoprene rubber."""
    path = next((path for path in SETS if path.name == name), None)
    if path is None:
        pytest.skip(f"no set {name}")
    found = diagnose(load_measurements(path), load_model("base")).diagnosis
    named = {effect.name: effect for effect in found.effects}
    assert family & set(named)
    assert found.rmse_after < 0.4 * found.rmse_before
    for effect in named.values():
        assert all(entry.std < 0.3 * entry.value for entry in effect.parameters.values())


@pytest.mark.parametrize(
    ("name", "effects"),
    [
        ("epfl_c5_w7_bending", ["ballooning"]),
        ("epfl_c5_w7_blocked", ["ballooning", "tube_lag"]),
    ],
)
def test_chambers_that_balloon_take_off_two_thirds_of_the_error_of_bellows(name, effects):
    path = next((path for path in SETS if path.name == name), None)
    if path is None:
        pytest.skip(f"no set {name}")
    data, model = _every(12, load_measurements(path)), load_model("linear")
    additions = []
    for effect in effects:
        additions.append(add_effect(effect, data, model, effect_classes()))
        model = additions[-1].model
    before, after = additions[0].before.held_out.rmse, additions[-1].after.held_out.rmse
    assert after < before / 3.0


@pytest.mark.parametrize("folder", SMALL, ids=lambda path: path.name)
def test_what_a_real_set_lacks_is_learned_as_a_curve_and_most_of_the_error_goes(folder):
    data = load_measurements(folder)
    learned = learn(data, load_model(_model(folder)))
    assert learned.curves[0].shape.stage in ("load", "elastic", "input")
    assert learned.final.held_out.rmse < learned.base.held_out.rmse / 3.0


def test_what_takes_most_of_the_error_of_real_rubber_is_said_though_much_is_left():
    data = load_measurements(Path(FOLDER) / "silicone_dragon_skin_10")
    plain = {name: kind for name, kind in effect_classes().items() if not kind.refines}
    said = diagnose(data, load_model("base"), plain).diagnosis
    assert said.verdict == "unexplained"
    assert said.helps[0].name == "yeoh_stiffening"
    assert said.helps[0].rmse_after < 0.3 * said.rmse_before
    words = verdict_sentence(said)
    assert (
        "yeoh_stiffening reduces the error from" in words and "does not explain all of it" in words
    )
    assert "the remaining error varies with the stretch" in words


@pytest.mark.parametrize("name", ["epfl_c5_w7_bending", "epfl_c5_w7_blocked"])
def test_what_takes_most_of_the_error_of_bellows_is_said_though_much_is_left(name):
    """None of the effects of the blocked set halves its error alone."""
    path = next((path for path in SETS if path.name == name), None)
    if path is None:
        pytest.skip(f"no set {name}")
    tried = ("ballooning", "tube_lag", "viscoelasticity", "sensor_drift", "force_offset")
    known = {effect: kind for effect, kind in effect_classes().items() if effect in tried}
    said = diagnose(_every(16, load_measurements(path)), load_model("linear"), known).diagnosis
    assert said.verdict == "unexplained"
    assert said.helps[0].name == "ballooning"
    errors = [said.rmse_before, *(one.rmse_after for one in said.helps)]
    assert errors == sorted(errors, reverse=True) and errors[-1] < errors[0] / 3.0
