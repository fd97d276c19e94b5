"""Bellows, clocks, cameras and tired rubber, hidden in other forms than the lab's: the family is
named, and effects that were there before keep what is theirs.
"""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run

from bench.hidden import make_set, sensing
from model_lab.comparison.add import add_effect
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import Specimen
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model, load_model

NEW = {
    "chamber_contact",
    "ballooning",
    "creep",
    "ageing",
    "sensor_drift",
    "saturation",
    "clock_offset",
    "camera_perspective",
    "angle_gain",
}
FORMS = {
    "balloon_series": "ballooning",
    "near_camera": "camera_perspective",
    "warming_sensor": "sensor_drift",
    "clock_drift": "clock_offset",
}


def names(data, model=None):
    """Names of the diagnosis, each with those tied with it."""
    found = diagnose(data, model or load_model("base")).diagnosis
    groups = zip(found.effects, found.tied, strict=True)
    return found.verdict, [{effect.name, *others} for effect, others in groups]


def hidden(folder, law, **options):
    chosen = {"seed": 11, "ratio": 5.0, "samples": 90, **options}
    make_set(folder, "free_bending", [(law, {})], **chosen)
    return load_measurements(folder)


@pytest.mark.parametrize("law", FORMS)
def test_another_form_of_the_cause_is_named_as_its_family(law, tmp_path):
    verdict, found = names(hidden(tmp_path, law))
    assert verdict == "effects_missing"
    assert len(found) == 1 and FORMS[law] in found[0] and len(found[0]) <= 3


@pytest.mark.parametrize(
    ("law", "name"),
    [
        ("soft_dead_zone", "dead_zone"),
        ("arruda_boyce", "gent_stiffening"),
    ],
)
def test_what_had_its_name_before_is_not_taken_by_the_new_ones(law, name, tmp_path):
    verdict, found = names(hidden(tmp_path, law))
    assert verdict == "effects_missing"
    assert len(found) == 1 and name in found[0] and not found[0] & NEW


def bellows(scale, seed=0):
    """Blocked bellows under pressures held and let off: five chambers that touch one after the
    other within a tenth of the pressure, behind a tube, on a gauge with 0.4 % of noise.
    """
    random, time = np.random.default_rng(seed), np.linspace(0.0, 6.0, 1201)
    held = np.interp(time, [0.1, 0.4, 3.0, 3.3], [0.0, 1.0, 1.0, 0.0])
    chamber = sensing.first_order(time[None], held[None], 0.25)[0]
    runs = []
    for number, peak in enumerate(np.repeat(scale * np.linspace(0.2, 1.0, 6), 2)):
        acting, onsets = peak * chamber, scale * np.linspace(0.5, 0.6, 5)
        more = sum(np.maximum(acting - onset, 0.0) for onset in onsets) / scale
        force = acting / scale * (0.2 + more) + 0.01 * random.standard_normal(time.size)
        columns = {"pressure": (peak * held)[::15], "tip_force": force[::15]}
        one = run(f"r{number}", time[::15], of="a", **columns)
        runs.append(replace(one, protocol=f"to_{peak / scale:.2f}"))
    return measured("blocked_tip", runs, Specimen("a"))


@pytest.mark.parametrize("scale", [30e3, 250e3])
def test_bellows_of_which_only_the_outside_is_known_touch_behind_a_tube(scale):
    data, model, additions = bellows(scale), Model(base="linear"), []
    for name in ("chamber_contact", "tube_lag"):
        additions.append(add_effect(name, data, model, effect_classes()))
        model = additions[-1].model
    first, last = additions
    assert last.after.held_out.rmse < 0.1 * first.before.held_out.rmse
    assert last.after.held_out.rmse < 1.6 * last.problem.floor.total
    found = {effect.name: effect.values for effect in model.effects}
    assert 0.5 < found["chamber_contact"]["onset"] / scale < 0.6
    assert found["tube_lag"]["time_constant"] == pytest.approx(0.25, rel=0.1)
