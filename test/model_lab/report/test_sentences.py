from dataclasses import replace

import pytest

from model_lab.diagnosis.result import (
    Diagnosis,
    Estimate,
    GreaterPart,
    Help,
    NamedEffect,
    Step,
    Unexplained,
)
from model_lab.report.sentences import (
    notice_sentence,
    story_sentence,
    tie_sentences,
    verdict_sentence,
)
from model_lab.slips.slip import Slip

GENT = NamedEffect("gent_stiffening", {"jm": Estimate(8.104, 0.31, (7.5, 8.7), "")})
LAG = NamedEffect("tube_lag", {"time_constant": Estimate(0.25, 0.0123, (0.22, 0.28), "s")})


def diagnosis(verdict, effects=(), tied=(), unit="rad", against=(), after=0.0102):
    return Diagnosis(
        experiment="free_bending",
        verdict=verdict,
        holdout="protocols",
        effects=effects,
        tied=tied,
        ranking=(),
        not_visible=(),
        detectable=(),
        calibration={},
        noise_floor=0.01,
        noise_floor_parts={"within": 0.01, "between": 0.0},
        noise_floor_source="repeats",
        rmse_before=0.1,
        rmse_after=after,
        unit=unit,
        failures=(),
        unexplained=Unexplained(0.09, against),
    )


def test_missing_effects_are_named_with_their_parameters_and_what_they_bring():
    assert verdict_sentence(diagnosis("effects_missing", (GENT, LAG))) == (
        "The model lacks gent_stiffening (jm = 8.1 ± 0.31) and tube_lag (time_constant = 0.25 ± "
        "0.012 s): with them the held-out error falls from 5.73 deg to 0.584 deg, at a noise floor "
        "of 0.573 deg."
    )


@pytest.mark.parametrize(("mended", "fit"), [("adequate", "fit"), ("unexplained", "fit better")])
def test_data_fit_without_a_slip_only_where_the_rest_is_explained(mended, fit):
    slip = Slip("unit", "pressure", "kPa", "psi", 0.8, 0.1, "columns: {pressure: {unit: psi}}")
    told = replace(diagnosis("slip"), slips=(slip,), verdict_mended=mended)
    assert verdict_sentence(told).startswith(f"The data {fit} if pressure is psi")


def test_rubber_of_another_mix_stands_before_the_slip_that_fits_as_well():
    slip = Slip("wall_total", "wall", "one", "both", 0.8, 0.1, "wall: 0.001", modulus=0.7)
    told = replace(diagnosis("slip"), slips=(slip,), verdict_mended="adequate")
    assert verdict_sentence(told).startswith(
        "The data fit if the rubber is 0.7 times as stiff as stated (--free-modulus), or if wall is"
    )


def test_a_wrong_scale_of_the_angle_may_be_a_wrong_size():
    gain = NamedEffect("angle_gain", {"gain": Estimate(1.25, 0.003, (1.24, 1.26), "")})
    said = verdict_sentence(diagnosis("effects_missing", (gain,)))
    assert "A finger 1.25 times as long looks the same, and one 0.8 times as high nearly" in said


def test_what_named_effects_leave_is_said_where_it_is_more_than_noise():
    said = verdict_sentence(diagnosis("effects_missing", (GENT,), after=0.05))
    assert said.endswith(
        "at a noise floor of 0.573 deg; 5.16 deg remains: add what is named and diagnose again for "
        "the rest."
    )


def test_a_scale_of_the_pressure_of_a_blocked_tip_may_be_a_wrong_size():
    """F = 1.5*h**2*z*p/(2*L)."""
    gain = NamedEffect("pressure_gain", {"gain": Estimate(0.81, 0.003, (0.80, 0.82), "")})
    blocked = replace(diagnosis("effects_missing", (gain,)), experiment="blocked_tip")
    said = verdict_sentence(blocked)
    assert "A finger 1.23 times as long looks the same, and one 0.9 times as high nearly" in said
    assert "a force gauge that reads 0.81 times the force" in said


def test_a_dead_zone_may_be_a_threshold_of_the_force_gauge():
    zone = NamedEffect("dead_zone", {"threshold": Estimate(2260.0, 13.0, (2230.0, 2290.0), "Pa")})
    blocked = replace(diagnosis("effects_missing", (zone,)), experiment="blocked_tip")
    said = verdict_sentence(blocked)
    assert "A force gauge that shows nothing below the force at 2.26 kPa looks the same." in said


def test_an_effect_that_explains_most_is_told_where_nothing_explains_all():
    lags = {"tube_lag": "tube", "angle_sensor_lag": "sensor"}
    lag = replace(LAG, cause="lag", members=lags)
    part = GreaterPart(lag, ("hysteresis",), rmse_after=0.05, share=0.757)
    said = verdict_sentence(replace(diagnosis("unexplained"), greater_part=part))
    assert said.startswith("The model fails and no known effect explains all of it: its error is")
    assert (
        "Most of it (76 % of the mean square above the floor) may be a lag of 0.25 ± 0.012 s (tube "
        "or sensor) or hysteresis, which leaves 2.86 deg; the remaining"
    ) in said


def test_how_sure_a_verdict_is_stands_behind_it():
    sure = replace(diagnosis("effects_missing", (GENT,)), confidence=0.97)
    assert verdict_sentence(sure).startswith("The model lacks gent_stiffening")
    assert verdict_sentence(sure).endswith("0.573 deg. 97 of 100 such verdicts are right.")


def test_of_a_hand_it_is_said_that_no_confidence_is_known():
    of_hand = replace(diagnosis("adequate", unit="m"), experiment="hand_pose")
    assert verdict_sentence(of_hand).endswith(
        "is not known: too few hands with known causes were diagnosed."
    )
    assert "not known" not in verdict_sentence(replace(of_hand, guess=True))


def test_a_verdict_that_is_not_sure_enough_is_said_as_a_guess():
    guess = replace(diagnosis("effects_missing", (GENT,)), confidence=0.55, guess=True)
    assert verdict_sentence(guess).startswith("The model may lack gent_stiffening")
    assert verdict_sentence(guess).endswith("That is a guess: 55 of 100 such verdicts are right.")


def test_an_effect_without_parameters_is_named_alone():
    plain = NamedEffect("side_wall_integral", {})
    assert "lacks side_wall_integral: with it" in verdict_sentence(
        diagnosis("effects_missing", (plain,))
    )


@pytest.mark.parametrize(
    ("unit", "shown"), [("Pa", "0.0001 kPa"), ("kg", "100000 mg"), ("N m", "100 N mm")]
)
def test_errors_are_said_in_the_unit_that_people_read(unit, shown):
    assert f"its error is {shown} at" in verdict_sentence(diagnosis("unexplained", unit=unit))


def test_what_helps_is_said_though_it_is_not_the_whole():
    said = replace(
        diagnosis("unexplained", unit="Pa", against=("pressure",)),
        experiment="uniaxial",
        rmse_before=438e3,
        helps=(Help("yeoh_stiffening", 104e3), Help("hysteresis", 40e3)),
    )
    assert verdict_sentence(replace(said, helps=said.helps[:1])).endswith(
        ". yeoh_stiffening reduces the error from 438 to 104 kPa, but does not explain all of it; "
        "the remaining error varies with the stretch."
    )
    assert (
        "yeoh_stiffening reduces the error from 438 to 104 kPa and hysteresis reduces the rest "
        "from 104 to 40 kPa, but they do not explain all of it" in verdict_sentence(said)
    )
    floor = replace(said, noise_floor=41e3)
    assert "40 kPa, which explains the whole error, but they are not proven" in verdict_sentence(
        floor
    )


def test_the_story_of_several_effects_is_told_in_their_order():
    steps = (Step("tube_lag", 0.1, 0.05), Step("gent_stiffening", 0.05, 0.0102))
    said = replace(diagnosis("effects_missing", (LAG, GENT)), story=steps)
    assert story_sentence(said) == (
        "The error falls from 5.73 deg to 2.86 deg with tube_lag, to 0.584 deg with "
        "gent_stiffening too."
    )
    assert story_sentence(replace(said, story=steps[:1])) == ""


def test_what_is_odd_is_said_in_one_note():
    assert (
        notice_sentence(["repeats scatter", "a line runs"]) == "Note: repeats scatter; a line runs."
    )
    assert notice_sentence([]) == ""


def test_what_is_unexplained_says_what_it_varies_with():
    said = verdict_sentence(diagnosis("unexplained", against=("time_since_step", "pressure")))
    assert said.endswith(
        "the remaining error varies with the time since the last step and the pressure."
    )
    assert verdict_sentence(diagnosis("unexplained")).endswith(
        "the remaining error varies with no input."
    )


def test_ties_are_said_for_each_effect_that_has_one():
    tied = diagnosis("effects_missing", (GENT, LAG), ((), ("hysteresis", "viscoelasticity")))
    assert tie_sentences(tied) == [
        "These data cannot tell tube_lag from hysteresis or viscoelasticity."
    ]


def tied_lags(**changed):
    members = {"tube_lag": "tube", "clock_offset": "clock"}
    lag = replace(LAG, cause="lag", members=members)
    tied = (("clock_offset", "hysteresis"),)
    return replace(diagnosis("effects_missing", (lag,), tied), confidence=0.9, **changed)


def test_causes_of_one_class_that_are_tied_are_said_as_the_class_with_what_tells_them_apart():
    said = tied_lags(next_experiment={"breaks": True})
    assert verdict_sentence(said).startswith(
        "The model lacks a lag of 0.25 ± 0.012 s (tube or clock: these data cannot tell; "
        "`model-lab plan` can): with it"
    )
    assert "90 of 100 such verdicts name the cause among what is tied." in verdict_sentence(said)
    assert tie_sentences(said) == ["These data cannot tell the lag from hysteresis."]


def test_no_plan_is_promised_where_none_parts_the_members_of_a_class():
    for planned in (None, {"breaks": False}):
        assert "`model-lab plan` can" not in verdict_sentence(tied_lags(next_experiment=planned))


def test_a_verdict_is_never_said_to_be_right_in_a_hundred_of_a_hundred():
    sure = replace(diagnosis("effects_missing", (GENT,)), confidence=0.9999)
    assert verdict_sentence(sure).endswith("99 of 100 such verdicts are right.")


def test_an_effect_whose_parameter_the_data_do_not_determine_is_said_as_a_guess():
    loose = replace(GENT.parameters["jm"], undetermined=True)
    gent = replace(GENT, parameters={"jm": loose})
    said = verdict_sentence(replace(diagnosis("effects_missing", (gent,)), guess=True))
    assert said.startswith("The model may lack gent_stiffening")
    assert said.endswith("That is a guess: these data do not determine jm of gent_stiffening.")


def test_a_set_unlike_those_that_were_counted_gets_a_sentence_in_place_of_a_number():
    said = verdict_sentence(replace(diagnosis("effects_missing", (GENT,)), beyond=("left",)))
    assert "of 100" not in said and "for which they were counted (left in" in said


def test_a_sentence_is_in_the_units_that_the_user_stated():
    stated = replace(diagnosis("adequate"), units={"pressure": "psi", "tip_angle": "rad"})
    assert "its error of 0.1 rad can be noise alone (noise floor 0.01 rad)" in verdict_sentence(
        stated
    )


def test_after_one_relaxation_time_a_second_one_is_searched():
    said = replace(diagnosis("unexplained"), helps=(Help("viscoelasticity", 0.03),))
    assert verdict_sentence(said).endswith(
        "(`model-lab add`), a second relaxation time is searched, too."
    )
