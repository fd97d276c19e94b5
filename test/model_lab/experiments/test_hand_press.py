"""A pressed hand in the lab: from a synthesised set to a verdict and a model file."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from model_lab.bench.hand_press_set import hand_press_set
from model_lab.bench.synthesize import synthesize, write_synthesised
from model_lab.comparison.add import add_effect, write_model
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.forward_selection import closer
from model_lab.diagnosis.search import score_base
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_press import PRESS_STEP, HandPress, press_errors
from model_lab.fitting.notices import notices
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.hands import TORQUE_ARM, WRENCH_COLUMNS, Plate
from model_lab.measurements.load import load_measurements
from model_lab.measurements.save import write_set
from model_lab.rules import RULES
from model_lab.slips.candidates import candidates
from softhand_model.effects import effect_classes
from softhand_model.effects.hand_parts import Friction
from softhand_model.effects.hand_wrench import PlateHeight, WrenchBias, WrenchGain
from softhand_model.effects.load import Gravity
from softhand_model.model_file import load_model

CLASSES = effect_classes()
SEEN = {name: CLASSES[name] for name in ("friction", "wrench_gain")}
WEIGHT = Gravity(mass_scale=1.0)


def single(*protocols):
    """Runs of a hand of one finger, lower than a whole one."""
    data = hand_press_set("single_finger")
    chosen = [run for run in data.runs if not protocols or run.protocol in protocols]
    lower = [
        replace(run, columns={**run.columns, "wrist.z": run.columns["wrist.z"] - 0.008})
        for run in chosen
    ]
    return replace(data, runs=tuple(lower))


def synthesize_single(noise):
    """A noisy set of a hand of one finger, with nothing hidden."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "model_lab.bench.synthesize.hand_press_set",
            lambda: single("all_forward", "all_back", "fingers_aside"),
        )
        return synthesize("press", 1, False, noise=noise).data


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_from_a_synthesised_set_to_a_model_file(monkeypatch, tmp_path):
    monkeypatch.setattr(
        "model_lab.bench.synthesize.hand_press_set",
        lambda: single("all_forward", "all_back", "fingers_aside"),
    )
    made = synthesize("press", 1, True, {"friction": CLASSES["friction"]}, noise=0.005)
    write_synthesised(made, tmp_path / "set")
    data = load_measurements(tmp_path / "set")
    (hidden,) = made.truth["effects"]

    answer = diagnose(data, load_model("base"), SEEN).diagnosis.as_json()
    assert answer["verdict"] == "effects_missing"
    (named,) = answer["effects"]
    assert named["name"] == "friction"
    low, high = named["parameters"]["factor"]["interval"]
    assert low <= hidden["parameters"]["factor"] <= high
    assert high - low < 0.1
    assert answer["rmse_after"] < 1.2 * answer["noise_floor"] < 0.6 * answer["rmse_before"]

    addition = add_effect("friction", data, load_model("base"), CLASSES)
    write_model(tmp_path / "mended.yaml", addition.model)
    mended = load_model(tmp_path / "mended.yaml")
    errors = [compare(data, model).errors.held_out.rmse for model in (load_model(), mended)]
    assert errors[1] < 0.6 * errors[0]


def test_a_set_reads_as_it_was_written(tmp_path):
    data = single("all_forward")
    write_set(replace(data, plate=Plate(0.4, 0.01)), tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    assert read.plate == Plate(0.4, 0.01)
    assert read.outputs == data.outputs
    for name, values in data.runs[0].columns.items():
        assert read.runs[0].columns[name] == pytest.approx(values, abs=1e-8)


def test_torques_count_over_an_arm():
    data = single("all_forward")
    columns = {**data.runs[0].columns, "wrench.fx": np.full(61, 2.0), "wrench.tx": np.full(61, 3.0)}
    table = replace(data, runs=(replace(data.runs[0], columns=columns),)).table
    first = [part[0] for part in table.of_run(table.value, 0)]
    assert first == pytest.approx([2.0, 0.0, 0.0, 3.0 / TORQUE_ARM, 0.0, 0.0])


def test_a_gauge_multiplies_and_adds_along_its_own_axes():
    data = single("all_forward")
    model = HandPress(data)
    plain = np.array(data.table.of_run(model.predict({}, [WEIGHT])[0], 0))
    bias = WrenchBias(fx=0.3, fy=0.0, fz=0.0, tx=0.0, ty=0.0, tz=0.02)
    read = np.array(data.table.of_run(model.predict({}, [WEIGHT, bias])[0], 0))
    # palm down: the wrist's x is down, its z is the world's x
    expected = np.array([0.0, 0.0, -0.3, 0.02 / TORQUE_ARM, 0.0, 0.0])
    assert read - plain == pytest.approx(np.tile(expected[:, None], 61), abs=1e-9)
    more = np.array(data.table.of_run(model.predict({}, [WEIGHT, WrenchGain(factor=1.2)])[0], 0))
    few = HandPress(data, 8, PRESS_STEP).predict({}, [WEIGHT])[0]
    taken_off = plain - np.array(data.table.of_run(few, 0))
    assert more - taken_off == pytest.approx(1.2 * (plain - taken_off), abs=1e-9)


def test_friction_of_the_plate_times_its_factor():
    data = single("all_forward")
    smooth = replace(data, plate=Plate(0.15))
    found = HandPress(data, 8, 0.02).predict({}, [WEIGHT, Friction(factor=0.5)])
    assert found == pytest.approx(HandPress(smooth, 8, 0.02).predict({}, [WEIGHT]), abs=1e-12)


def test_what_few_segments_and_long_steps_are_off_by_is_taken_off():
    data = single("all_forward", "all_back")
    exact = HandPress(data, 32, 0.005).predict({}, [WEIGHT])
    error = rms(HandPress(data).predict({}, [WEIGHT]) - exact)
    assert error < 0.5 * rms(HandPress(data, 8, PRESS_STEP).predict({}, [WEIGHT]) - exact)
    assert 0.5 * error < rms(press_errors(data, load_model()).whole[-1]) < 3.0 * error


def test_a_fit_knows_what_its_effect_changes_of_the_error_of_few_segments():
    data, hidden = single("all_forward", "all_back", "fingers_aside"), 0.5
    exact = HandPress(data, 16, 0.02).predict({}, [WEIGHT, Friction(factor=hidden)])[0]
    runs = []
    for index, run in enumerate(data.runs):
        read = np.array(data.table.of_run(exact, index)) / data.output_scales[:, None]
        columns = dict(zip(WRENCH_COLUMNS, read, strict=True))
        runs.append(replace(run, columns={**run.columns, **columns}))
    data = replace(data, runs=tuple(runs))
    problem, _ = pose_problem(data, load_model(), {"friction": Friction})
    found = score_base(problem, ["friction"], np.array([1.0, hidden]))
    again = closer(problem, found)
    assert again.fit.rmse < 0.3 * found.fit.rmse


def test_slopes_do_not_depend_on_their_step_as_roundings_of_contact_would_make_them():
    data, hidden = single("all_forward", "all_back", "fingers_aside"), 0.6
    forward = Forward(data, effects=[Friction], fixed=[WEIGHT])

    def slope(share):
        width = np.log(2.0)
        ends = np.array([[1.0, hidden], [1.0, hidden * np.exp(share * width)]])
        return np.diff(forward.predict(ends), axis=0)[0] / (share * width)

    one, twice = slope(forward.slope_step), slope(2.0 * forward.slope_step)
    print(
        rms(twice - one) / rms(one),
        rms(slope(1e-4) - one) / rms(one),
        rms(slope(2e-4) - slope(1e-4)) / rms(one),
    )
    assert rms(twice - one) < 0.1 * rms(one)


def test_engines_differ_by_a_share_of_the_force_for_a_while_and_by_a_lead():
    data = single("all_forward")
    wrench = HandPress(data, 8, PRESS_STEP).predict({}, [WEIGHT])[0]
    forces = np.array(data.table.of_run(wrench, 0)[:3])
    force = np.linalg.norm(forces, axis=0)
    errors = press_errors(data, load_model()).apart
    *shares, ahead = [data.table.of_run(error, 0)[2] for error in errors]
    lift = np.array(shares)
    covariance = lift.T @ lift
    assert np.sqrt(np.diag(covariance)) == pytest.approx(RULES.press_engine * force, rel=1e-9)
    later = force[1:] * force[:-1] * RULES.press_engine**2 * np.exp(-0.05 / RULES.press_engine_time)
    assert np.diag(covariance, 1) == pytest.approx(later, rel=1e-6, abs=1e-18)
    moved = 0.5 * RULES.press_engine_lead / 0.05 * (forces[2, 2:] - forces[2, :-2])
    assert ahead[1:-1] == pytest.approx(moved, rel=1e-9)


def test_repeats_whose_sensors_differ_little_are_pressed_once_at_their_mean():
    (run,) = single("all_forward").runs[:1]
    column = single().pressures[0]
    moved = [
        replace(run, name=name, columns={**run.columns, column: run.columns[column] + shift})
        for name, shift in (("a", 0.0), ("b", 80.0), ("c", 150.0))
    ]
    data = replace(single("all_forward"), runs=tuple(moved))
    model = HandPress(data, 8, PRESS_STEP)
    found = [np.array(data.table.of_run(model.predict({}, [WEIGHT])[0], run)) for run in range(3)]
    assert (found[0] == found[1]).all()
    alone = HandPress(replace(data, runs=tuple(moved[:1])), 8, PRESS_STEP)
    higher = replace(moved[0], columns={**run.columns, column: run.columns[column] + 40.0})
    mean = replace(data, runs=(higher,))
    expected = HandPress(mean, 8, PRESS_STEP).predict({}, [WEIGHT])[0]
    assert np.ravel(mean.table.of_run(expected, 0)) == pytest.approx(np.ravel(found[0]), abs=1e-9)
    assert rms(found[2] - found[0]) > rms(alone.predict({}, [WEIGHT])[0] - expected)


def with_a_jump():
    """Two presses of a finger of one segment; in the first one the pressure jumps."""
    data = single("all_forward", "all_back")
    (name, one), (channel,) = *data.specimens.items(), data.pressures
    specimens = {name: replace(one, hand=replace(one.hand, segments=1))}
    column = np.where(np.arange(data.runs[0].samples) < 10, 0.0, 35e3)
    jumps = replace(data.runs[0], columns={**data.runs[0].columns, channel: column})
    return replace(data, specimens=specimens, runs=(jumps, data.runs[1]))


def test_a_run_whose_joint_does_not_come_to_rest_is_left_out_and_the_rest_compared(monkeypatch):
    data = with_a_jump()
    monkeypatch.setattr("model_lab.experiments.hand_press.SMALLER", ())
    model = HandPress(data, 1, PRESS_STEP)
    found = model.predict({}, [WEIGHT])[0]
    assert "joint 1 of finger does not come to rest at 0.5 s" in model.unsettled[0]
    assert np.isnan(data.table.of_run(found, 0)).all()
    assert np.isfinite(data.table.of_run(found, 1)).all()
    problem, _ = pose_problem(data, load_model(), {})
    assert [run.name for run in problem.data.runs] == [data.runs[1].name]
    (said,) = [
        notice.text
        for notice in notices(problem.data, problem.floor, problem.data.table.value)
        if notice.kind == "left_out"
    ]
    assert f"{data.runs[0].name}, in which joint 1 of" in said
    with pytest.raises(ValueError, match="expected at least one run that the model can compute"):
        pose_problem(replace(data, runs=data.runs[:1]), load_model(), {})


def test_a_joint_that_does_not_come_to_rest_does_so_in_smaller_steps():
    model = HandPress(with_a_jump(), 1, PRESS_STEP)
    assert np.isfinite(model.predict({}, [WEIGHT])).all()
    assert not model.unsettled


def lowered(run):
    return replace(run, columns={**run.columns, "wrist.z": run.columns["wrist.z"] - 0.06})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: replace(data, plate=None), "expected an entry `plate`, got none"),
        (
            lambda data: replace(data, runs=tuple(map(lowered, data.runs))),
            "expected a palm above the plate.*mm below it",
        ),
        (
            lambda data: replace(data, runs=(replace(data.runs[0], wrist_rpy=(0.1, 0.0, 0.0)),)),
            "wrist_rpy: expected either",
        ),
        (
            lambda data: replace(
                data,
                runs=(
                    replace(
                        data.runs[0], columns={k: v[::3] for k, v in data.runs[0].columns.items()}
                    ),
                ),
            ),
            "got 21 up to 0.15 s apart",
        ),
    ],
)
def test_what_cannot_be_followed_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        HandPress(change(hand_press_set()))


def higher(data, way):
    """The set with the wrist higher by a way [m]."""
    runs = [
        replace(run, columns={**run.columns, "wrist.z": run.columns["wrist.z"] + way})
        for run in data.runs
    ]
    return replace(data, runs=tuple(runs))


def test_a_higher_plate_presses_as_a_lower_wrist_does():
    data = single("all_forward")
    stated, lowered = (HandPress(one, step=PRESS_STEP) for one in (data, higher(data, -2e-3)))
    lifted = stated.predict({}, [WEIGHT, PlateHeight(offset=2e-3)])
    assert lifted == pytest.approx(lowered.predict({}, [WEIGHT]), abs=1e-4)
    assert rms(lifted - stated.predict({}, [WEIGHT])) > 0.01


def test_a_plate_that_is_higher_than_stated_is_named():
    seen = {name: CLASSES[name] for name in ("friction", "wrench_gain", "plate_height")}
    data = higher(synthesize_single(noise=0.005), 5e-3)
    (named,) = diagnose(data, load_model("base"), seen).diagnosis.effects
    assert named.name == "plate_height"
    low, high = named.parameters["offset"].interval
    assert low <= 5e-3 <= high and high - low < 2e-3


def test_a_sensor_tared_with_bent_fingers_reads_zero_where_a_run_begins(tmp_path):
    data = single("all_forward", "all_back")
    (slip,) = [one for one in candidates(data) if one.name == "tared"]
    plate = yaml.safe_load(slip.mend)["plate"]
    write_set(replace(data, plate=Plate(**plate)), tmp_path / "set")
    tared = load_measurements(tmp_path / "set")
    assert tared.plate == slip.mended.plate == replace(data.plate, tared=True)
    whole, less = (HandPress(one).predict({}, [WEIGHT])[0] for one in (data, slip.mended))
    for part in data.table.series:
        shift = whole[part.samples] - less[part.samples]
        assert shift == pytest.approx(np.full(part.length, whole[part.start]), abs=1e-12)
