"""Two relaxation times are a generalized Maxwell solid; the second is sought after the first."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run

from model_lab.diagnosis.diagnose import candidates_of, diagnose
from model_lab.experiments.forward import Forward
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.measurement_set import Specimen
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

MODULUS, NOISE = 60e3, 300.0
STRIP = Specimen("strip", {"gauge_length": 0.03, "shear_modulus": MODULUS}, batch="A")
FIRST, SECOND = (0.30, 0.6), (0.20, 9.0)  # modulus over the relaxed one, time [s]


def relaxed(name, values):
    """The effect of this name."""
    keys = ("relative_modulus", "relaxation_time")
    return effect_classes()[name](**dict(zip(keys, values, strict=True)))


def pulled(*effects, time, stretch):
    """A strip that is pulled so, and its stress."""
    data = measured("uniaxial", [run("r", time, of="strip", stretch=stretch)], STRIP)
    forward = Forward(data, "pneuflex", (), effects, {})
    return data, forward.predict(forward.start()[None])[0]


def test_two_are_a_generalized_maxwell_solid():
    """Of a step, exp(-t/tau1) and exp(-t/tau2) remain, with shares by partial fractions."""
    time = np.concatenate([[0.0, 1e-6], 1e-6 + np.linspace(0.05, 30.0, 600)])
    stretch = np.where(time > 0.0, 1.5, 1.0)
    effects = relaxed("viscoelasticity", FIRST), relaxed("second_relaxation", SECOND)
    stress = pulled(*effects, time=time, stretch=stretch)[1]
    (g1, tau1), (g2, tau2) = FIRST, SECOND
    one, two = g1 * (1 + g2 * tau2 / (tau2 - tau1)), g2 * (1 + g1 * tau1 / (tau1 - tau2))
    factor = 1.0 + one * np.exp(-time / tau1) + two * np.exp(-time / tau2)
    exact = MODULUS * (1.5 - 1.5**-2) * factor
    assert stress[1:] == pytest.approx(exact[1:], rel=2e-6)


def made(rng):
    """Holds and ramps of a strip that relaxes with two times, each measured twice."""
    time = np.arange(0.0, 50.0, 0.1)
    courses = {
        "hold": np.interp(time, [0.0, 0.5, 30.0, 30.5], [1.0, 1.5, 1.5, 1.2]),
        "ramps": 1.0 + 0.5 * np.abs(np.sin(2.0 * np.pi * time / 25.0)),
        "steps": np.interp(time, [0, 1, 8, 9, 16, 17, 30], [1, 1.2, 1.2, 1.4, 1.4, 1.1, 1.1]),
    }
    effects = relaxed("viscoelasticity", FIRST), relaxed("second_relaxation", SECOND)
    runs = []
    for name, course in courses.items():
        data, stress = pulled(*effects, time=time, stretch=course)
        for repeat in "ab":
            read = stress + NOISE * rng.standard_normal(len(stress))
            columns = {**data.runs[0].columns, "stress": read}
            one = replace(data.runs[0], name=f"{name}_{repeat}", protocol=name, columns=columns)
            runs.append(one)
    return measured("uniaxial", runs, STRIP)


def test_a_second_time_is_sought_where_the_model_has_one():
    data = made(np.random.default_rng(2))
    classes = {
        n: effect_classes()[n]
        for n in ("viscoelasticity", "second_relaxation", "hysteresis", "gent_stiffening")
    }
    plain = Model("pneuflex")
    assert "second_relaxation" not in candidates_of(pose_problem(data, plain, classes)[0], plain)[0]
    std = {"viscoelasticity": {"relative_modulus": 0.05, "relaxation_time": 0.5}}
    one = (relaxed("viscoelasticity", (0.4, 2.0)),)
    known = Model("pneuflex", effects=one, std=std)
    found = diagnose(data, known, classes).diagnosis
    (effect,) = found.effects
    assert effect.name == "second_relaxation"
    times = effect.parameters["relaxation_time"].value
    assert times == pytest.approx(FIRST[1], rel=0.1) or times == pytest.approx(SECOND[1], rel=0.1)
    assert found.rmse_after == pytest.approx(found.noise_floor, rel=0.1)
