"""Adding an effect: the generic term where no other explains the error, and the model file."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import measured, run

from bench.hidden import make_set
from model_lab.bench.synthesize import synthesize
from model_lab.cli.main import main
from model_lab.comparison.add import add_effect, write_model
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_pose import HandPose
from model_lab.measurements.load import load_measurements
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes, effects_in_file
from softhand_model.effects.load import Gravity
from softhand_model.hand.hand import load_hand
from softhand_model.hand.joint_stiffness import SpringModel
from softhand_model.model_file import Model, load_model

COMMAND = ["add", "discrepancy", "--model", "base", "--data"]


@pytest.fixture(scope="module")
def saturated(tmp_path_factory):
    """Free bending under a sensor that stops at an angle: no effect of the catalogue does that."""
    folder = tmp_path_factory.mktemp("saturated") / "set"
    make_set(folder, "free_bending", [("gain_step", {})], seed=4, ratio=5.0, noise=0.006)
    return folder


def test_the_generic_term_takes_off_much_of_an_error_that_no_effect_explains(saturated):
    data = load_measurements(saturated)
    addition = add_effect("discrepancy", data, load_model("base"), effect_classes())
    floor = addition.problem.floor.total
    assert addition.before.held_out.rmse > 3.0 * floor
    assert addition.after.held_out.rmse < 0.6 * addition.before.held_out.rmse
    forward = Forward(
        data, effects=(), fixed=addition.model.effects, calibration=addition.model.calibration
    )
    left = forward.measured - forward.predict(forward.start()[None])[0]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(addition.after.fit.rmse, rel=1e-6)


def test_the_model_file_and_the_text_say_that_it_is_no_physics(saturated, tmp_path, capsys):
    out = tmp_path / "m.yaml"
    assert main([*COMMAND, str(saturated), "--out", str(out)]) == 0
    assert "a generic term, not physics" in capsys.readouterr().out
    (line,) = (line for line in out.read_text().splitlines() if "name: discrepancy" in line)
    assert line.endswith("# a generic term, not physics")
    (effect,) = load_model(out).effects
    assert effect.name == "discrepancy"
    finger = load_hand("single_finger").chain("finger")
    bend = discretise(finger, 5, load_model(out)).step(1e-3, [40e3], np.zeros((5, 3)))
    assert np.isfinite(bend).all()


def test_what_the_data_do_not_show_of_it_stays_at_nothing(saturated):
    """No actuator is stretched by more than 2 in these runs."""
    data = load_measurements(saturated)
    addition = add_effect("discrepancy", data, load_model("base"), effect_classes())
    assert addition.model.effects[0].values["a7"] == 0.0
    assert "discrepancy" not in addition.model.std


def test_valve_pulses_have_no_generic_term_and_say_so_in_one_line(tmp_path, capsys):
    make_set(tmp_path / "set", "valve_pulse", [("leakage", {})], seed=1, ratio=4.0, samples=40)
    assert main([*COMMAND, str(tmp_path / "set"), "--out", str(tmp_path / "m.yaml")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "no rubber is strained" in said and "pulse_bias" in said


# ---------------------------------------------------------------- the model file
OWN = """
from softhand_model.effects import LoadEffect, Parameter

class Own(LoadEffect):
    name = "own"
    experiments = frozenset({"free_bending"})
    parameters = (Parameter("size", "", 0.0, 2.0),)

    def modulus_factor(self, temperature):
        return 1.0 + self.values["size"]
"""


def _gravity(scale):
    return effect_classes()["gravity"](mass_scale=scale)


def _said(model):
    effects = [(type(effect).__name__, dict(effect.values)) for effect in model.effects]
    return model.base, model.calibration, effects, model.std, model.springs


@pytest.mark.parametrize(
    "model",
    [
        Model(),
        Model("linear", {"coefficient": {"s 1": 2.5e-5, "no": 1e-7}}),
        Model("pneuflex", {"inflate": 1e-12 / 3.0, "deflate": 2e-9}),
        Model(calibration={"modulus_scale": 1.03}, effects=(_gravity(1.0 / 3.0),)),
        Model(
            calibration={"modulus_scale": {"A": np.float64(1.03), "1": 0.97}},
            effects=(_gravity(np.float64(0.9)),),
            std={"gravity": {"mass_scale": 0.01}},
        ),
        Model(springs=SpringModel("curvature", "section", 0.5)),
    ],
    ids=["empty", "linear", "valve", "scalar", "batches", "springs"],
)
def test_a_model_comes_back_equal(tmp_path, model):
    path = tmp_path / "models" / "m.yaml"
    write_model(path, model, "made by a test\nsecond line")
    assert _said(load_model(path)) == _said(model)


def test_the_weight_that_every_model_of_a_hand_has_is_fitted():
    data = synthesize("hand_pose", 3, False, noise=0.0005).data
    model = load_model("gravity")
    predicted = HandPose(data).predict({}, [Gravity(mass_scale=1.4)])[0]
    random, runs = np.random.default_rng(0), []
    for number, one in enumerate(data.runs):
        parts = data.table.of_run(predicted, number)
        noise = 5e-4 * random.standard_normal(parts.shape)
        columns = dict(zip(data.outputs, parts + noise, strict=True))
        runs.append(replace(one, columns={**one.columns, **columns}))
    heavy = replace(data, runs=tuple(runs))
    added = add_effect("gravity", heavy, model, effect_classes())
    assert added.effect.parameters["mass_scale"].value == pytest.approx(1.4, abs=0.02)
    assert [effect.name for effect in added.model.effects] == ["gravity"]
    assert added.after.held_out.rmse < 0.7 * added.before.held_out.rmse
    with pytest.raises(ValueError, match="does not have yet, got gravity"):
        add_effect("gravity", heavy, added.model, effect_classes())


def test_a_user_effect_is_found_beside_the_model_wherever_both_move(tmp_path):
    (tmp_path / "a" / "effects").mkdir(parents=True)
    file = tmp_path / "a" / "effects" / "own.py"
    file.write_text(OWN)
    own = effects_in_file(file)["own"](size=1.5)
    write_model(tmp_path / "a" / "m.yaml", Model(effects=(own,), files={"own": file}))
    assert "file: effects/own.py" in (tmp_path / "a" / "m.yaml").read_text()
    (tmp_path / "a").rename(tmp_path / "b")
    again = load_model(tmp_path / "b" / "m.yaml", allow_effect_files=True)
    assert again.effects[0].values == {"size": 1.5}
    write_model(tmp_path / "c" / "m.yaml", again)
    copied = load_model(tmp_path / "c" / "m.yaml", allow_effect_files=True)
    assert copied.effects[0].values == {"size": 1.5}
    assert copied.files == {"own": tmp_path / "c" / "own.py"}


def test_a_copied_effect_takes_no_other_files_place(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "own.py").write_text(OWN + f"# {name}")
    model = Model(files={"own": tmp_path / "a" / "own.py"})
    with pytest.raises(ValueError, match=r"b/own\.py: expected a new file"):
        write_model(tmp_path / "b" / "m.yaml", model)


def test_a_file_is_overwritten_by_force_alone(tmp_path):
    path = tmp_path / "m.yaml"
    write_model(path, Model("linear"))
    with pytest.raises(ValueError, match=r"m\.yaml: expected a new file.*--force"):
        write_model(path, Model())
    assert load_model(path).base == "linear"
    write_model(path, Model(), force=True)
    assert load_model(path).base == "pneuflex"


def test_an_error_that_is_unknown_is_left_out(tmp_path):
    std = {"gravity": {"mass_scale": float("inf")}}
    write_model(tmp_path / "m.yaml", Model(effects=(_gravity(1.0),), std=std))
    assert load_model(tmp_path / "m.yaml").std == {}


@pytest.mark.parametrize("name", ["m.txt", "m", "m.json"])
def test_a_name_that_would_not_load_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match="a name that ends in .yaml or .yml"):
        write_model(tmp_path / name, Model())


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match=r"m\.yaml: expected a place to write to"):
        write_model(tmp_path / "file" / "m.yaml", Model())


def test_a_model_that_leaves_much_is_written_with_what_fits_the_data_best():
    """Creep for a relaxation of 0.3 s: weights of the noise alone would leave 0.040 rad."""
    time, level = np.arange(0.0, 32.0, 0.15), [0.0, 10e3, 20e3, 30e3, 15e3, 5e3, 0.0, 0.0]
    drives = {"stair": (time, np.repeat(level, 27)[: len(time)])}
    for name, seconds in (("slow", 20.0), ("fast", 1.5)):
        triangle = 30e3 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 200)))
        drives[name] = np.linspace(0.0, seconds, 200), triangle
    data = measured(
        "free_bending",
        [
            replace(run(f"{name}_{repeat}", drive[0], pressure=drive[1]), protocol=name)
            for name, drive in drives.items()
            for repeat in (1, 2)
        ],
    )
    known = effect_classes()
    relaxes = known["viscoelasticity"](relative_modulus=0.2, relaxation_time=0.3)
    forward = Forward(data, "pneuflex", (), [relaxes], {})
    angles = forward.predict(forward.start()[None])[0]
    angles = angles + 0.008 * np.random.default_rng(0).standard_normal(len(angles))
    parts = np.split(angles, np.cumsum([one.samples for one in data.runs])[:-1])
    read = (
        replace(one, columns={**one.columns, "tip_angle": part})
        for one, part in zip(data.runs, parts, strict=True)
    )
    added = add_effect("creep", replace(data, runs=tuple(read)), Model("pneuflex"), known)
    assert added.after.fit.rmse <= added.after.held_out.rmse
    assert added.after.fit.rmse < 0.03
