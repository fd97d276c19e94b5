"""Live prediction against closed forms, and against the finger of the simulator."""

import numpy as np
import pytest

from model_lab.live.prediction import LivePrediction, Settling, angles_of, pressures_of
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

FINGER = load_actuator("P10.finger")
HAND = load_hand("single_finger")
MS = 10**6  # [ns]


def predict(prediction, pressure, stop, angle_period=20 * MS, start=0):
    """Comparisons of a finger under pressure(t [s]) [Pa] sampled at 2 ms, angles measured as 0."""
    found = []
    for stamp in range(start, stop + 1, 2 * MS):
        found += prediction.add_pressures(stamp, np.array([pressure(stamp * 1e-9)]))
        if stamp % angle_period == 0:
            found += prediction.add_angles(stamp, {"finger": 0.0})
    return found


def with_effect(name, **values):
    return LivePrediction(HAND, Model(effects=(effect_classes()[name](**values),)))


def test_the_base_model_predicts_the_free_tip_angle_at_the_pressure_of_the_stamp():
    prediction = LivePrediction(HAND, Model())
    assert prediction.add_pressures(0, np.array([10e3])) == []
    assert prediction.add_angles(3 * MS, {"finger": 1.0}) == []
    (found,) = prediction.add_pressures(12 * MS, np.array([30e3]))
    expected = float(FINGER.tip_angle(15e3))  # a quarter of the way
    assert found.stamp == 3 * MS
    assert found.names == ("finger",)
    assert found.predicted == pytest.approx([expected], rel=1e-7)
    assert found.residual == pytest.approx([1.0 - expected], rel=1e-6)


def test_a_measured_modulus_softens_the_prediction():
    prediction = LivePrediction(HAND, Model(calibration={"modulus_scale": {"A": 0.8}}))
    (found,) = predict(prediction, lambda t: 8e3, 0)
    expected = float(FINGER.tip_angle(8e3 / 0.8))
    assert found.predicted == pytest.approx([expected], rel=1e-7)


def test_viscoelastic_creep_after_a_step_follows_its_closed_form():
    """A standard linear solid is linear between load and Q, so it acts as a pressure that creeps:
    p/(1 + g) at once, then to p with the time (1 + g)*tau.
    """
    g, tau, p = 0.4, 0.7, 20e3
    found = predict(
        with_effect("viscoelasticity", relative_modulus=g, relaxation_time=tau),
        lambda t: p,
        2000 * MS,
    )
    time = np.array([one.stamp for one in found]) * 1e-9
    creeping = p + (p / (1 + g) - p) * np.exp(-time / ((1 + g) * tau))
    predicted = np.array([one.predicted[0] for one in found])
    assert len(found) == 101
    assert predicted == pytest.approx(FINGER.tip_angle(creeping), rel=2e-4)


def test_memory_is_stepped_with_the_time_between_the_stamps():
    """Samples left out make larger steps, not slower rubber."""
    often, seldom = (
        predict(with_effect("tube_lag", time_constant=0.3), lambda t: 20e3 * t, 1000 * MS, period)
        for period in (20 * MS, 200 * MS)
    )
    lagging = 20e3 * (1.0 - 0.3 * (1.0 - np.exp(-1.0 / 0.3)))  # of a ramp from rest
    for found in (often, seldom):
        assert found[-1].stamp == 1000 * MS
        assert found[-1].predicted == pytest.approx(FINGER.tip_angle(lagging), rel=1e-5)


def test_what_the_angle_sensor_does_is_predicted_too():
    (found,) = predict(with_effect("angle_offset", offset=0.1), lambda t: 8e3, 0)
    assert found.predicted == pytest.approx([float(FINGER.tip_angle(8e3)) + 0.1], rel=1e-7)


@pytest.mark.parametrize("first", ["pressures", "angles"])
def test_a_clock_that_is_set_back_resets_the_memory(first):
    prediction = with_effect("viscoelasticity", relative_modulus=0.5, relaxation_time=1.0)
    fresh = predict(prediction, lambda t: 20e3, 400 * MS)
    if first == "angles":
        prediction.add_angles(0, {"finger": 0.0})
        assert prediction.set_back == 1
        prediction.reset()
    again = predict(prediction, lambda t: 20e3, 400 * MS)
    assert prediction.set_back == 1
    assert [one.stamp for one in again] == [one.stamp for one in fresh]
    for one, other in zip(again, fresh, strict=True):
        assert one.predicted == pytest.approx(other.predicted, abs=1e-12)


def test_a_sample_that_comes_twice_counts_once():
    prediction = with_effect("viscoelasticity", relative_modulus=0.5, relaxation_time=1.0)
    prediction.add_pressures(0, np.array([1e3]))
    assert len(prediction.add_angles(0, {"finger": 0.0})) == 1
    assert prediction.add_angles(0, {"finger": 0.0}) == []
    assert prediction.set_back == 0


def test_angles_from_before_the_first_pressure_are_left_out():
    prediction = LivePrediction(HAND, Model())
    prediction.add_angles(0, {"finger": 0.0})
    prediction.add_angles(20 * MS, {"finger": 0.0})
    found = prediction.add_pressures(10 * MS, np.array([1e3]))
    found += prediction.add_pressures(30 * MS, np.array([1e3]))
    assert [one.stamp for one in found] == [20 * MS]


@pytest.mark.parametrize(("gap", "compared"), [(200 * MS, True), (300 * MS, False)])
def test_angles_in_a_long_gap_of_the_pressures_are_left_out(gap, compared):
    """Messages were lost: what the pressure did between them is not known."""
    prediction = LivePrediction(HAND, Model())
    prediction.add_pressures(0, np.array([0.0]))
    prediction.add_angles(gap // 2, {"finger": 0.1})
    assert bool(prediction.add_pressures(gap, np.array([20e3]))) is compared
    prediction.add_angles(gap + MS, {"finger": 0.1})
    assert prediction.add_pressures(gap + 5 * MS, np.array([20e3]))


def test_a_finger_is_settled_when_its_pressure_has_stood_for_the_time():
    prediction = LivePrediction(HAND, Model(), Settling(0.1, 1000.0))
    found = predict(prediction, lambda t: 10e3 if t < 0.3 else 12e3, 600 * MS)
    settled = {one.stamp // MS: bool(one.settled[0]) for one in found}
    standing = [*range(100, 300, 20), *range(400, 601, 20)]
    assert [stamp for stamp, yes in settled.items() if yes] == standing


def test_without_a_settling_time_every_sample_counts():
    prediction = LivePrediction(HAND, Model(), Settling(0.0, 1000.0))
    found = predict(prediction, lambda t: 100e3 * t, 200 * MS)
    assert len(found) == 11
    assert all(one.settled.all() for one in found)


def test_pressures_are_kept_for_seconds_only():
    prediction = LivePrediction(HAND, Model())
    for stamp in range(0, 60_000 * MS, 10 * MS):
        prediction.add_pressures(stamp, np.array([0.0]))
    assert not prediction._pressures.covers(49_000 * MS)
    assert prediction._pressures.covers(59_000 * MS)


def test_every_actuator_of_a_hand_follows_its_own_channels():
    """Fingers by their channel alone; the two arcs of the palm bend as one by both of theirs."""
    hand = load_hand("rbo_hand_2")
    prediction = LivePrediction(hand, Model())

    def at(*pressures):
        prediction.reset()
        prediction.add_pressures(0, np.array(pressures))
        (found,) = prediction.add_angles(0, dict.fromkeys(hand.actuator_names, 0.0))
        return dict(zip(found.names, found.predicted, strict=True))

    base = at(10e3, 20e3, 30e3, 40e3)
    for name, pressure in (("little", 10e3), ("ring", 10e3), ("middle", 10e3), ("index", 20e3)):
        assert base[name] == pytest.approx(float(FINGER.tip_angle(pressure)), rel=1e-7)
    thumb = load_actuator("P10.thumb")
    assert base["thumb"] == pytest.approx(float(thumb.tip_angle(30e3)), rel=1e-7)
    assert base["palm_inner"] == base["palm_outer"]
    for more in (at(10e3, 20e3, 33e3, 40e3), at(10e3, 20e3, 30e3, 44e3)):
        assert more["palm_inner"] > base["palm_inner"] + 0.01
        assert more["index"] == pytest.approx(base["index"])


@pytest.mark.parametrize(
    ("read", "names", "values", "words"),
    [
        (pressures_of, ["a", "b"], [1.0, 2.0], ["name", "a, b, c", "got a, b"]),
        (pressures_of, ["a", "b", "c"], [1.0], ["effort", "3 values", "got 1"]),
        (pressures_of, ["a", "b", "c"], [1.0, np.nan, 0.0], ["effort", "finite", "nan"]),
        (angles_of, ["finger"], [1.0], ["name", "a, b, c", "got finger"]),
        (angles_of, [], [], ["name", "got none"]),
        (angles_of, ["a"], [], ["position", "1 values", "got 0"]),
        (angles_of, ["a"], [np.inf], ["position", "finite", "inf"]),
    ],
)
def test_a_message_that_cannot_be_used_is_refused_by_field(read, names, values, words):
    with pytest.raises(ValueError) as error:
        read(names, values, ["a", "b", "c"])
    for word in words:
        assert word in str(error.value)


def test_a_sensor_for_some_of_the_actuators_is_enough():
    hand = load_hand("rbo_hand_2")
    angles = angles_of(["index"], [0.5], hand.actuator_names)
    prediction = LivePrediction(hand, Model())
    prediction.add_pressures(0, np.full(4, 10e3))
    (found,) = prediction.add_angles(0, angles)
    assert found.names == ("index",)
    assert found.measured.tolist() == [0.5]


def test_a_base_that_has_no_chains_is_refused():
    with pytest.raises(ValueError, match="pneuflex"):
        LivePrediction(HAND, Model(base="linear"))


@pytest.mark.parametrize("offset", [0.1, -0.06])
def test_angles_of_another_clock_are_compared_with_the_pressures_of_their_time(offset):
    late = with_effect("clock_offset", offset=offset, drift=0.01)
    found = predict(late, lambda t: 20e3 * t, 1000 * MS)
    assert len(found) == 1 + round((1.0 - abs(offset)) / 0.02)
    time = np.array([one.stamp for one in found]) * 1e-9
    predicted = [one.predicted[0] for one in found]
    assert predicted == pytest.approx(FINGER.tip_angle(20e3 * (time - offset)), rel=1e-6, abs=1e-9)


def test_a_delay_beyond_what_is_kept_of_the_pressures_is_refused():
    with pytest.raises(ValueError, match="expected a delay .* of 5 s at most, got 7 s"):
        with_effect("clock_offset", offset=7.0, drift=0.0)


def test_a_sensor_that_drifts_does_so_from_the_reset_on():
    drifting = with_effect("sensor_drift", rate=0.05, settling_time=1e6, per_run=0.3)
    for _ in range(2):
        found = predict(drifting, lambda t: 0.0, 400 * MS)
        assert found[-1].predicted == pytest.approx([0.05 * 0.4], abs=1e-6)
        drifting.reset()
