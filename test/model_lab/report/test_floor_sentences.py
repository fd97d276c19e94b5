"""One noise floor of one set from `compare`, `diagnose` and `ladder`, or the reason why not."""

from types import SimpleNamespace

import numpy as np
import pytest

from bench import rig_faults as rig
from model_lab.bench.synthesize import synthesize
from model_lab.comparison.compare import errors_of
from model_lab.comparison.ladder import compare_models
from model_lab.diagnosis.diagnose import diagnose
from model_lab.fitting.problem import pose_problem, with_lower_floor
from model_lab.report.floor_sentences import floor_sentence, ladder_sentence
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

SOFTENING = {"mullins_softening": effect_classes()["mullins_softening"]}
FEW = ("mullins_softening", "gent_stiffening", "pressure_offset")
SEVENTH = 6  # index of the first run of the second half
SETS = {
    "clean": lambda: synthesize("uniaxial", 2, False).data,
    "effect": lambda: synthesize("free_bending", 3, True).data,
    "softening": lambda: synthesize("uniaxial", 2, True, SOFTENING).data,
    "event": lambda: rig.slipped_winding(synthesize("uniaxial", 2, False).data, SEVENTH, 0.09),
}
REASONS = {"event": ("events",)}


@pytest.mark.parametrize("name", SETS)
def test_all_print_the_same_floor_or_the_reason(name):
    data, base = SETS[name](), Model("pneuflex")
    classes = {key: effect for key, effect in effect_classes().items() if key in FEW}
    found = diagnose(data, base, classes).diagnosis
    shown = data.output_display.shown
    compared, laddered = errors_of(data, base).floor, compare_models(data, {"base": base}).floor
    assert shown(compared.total) == shown(laddered.total)
    assert found.floor_reasons == REASONS.get(name, ())
    said = floor_sentence(found)
    if not found.floor_reasons:
        assert said == "" and shown(found.noise_floor) == shown(compared.total)
        return
    assert shown(found.noise_floor) != shown(compared.total)
    assert shown(found.noise_floor) in said


def test_a_floor_that_a_better_model_lowers_keeps_that_of_the_model_as_it_is():
    problem, _ = pose_problem(SETS["softening"](), Model("pneuflex"), {})
    random = np.random.default_rng(0)
    residual = random.normal(0.0, 0.5 * problem.floor.total, problem.data.table.samples)
    lower = with_lower_floor(problem, SimpleNamespace(residual=residual))
    lowest = with_lower_floor(lower, SimpleNamespace(residual=0.5 * residual))
    assert lowest.floor.total < lower.floor.total < problem.floor.total
    assert lowest.floor_as_is is lower.floor_as_is is problem.floor
    assert with_lower_floor(lower, SimpleNamespace(residual=residual)) is None


def test_a_ladder_says_whose_floor_it_prints():
    data = synthesize("uniaxial", 2, True, SOFTENING).data
    found = diagnose(data, Model("pneuflex"), SOFTENING)
    values = {name: e.value for name, e in found.diagnosis.effects[0].parameters.items()}
    better = Model("pneuflex", effects=(effect_classes()["mullins_softening"](**values),))
    ladder = compare_models(data, {"base": Model("pneuflex"), "better": better})
    assert "that of better, the best" in ladder_sentence(ladder)
    assert ladder_sentence(compare_models(data, {"better": better})) == ""
