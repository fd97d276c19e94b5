import pytest

from grasp_strategies.strategy.variants import varied


def test_phases_are_left_out_by_name(make_strategy):
    strategy = varied(make_strategy(), without=("close",))
    assert [phase.name for phase in strategy.phases][:3] == ["approach", "lift", "hold"]


def test_air_is_scaled_in_every_phase(make_strategy):
    strategy = varied(make_strategy(), air_scale=0.5)
    assert strategy.phases[1].air_mass == {"a": 2e-5, "b": 1e-5, "c": 1e-5, "d": 1e-5}
    empty = varied(make_strategy(), air_scale=0.0)
    assert not any(mass for phase in empty.phases for mass in phase.air_mass.values())


def test_goals_that_stand_in_the_world_are_displaced_and_no_others(make_strategy):
    usual, moved = make_strategy(), varied(make_strategy(), displacement=(0.01, 0.0, 0.02))
    assert moved.phases[0].wrist.position == pytest.approx((0.01, 0.0, 0.12))
    assert moved.phases[2] == usual.phases[2]


def test_a_strategy_without_changes_is_itself(make_strategy):
    assert varied(make_strategy()) == make_strategy()


@pytest.mark.parametrize("name", ["roll", "hold"])
def test_a_phase_that_is_not_there_or_is_judged_cannot_be_left_out(make_strategy, name):
    with pytest.raises(ValueError, match="without: expected some of approach, close, lift, lower"):
        varied(make_strategy(), without=(name,))


def test_air_is_not_scaled_below_zero(make_strategy):
    with pytest.raises(ValueError, match="air_scale: expected 0 or more, got -1"):
        varied(make_strategy(), air_scale=-1)
