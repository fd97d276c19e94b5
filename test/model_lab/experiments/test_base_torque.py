"""Torque on the base against closed forms, the planar finger and free bending."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model_lab.experiments import base_torque
from model_lab.experiments.base_torque import (
    STANDARD_GRAVITY,
    BaseTorque,
    lane_values,
    neutral_lane,
    torque_errors,
    waves,
)
from model_lab.experiments.forward import Forward
from model_lab.experiments.kept_bodies import Recent
from model_lab.experiments.specimen_models import SpecimenSegments
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import StructureEffect, effect_classes
from softhand_model.hand.joint_stiffness import THESIS, SpringModel
from softhand_model.hand.section import free_curvature, rule_stiffness, side_wall_ratio
from softhand_model.model_file import load_model
from thesis.chapter_3_and_5.planar import Stop, equilibrium, linear_springs, planar_finger

EFFECTS = effect_classes()
SIZE = {
    "length": 0.09,
    "height": 0.02,
    "width": 0.02,
    "wall": 0.002,
    "side_wall": 0.002,
    "shear_modulus": 67e3,
    "mass": 0.035,
}
TAPER = {"height": np.array([[0.0, 0.02], [0.05, 0.016], [0.09, 0.012]])}
STIFFNESS = float(2 / side_wall_ratio(0.02, 0.02, 0.002, 0.002) * rule_stiffness(0.02, 0.002, 67e3))


def run_of(pressure, place, turn, name="r", specimen="f", **more):
    """A run whose tip is at `place` (samples, 3) and turned by scipy's rotation."""
    pressure = np.asarray(pressure, float)
    place = np.broadcast_to(place, (len(pressure), 3))
    quaternion = np.broadcast_to(turn.as_quat(), (len(pressure), 4))
    columns = {"time": 0.05 * np.arange(len(pressure)), "pressure": pressure}
    columns |= {f"tip_{axis}": place[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"tip_q{axis}": quaternion[:, i] for i, axis in enumerate("xyzw")}
    columns |= {f"torque_{axis}": np.zeros(len(pressure)) for axis in "xyz"}
    return Run(name, specimen, name, more.pop("temperature", 293.15), columns, **more)


def measured(*runs, mount="bending_plane_level", **specimens):
    specimens = specimens or {"f": SIZE}
    known = {name: Specimen(name, size, mount, "A") for name, size in specimens.items()}
    return MeasurementSet("base_torque", "torque", known, runs)


def straight(pressure, **more):
    return run_of(pressure, (0.0, 0.0, 0.09), Rotation.identity(), **more)


def torques(data, effects=(), segments=10, modulus=1.0, joints=THESIS):
    found = BaseTorque(data, segments, joints).predict({"modulus_scale[A]": modulus}, effects)
    return found.reshape(len(found), 3, -1) if len(data.runs) == 1 else found


def free_angle(pressure, modulus=67e3):
    return 0.09 * free_curvature(pressure, 0.02, 0.02, 0.002, 0.002, modulus)


def test_straight_finger_carries_its_stiffness_times_the_free_curvature():
    pressure = np.linspace(0.0, 45e3, 7)
    found = torques(measured(straight(pressure)))[0]
    assert found[1] == pytest.approx(-STIFFNESS * free_angle(pressure) / 0.09, rel=1e-6, abs=1e-12)
    assert np.abs(found[[0, 2]]).max() < 1e-12


def test_calibration_and_temperature_scale_rest_and_springs_alike():
    data = measured(straight([20e3, 40e3], temperature=313.15))
    warm = EFFECTS["temperature_modulus"](coefficient=-0.005)
    found = torques(data, [warm], modulus=np.array([0.9, 1.1]))[:, 1]
    for lane, scale in enumerate((0.9, 1.1)):
        factor = scale * (1.0 - 0.005 * 20.0)
        angle = free_angle(np.array([20e3, 40e3]), factor * 67e3)
        assert found[lane] == pytest.approx(-factor * STIFFNESS * angle / 0.09, rel=1e-6)


def test_twisted_finger_twists_back_and_the_coupling_bends_it_sideways():
    data = measured(run_of([0.0], (0.0, 0.0, 0.09), Rotation.from_rotvec([0, 0, 1e-3])))
    plain = torques(data)[0, :, 0]
    assert plain == pytest.approx([0.0, 0.0, STIFFNESS * 1e-3 / 0.09], rel=1e-5, abs=1e-9)
    coupled = torques(data, [EFFECTS["bend_twist_coupling"](k45=0.4)])[0, :, 0]
    expected = STIFFNESS * 1e-3 / 0.09 * np.array([0.4, 0.0, 1.0])
    assert coupled == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_model_file_makes_the_finger_softer_in_twist():
    data = measured(run_of([0.0], (0.0, 0.0, 0.09), Rotation.from_rotvec([0, 0, 1e-3])))
    soft = torques(data, joints=SpringModel(twist=0.2))[0, :, 0]
    assert soft == pytest.approx([0.0, 0.0, 0.2 * STIFFNESS * 1e-3 / 0.09], rel=1e-4, abs=1e-9)


def test_rubber_springs_of_a_straight_finger_carry_the_pressure_alone():
    """h**2*z*p/2 whatever modulus and walls (3.4.3), which linear springs miss."""
    pressure = np.linspace(5e3, 45e3, 3)
    for modulus in (0.9, 1.1):
        found = torques(
            measured(straight(pressure)), modulus=modulus, joints=SpringModel(bending="curvature")
        )[0, 1]
        assert found == pytest.approx(-(0.02**3) * pressure / 2, rel=1e-6)


def test_coupling_stays_within_what_the_springs_can_carry():
    """abs(k45) < sqrt(k_lat*k_tor)/B, all three the same here."""
    (parameter,) = EFFECTS["bend_twist_coupling"].parameters
    for value in (parameter.low, parameter.high):
        matrix = np.array([[1.0, value], [value, 1.0]])
        assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_slack_layer_pulls_less_below_the_free_curvature_only():
    slack = EFFECTS["passive_layer_slack"](ratio=0.6)
    data = measured(straight([30e3]))
    assert torques(data, [slack])[0, 1] == pytest.approx(0.6 * torques(data)[0, 1], rel=1e-6)
    # bent by 30 degrees without pressure: beyond the free curvature of 0
    kappa = np.radians(30.0) / 0.09
    place = ((1 - np.cos(kappa * 0.09)) / kappa, 0.0, np.sin(kappa * 0.09) / kappa)
    bent = measured(run_of([0.0], place, Rotation.from_rotvec([0, kappa * 0.09, 0])))
    assert torques(bent, [slack]) == pytest.approx(torques(bent), rel=1e-9, abs=1e-12)
    assert torques(bent)[0, 1, 0] > 0.01


@pytest.mark.parametrize(("mount", "pull"), [("base_up", 1.0), ("base_down", -1.0)])
def test_heavy_finger_against_a_wall_presses_as_in_the_plane(mount, pull):
    specimens = {"f": {**SIZE, **TAPER}}
    data = measured(straight([28e3]), mount=mount, **specimens)
    chain = SpecimenSegments(data, 10).chains["f"]
    actuator_angles = _segment_angles(specimens["f"], 28e3)
    springs = linear_springs(chain.stiffness[:, 1], actuator_angles)
    gravity = (0.0, pull * STANDARD_GRAVITY)
    pressed = equilibrium(planar_finger(chain), springs, gravity, Stop((-1.0, 0.0), -0.025))
    assert pressed.tip_force > 0.05
    place = (pressed.tip[0], 0.0, pressed.tip[1])
    held = run_of([28e3], place, Rotation.from_rotvec([0, pressed.angles.sum(), 0]))
    found = torques(measured(held, mount=mount, **specimens), [EFFECTS["gravity"](mass_scale=1.0)])[
        0, :, 0
    ]
    moment = chain.stiffness[0, 1] * (pressed.angles[0] - actuator_angles[0])
    # the base's torque is the first joint's and that of the force half a segment before it
    force_x = -pressed.tip_force
    assert found[1] == pytest.approx(moment + 0.0045 * force_x, rel=5e-3)


def _segment_angles(size, pressure):
    """Free angle of each of ten segments, by a fine sum."""
    x = (np.arange(20000) + 0.5) * 0.09 / 20000
    height = np.interp(x, *size["height"].T)
    kappa = free_curvature(pressure, height, 0.02, 0.002, 0.002, 67e3)
    return kappa.reshape(10, -1).sum(axis=1) * 0.09 / 20000


def test_level_finger_sags_between_its_ends():
    """A clamped beam under its weight: w*L**2/12 at the base, and half the twist of its offset."""
    data = measured(straight([0.0]))
    found = torques(data, [EFFECTS["gravity"](mass_scale=0.01)], segments=60)[0, :, 0]
    weight = 0.01 * 0.035 * STANDARD_GRAVITY
    assert found[0] == pytest.approx(weight * 0.09 / 12, rel=0.03)
    assert found[2] == pytest.approx(weight * 0.01 / 2, rel=0.03)
    assert abs(found[1]) < 1e-9


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("viscoelasticity", {"relative_modulus": 0.4, "relaxation_time": 0.5}),
        ("hysteresis", {"relative_pressure": 0.15, "stretch_scale": 0.05}),
        ("tube_lag", {"time_constant": 0.2}),
        ("mullins_softening", {"softening": 0.3, "stretch_scale": 0.3}),
        ("gent_stiffening", {"jm": 6.0}),
    ],
)
def test_effects_act_through_the_free_angle_as_in_free_bending(name, values):
    corners, sample = np.arange(0, 120, 17), np.arange(120)
    course = 20e3 * np.interp(sample, corners, 1 - np.cos(corners / 10))
    data = measured(straight(course, name="a"), straight(0.8 * course[::-1], name="b"))
    effect = EFFECTS[name](**values)
    bent = Forward(replace(data, experiment="free_bending"), fixed=[effect])
    angle = bent.predict(bent.start()[None])[0].reshape(2, -1)
    held = Forward(data, fixed=[effect])
    found = held.predict(held.start()[None])[0].reshape(2, 3, -1)[:, 1]
    assert found == pytest.approx(-STIFFNESS * angle / 0.09, rel=1e-5, abs=1e-9)


def pushed(samples=30, seed=0, name="r", **more):
    """Tips pushed about from where the finger would be at its pressure."""
    random = np.random.default_rng(seed)
    pressure = random.uniform(15e3, 40e3, samples)
    kappa = free_curvature(pressure, 0.02, 0.02, 0.002, 0.002, 67e3)
    places, turns = [], []
    for bend, extra in zip(kappa * 0.009, 0.04 * random.normal(size=(samples, 3)), strict=True):
        place, turn = np.zeros(3), Rotation.identity()
        for joint in range(10):
            place = place + turn.apply([0.0, 0.0, 0.009 if joint else 0.0045])
            more_turn = Rotation.from_rotvec(extra * (1.0 - joint / 10))
            turn = turn * Rotation.from_rotvec([0, bend, 0]) * more_turn
        places.append(place + turn.apply([0.0, 0.0, 0.0045]))
        turns.append(turn.as_quat())
    return run_of(pressure, np.array(places), Rotation.from_quat(turns), name=name, **more)


def test_lanes_are_independent_models():
    data = measured(pushed(), mount="base_up")
    names = ("gravity", "passive_layer_slack", "bend_twist_coupling", "gent_stiffening")
    forward = Forward(data, effects=[EFFECTS[name] for name in names])
    spread = np.random.default_rng(1).uniform(0.8, 1.2, (4, len(forward.parameters)))
    values = forward.start() * spread
    together = forward.predict(values)
    scale = np.abs(together).max()
    for lane in range(4):
        alone = forward.predict(values[lane : lane + 1])[0]
        assert together[lane] / scale == pytest.approx(alone / scale, abs=1e-7)


@pytest.mark.parametrize("name", ["gravity", "bend_twist_coupling", "passive_layer_slack"])
def test_predictions_do_not_depend_on_those_before(name):
    data = measured(pushed())
    ranges = [parameter.typical for parameter in EFFECTS[name].parameters]
    values = np.array([[1.0, *low_and_high] for low_and_high in zip(*ranges, strict=True)])
    forward = Forward(data, effects=[EFFECTS[name]])
    both = forward.predict(values)
    assert forward.predict(values[::-1])[::-1] == pytest.approx(both, rel=1e-7, abs=1e-9)
    alone = [Forward(data, effects=[EFFECTS[name]]).predict(lane[None])[0] for lane in values]
    assert np.array(alone) == pytest.approx(both, rel=1e-7, abs=1e-9)


def test_predictions_are_smooth_in_the_parameters():
    """Differences of 1e-4 of a parameter are those of 1e-3, as far as the curvature allows."""
    data = measured(pushed(), mount="base_up")
    forward = Forward(data, effects=[EFFECTS["bend_twist_coupling"], EFFECTS["gravity"]])
    start = forward.start()
    for shift in np.eye(len(start)):
        slopes = []
        for step in (1e-4, 1e-3):
            sides = forward.predict(np.array([start + step * shift, start - step * shift]))
            slopes.append((sides[0] - sides[1]) / (2 * step))
        size = np.abs(slopes[1]).max()
        assert slopes[0] / size == pytest.approx(slopes[1] / size, abs=1e-4)


def test_specimens_of_their_own_shape_stand_side_by_side():
    runs = pushed(12, 1, name="a"), pushed(12, 2, name="b", specimen="t")
    both = torques(measured(*runs, f=SIZE, t={**SIZE, **TAPER}))
    first = torques(measured(runs[0], f=SIZE)).reshape(1, -1)
    second = torques(measured(runs[1], t={**SIZE, **TAPER})).reshape(1, -1)
    assert both == pytest.approx(np.concatenate([first, second], axis=1), rel=1e-4, abs=1e-7)


def test_layout_is_output_after_output_within_a_run():
    data = measured(pushed(5, name="a"), pushed(7, 1, name="b"))
    forward = Forward(data)
    assert data.table.output.tolist() == [0] * 5 + [1] * 5 + [2] * 5 + [0] * 7 + [1] * 7 + [2] * 7
    together = forward.predict(forward.start()[None])[0]
    alone = Forward(measured(pushed(7, 1, name="b"))).predict(forward.start()[None])[0]
    assert together[15:] == pytest.approx(alone, rel=1e-9, abs=1e-12)


def test_own_stiffness_that_grows_with_the_bend_is_solved():
    class Progressive(StructureEffect):
        """A spring whose moment k*f(b)*(b - r) with f = 1 + 20*b**2."""

        name = "progressive"
        experiments = frozenset({"base_torque"})

        def stiffness_factor(self, bend, rest):
            return 1.0 + 20.0 * bend**2

    kappa = np.radians(60.0) / 0.09
    bend = kappa * 0.009
    place, turn = np.zeros(3), Rotation.identity()
    for joint in range(10):
        place = place + turn.apply([0.0, 0.0, 0.009 if joint else 0.0045])
        turn = turn * Rotation.from_rotvec([0, bend, 0])
    place = place + turn.apply([0.0, 0.0, 0.0045])
    data = measured(run_of([25e3], place, turn))
    rest = free_angle(25e3) / 10
    found = torques(data, [Progressive()])[0, 1, 0]
    assert found == pytest.approx(STIFFNESS / 0.009 * (1 + 20 * bend**2) * (bend - rest), rel=1e-4)


@pytest.mark.parametrize(
    ("place", "turn", "message"),
    [
        ((0.0, 0.0, 90.0), [0, 0, 0, 1], r"run r: tip_x.*actuator is long, 0.09 m, got 90 in samp"),
        ((0.0, 0.0, 0.09), [0, 0, 0, 0.1], "run r: tip_qx ... tip_qw: expected a quaternion of"),
    ],
)
def test_impossible_poses_are_named(place, turn, message):
    run = run_of([0.0], place, Rotation.identity())
    columns = {
        **run.columns,
        **{f"tip_q{a}": np.array([v]) for a, v in zip("xyzw", turn, strict=True)},
    }
    with pytest.raises(ValueError, match=message):
        BaseTorque(measured(replace(run, columns=columns)))


def test_missing_column_and_mass_are_named():
    run = straight([0.0])
    columns = {name: column for name, column in run.columns.items() if name != "tip_qz"}
    with pytest.raises(ValueError, match="runs.r: expected the column tip_qz"):
        BaseTorque(measured(replace(run, columns=columns)))
    light = {key: value for key, value in SIZE.items() if key != "mass"}
    with pytest.raises(
        ValueError, match=r"specimens.f: expected the key mass \[kg\], which the ef"
    ):
        torques(measured(run, f=light), [EFFECTS["gravity"](mass_scale=1.0)])


def test_twelve_runs_of_two_hundred_samples_take_less_than_a_second():
    data = measured(*(pushed(200, seed, name=f"r{seed}") for seed in range(12)))
    model = BaseTorque(data)
    durations = []
    for _ in range(3):
        start = time.process_time()
        model.predict({"modulus_scale[A]": np.ones(1)}, [])
        durations.append(time.process_time() - start)
    assert min(durations) < 1.0


@pytest.mark.parametrize("change", ["pressure", "tip_x", "tip_qw", "length", "gravity", "nothing"])
def test_what_is_kept_of_one_set_is_not_taken_for_another(change, monkeypatch):
    run = pushed(20, 1, name="r")
    torques(measured(run))
    effects = [EFFECTS["gravity"](mass_scale=1.0)] if change == "gravity" else []
    size = SIZE | ({"length": 0.091} if change == "length" else {})
    if change in run.columns:
        run = replace(run, columns=run.columns | {change: 1.01 * run.columns[change]})
    after = torques(measured(run, f=size), effects)
    monkeypatch.setattr(base_torque, "_PLAIN_LOADS", Recent(1))
    np.testing.assert_allclose(after, torques(measured(run, f=size), effects), rtol=1e-9)


# ---------------------------------------------------------------- order in which lanes are solved
def test_every_lane_follows_one_that_has_been_solved():
    values = np.random.default_rng(0).normal(size=(20, 3))
    solved = {0, 1}
    for lanes, starts in waves(values, 2):
        assert set(starts) <= solved
        solved |= set(lanes.tolist())
    assert solved == set(range(20))


def test_lanes_of_a_jacobian_begin_at_their_centre_and_a_grid_goes_step_by_step():
    centres = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    shifted = centres + [[0.0, 1e-4]]
    begun = {
        int(lane): int(start)
        for lanes, starts in waves(np.concatenate([centres, shifted]), 1)
        for lane, start in zip(lanes, starts, strict=True)
    }
    assert [begun[lane] for lane in (1, 2)] == [0, 1]
    assert all(begun[4 + lane] == lane for lane in range(4))


def test_the_scale_of_a_parameter_does_not_matter():
    values = np.random.default_rng(1).normal(size=(9, 2))
    for plain, scaled in zip(waves(values, 1), waves(values * [1e9, 1e-9], 1), strict=True):
        assert np.array_equal(plain, scaled)


def test_values_and_what_does_nothing_stand_side_by_side():
    effects = [
        EFFECTS["passive_layer_slack"].in_lanes({"ratio": [0.4, 0.7]}),
        EFFECTS["gent_stiffening"].in_lanes({"jm": [3.0, 9.0]}),
    ]
    values = lane_values({"modulus_scale[A]": np.array([0.9])}, effects)
    assert values == pytest.approx(np.array([[0.9, 0.4, 3.0], [0.9, 0.7, 9.0]]))
    plain = neutral_lane(values, {"modulus_scale[A]": np.array([0.9])}, effects, {})
    assert plain == pytest.approx(np.array([[1.0, 1.0, 3.0]]))
    given = neutral_lane(values, {"modulus_scale[A]": 0.9}, effects, {"ratio": 0.5})
    assert given == pytest.approx(np.array([[1.0, 0.5, 3.0]]))


def test_stated_noise_of_the_pose_is_an_error_of_the_predictions():
    """Its size is that by which predictions scatter where poses scatter by that noise."""
    data, sigma = measured(straight(np.full(60, 5e3))), 2e-5
    assert torque_errors(data, load_model("base")) == 0.0
    rows = torque_errors(replace(data, noise={"tip_x": sigma}), load_model("base")).rows
    random, stated = np.random.default_rng(1), torques(data)
    scatter = []
    for _ in range(6):
        place = np.array([0.0, 0.0, 0.09]) + sigma * random.normal(size=(60, 1)) * [1.0, 0.0, 0.0]
        run = run_of(np.full(60, 5e3), place, Rotation.identity())
        scatter.append(torques(measured(run)) - stated)
    expected = np.sqrt(np.mean(np.square(scatter)))
    assert np.sqrt(np.mean(np.sum(rows**2, axis=0))) == pytest.approx(expected, rel=0.2)
    assert expected > 1e-5  # [N m]
