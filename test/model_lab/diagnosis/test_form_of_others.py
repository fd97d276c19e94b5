"""Effects that may only make up for the equation of another one."""

import numpy as np
import pytest
import yaml

from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.report.sentences import verdict_sentence
from softhand_model.model_file import load_model

LENGTH, HEIGHT, WALL, MODULUS = 0.09, 0.02, 0.0025, 67e3
LEVELS = (10.0, 18.0, 26.0, 34.0)  # [kPa]
HOLD, RISE, STEP = 180.0, 0.5, 0.5  # [s]
NOISE = 0.4  # [deg]
MOUNT = "bending_plane_level"
HEADER = "time,pressure,tip_angle"


def angle(pressure):
    """Tip angle [deg] at pressures [kPa]: the equilibrium of the wall by a table of stretches."""
    stretch = np.linspace(1.0, 4.0, 20001)
    ratio = 2.0 / (1.0 + ((HEIGHT - WALL) / HEIGHT) ** 2)  # side walls as thick as the wall
    load = 1e3 * np.asarray(pressure) * ratio * HEIGHT / (4.0 * MODULUS * WALL)
    found = np.interp(load, stretch - stretch**-3, stretch)
    return np.degrees(LENGTH * (found - 1.0) / HEIGHT)


def steps(folder, per_decade, seed):
    """Steps held for minutes, in which the angle itself grows with the logarithm of time; what is
    said of the set.
    """
    folder.mkdir()
    random, runs = np.random.default_rng(seed), {}
    time = np.arange(0.0, HOLD, STEP)
    for number, level in enumerate(2 * LEVELS):
        pressure = level * np.clip((time - 1.0) / RISE, 0.0, 1.0)
        grown = 1.0 + per_decade * np.log10(1.0 + np.maximum(time - 1.0 - RISE / 2, 0.0) / 0.5)
        read = angle(pressure) * grown + random.normal(0.0, NOISE, len(time))
        table = np.column_stack([time, pressure, read])
        run = f"r{number}"
        np.savetxt(folder / f"{run}.csv", table, delimiter=",", header=HEADER, comments="")
        runs[run] = {"specimen": "f", "temperature": 293.15, "file": f"{run}.csv"}
        runs[run]["protocol"] = f"step_{level:.0f}"
    sizes = {"length": LENGTH, "height": HEIGHT, "width": HEIGHT, "wall": WALL, "side_wall": WALL}
    specimen = {**sizes, "shear_modulus": MODULUS, "mass": 0.03, "mount": MOUNT}
    document = {
        "format": "softhand-measurement/1",
        "experiment": "free_bending",
        "title": "held steps",
        "specimens": {"f": specimen},
        "columns": {
            "time": {"unit": "s"}, "pressure": {"unit": "kPa"}, "tip_angle": {"unit": "deg"},
        },
        "runs": runs,
    }  # fmt: skip
    (folder / "experiment.yaml").write_text(yaml.safe_dump(document))
    return diagnose(load_measurements(folder), load_model("base")).diagnosis


@pytest.mark.parametrize(("per_decade", "seed"), [(0.05, 21), (0.1, 22)])
def test_what_only_mends_the_form_of_creep_is_a_guess(per_decade, seed, tmp_path):
    found = steps(tmp_path / "set", per_decade, seed)
    named = {effect.name: effect for effect in found.effects}
    assert not named["creep"].form_of and len(named) > 1
    assert all(effect.form_of == ("creep",) for name, effect in named.items() if name != "creep")
    assert found.guess and found.confidence is None
    assert "only make up for the equation of creep" in verdict_sentence(found)
    assert found.as_json()["effects"][0]["form_of"] == list(found.effects[0].form_of)


def test_one_finer_form_is_named_where_two_plain_effects_would_do(tmp_path):
    """A strip of rubber of Arruda and Boyce, with chains of five links and Cohen's approximation of
    the inverse of Langevin's function; Gent with another law on top fits it as well.
    """
    random, runs, links = np.random.default_rng(15), {}, 5.0

    def chain(root):
        return (3.0 - root**2) / (1.0 - root**2)

    for number in range(3):
        stretch = np.linspace(1.0, 2.9, 190)
        mean = np.sqrt((stretch**2 + 2.0 / stretch) / (3.0 * links))
        stress = 55.0 * (stretch - stretch**-2) * chain(mean) / chain(np.sqrt(1.0 / links))
        read = stress * (1.0 + random.normal(0.0, 0.008)) + random.normal(0.0, 0.3, len(stretch))
        table = np.column_stack([0.2 * np.arange(len(stretch)), stretch, read])
        header = "time,stretch,stress"
        np.savetxt(tmp_path / f"r{number}.csv", table, delimiter=",", header=header, comments="")
        runs[f"r{number}"] = {"specimen": "strip", "protocol": "pull", "file": f"r{number}.csv"}
        runs[f"r{number}"]["temperature"] = 293.15
    document = {
        "format": "softhand-measurement/1",
        "experiment": "uniaxial",
        "title": "pulls",
        "specimens": {"strip": {"shear_modulus": 60e3}},
        "columns": {"time": {"unit": "s"}, "stretch": {"unit": ""}, "stress": {"unit": "kPa"}},
        "calibration": {"modulus": "free"},
        "runs": runs,
    }
    (tmp_path / "experiment.yaml").write_text(yaml.safe_dump(document))
    found = diagnose(load_measurements(tmp_path), load_model("base")).diagnosis
    (named,) = found.effects
    assert named.name == "arruda_boyce" and not found.guess
    assert named.parameters["links"].value == pytest.approx(links, rel=0.03)
