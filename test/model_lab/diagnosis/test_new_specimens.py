"""Softening in runs of new specimens: what a diagnosis says if the set does not say so."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from lab_sets import measured, run

from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.new_specimens import as_new
from model_lab.experiments.forward import Forward
from model_lab.report.sentences import verdict_sentence
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

CLASSES = {
    name: effect_classes()[name] for name in ("mullins_softening", "gent_stiffening", "tube_lag")
}
SOFTENING = 0.2
NOISE = 0.005  # [rad]


def softened(new):
    """Four runs with peaks that rise or fall, of one specimen that softens; new: whether each run
    begins with one that was never stretched.
    """
    time = np.arange(0.0, 60.0, 0.25)
    runs = []
    for name, peaks in (("rising", (14e3, 20e3, 26e3)), ("late", (24e3, 12e3, 30e3))):
        pressure = np.concatenate(
            [peak * (1.0 - np.abs(np.linspace(-1.0, 1.0, 80))) for peak in peaks]
        )
        for repeat in (1, 2):
            one = run(f"{name}_{repeat}", time, virgin=new, pressure=pressure)
            runs.append(replace(one, protocol=name))
    data = measured("free_bending", runs)
    mullins = CLASSES["mullins_softening"](softening=SOFTENING, stretch_scale=0.05)
    forward = Forward(data, "pneuflex", (), [mullins], {})
    angles = forward.predict(forward.start()[None])[0].reshape(4, -1)
    rng = np.random.default_rng(5)
    read = angles + NOISE * rng.standard_normal(angles.shape)
    found = (
        replace(one, columns={**one.columns, "tip_angle": angle})
        for one, angle in zip(data.runs, read, strict=True)
    )
    return replace(data, runs=tuple(found))


@pytest.mark.parametrize("new", [True, False])
def test_new_specimens_are_told_where_the_set_does_not_say_so(new):
    stated = softened(new)
    data = replace(stated, runs=tuple(replace(one, virgin=False) for one in stated.runs))
    found = diagnose(data, Model("pneuflex"), CLASSES).diagnosis
    assert [slip.name for slip in found.slips] == (["virgin"] if new else [])
    assert (found.verdict_mended or found.verdict) == "effects_missing"
    (effect,) = found.effects
    assert effect.name == "mullins_softening"
    assert effect.parameters["softening"].value == pytest.approx(SOFTENING, rel=0.1)
    if new:
        said = verdict_sentence(found)
        assert "virgin is true in each run" in said and "rising_1: {virgin: true}" in said


def test_sets_without_time_have_no_memory_that_new_specimens_could_lack():
    """The crash of every static set that nothing explained."""
    stated = softened(False)
    static = [
        replace(one, columns={k: v for k, v in one.columns.items() if k != "time"})
        for one in stated.runs
    ]
    found = SimpleNamespace(verdict="unexplained", verdict_mended="")
    assert as_new(replace(stated, runs=tuple(static)), found, Model("pneuflex"), CLASSES) is None
