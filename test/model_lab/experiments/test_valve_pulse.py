"""Predicted pulse masses against equation 4.1 written out pulse by pulse in plain numbers."""

import itertools
import time

import numpy as np
import pytest
from scipy.optimize import brentq

from model_lab.experiments.valve_pulse import ValvePulse
from model_lab.measurements.measurement_set import MeasurementSet, Run
from softhand_model.effects import Effect, effect_classes

EFFECTS = effect_classes()
FLOW = [name for name, effect in EFFECTS.items() if effect.stage == "flow"]
NAIVE = {"inflate": 7e-11, "deflate": 5e-10}
VALUES = {
    "injector_flow": {"c2_inflate": 1.2e-10, "c2_deflate": 9e-10},
    "line_friction": {"c1_inflate": 8e-12, "c1_deflate": -5e-11},
    "switching_volume": {"c3_inflate": 3e-12, "c3_deflate": -6e-12, "c4_inflate": -2e-12},
    "pulse_bias": {"c0_inflate": 4e-7, "c0_deflate": -7e-7},
    "valve_delay": {"delay": 0.06},
    "leakage": {"conductance": 2e-11},
    "supply_droop": {"resistance": 4e9},
    "polytropic_gas": {"exponent": 1.1},
}


def pulses(count=60, seed=3):
    random = np.random.default_rng(seed)
    inflating = random.random(count) < 0.5
    inflating[:2] = True, False
    channel = random.uniform(1.05e5, 2.2e5, count)
    p_in = np.where(inflating, random.uniform(2.5e5, 4.2e5, count), channel)
    p_out = np.where(inflating, channel, 101300.0)
    duration = random.uniform(0.04, 1.0, count)
    return {
        "direction": np.where(inflating, 1.0, -1.0),
        "duration": duration,
        "p_in": p_in,
        "p_out": p_out,
        "friction_integral": 0.9 * (p_in - p_out) * duration,
        "injector_integral": 0.45 * p_in * duration * random.uniform(0.8, 1.0, count),
        "mass": random.uniform(1e-6, 3e-5, count),
    }


def measured(*runs):
    listed = tuple(
        Run(f"r{index}", "box", f"p{index}", 293.15, columns) for index, columns in enumerate(runs)
    )
    return MeasurementSet("valve_pulse", "pulses", {}, listed)


def by_hand(columns, row, names, values=VALUES, naive=NAIVE):
    """One pulse's mass, the equations of the contract in plain numbers."""
    inflating = columns["direction"][row] > 0
    end = "inflate" if inflating else "deflate"
    nominal, p_in, p_out, friction, injector = (
        float(columns[name][row])
        for name in ("duration", "p_in", "p_out", "friction_integral", "injector_integral")
    )
    get = lambda name, key: values[name][key] if name in names else 0.0  # noqa: E731
    duration = max(0.0, nominal - get("valve_delay", "delay"))
    share = duration / nominal

    def total(inlet):
        if "injector_flow" in names:
            mass = values["injector_flow"][f"c2_{end}"] * injector * share
        else:
            mass = naive[end] * inlet * duration
        mass += get("line_friction", f"c1_{end}") * friction * share
        mass += get("switching_volume", f"c3_{end}") * inlet
        mass += get("switching_volume", "c4_inflate") * p_out if inflating else 0.0
        mass += get("pulse_bias", f"c0_{end}")
        channel = p_out if inflating else p_in
        mass -= get("leakage", "conductance") * (channel - 101300.0) * duration
        return mass * (get("polytropic_gas", "exponent") or 1.0)

    resistance = get("supply_droop", "resistance")
    if not (inflating and resistance and duration):
        return total(p_in)
    return total(
        brentq(lambda p: p - p_in + resistance * total(p) / duration, -1e7, 1e7, xtol=1e-9)
    )


def instance(name, **values):
    return EFFECTS[name](**(values or VALUES[name]))


@pytest.mark.parametrize(
    "names",
    [(), *((name,) for name in FLOW), *itertools.combinations(FLOW, 2), tuple(FLOW)],
    ids=lambda names: "+".join(names) or "naive",
)
def test_masses_are_those_of_the_equations(names):
    columns = pulses()
    found = ValvePulse(measured(columns)).predict(NAIVE, [instance(name) for name in names])
    expected = [by_hand(columns, row, names) for row in range(60)]
    assert found.shape == (1, 60)
    assert found[0] == pytest.approx(expected, rel=1e-9, abs=1e-16)


def test_every_flow_effect_of_the_contract_is_there():
    assert set(FLOW) == set(VALUES)
    for name in FLOW:
        assert EFFECTS[name].experiments == {"valve_pulse"}
        assert {parameter.name for parameter in EFFECTS[name].parameters} == set(VALUES[name])


@pytest.mark.parametrize("name", FLOW)
def test_every_effect_moves_the_prediction_and_is_neutral_where_it_says_so(name):
    data = ValvePulse(measured(pulses()))
    base = data.predict(NAIVE, [])
    changed = data.predict(NAIVE, [instance(name)])
    assert np.abs(changed - base).max() > 1e-3 * base.max()
    neutral = {parameter.name: parameter.neutral for parameter in EFFECTS[name].parameters}
    if None not in neutral.values():
        assert data.predict(NAIVE, [instance(name, **neutral)]) == pytest.approx(base, rel=1e-14)


def test_the_order_of_the_file_does_not_matter():
    data = ValvePulse(measured(pulses()))
    effects = [instance(name) for name in FLOW]
    forward, backward = data.predict(NAIVE, effects), data.predict(NAIVE, effects[::-1])
    assert forward == pytest.approx(backward, rel=1e-12)


def test_lanes_are_independent_models():
    data, random = ValvePulse(measured(pulses(40), pulses(20, seed=5))), np.random.default_rng(1)
    factor = {
        name: {key: value * random.uniform(0.5, 1.5, 4) for key, value in values.items()}
        for name, values in VALUES.items()
    }
    naive = {name: value * random.uniform(0.5, 1.5, 4) for name, value in NAIVE.items()}
    together = data.predict(naive, [EFFECTS[name].in_lanes(factor[name]) for name in FLOW])
    assert together.shape == (4, 60)
    for lane in range(4):
        effects = [
            EFFECTS[name].in_lanes({key: [value[lane]] for key, value in factor[name].items()})
            for name in FLOW
        ]
        alone = data.predict(
            {name: value[lane : lane + 1] for name, value in naive.items()}, effects
        )
        assert together[lane] == pytest.approx(alone[0], rel=1e-10)


def test_calibration_is_the_least_squares_factor_of_each_direction():
    columns = pulses()
    found = ValvePulse(measured(columns)).calibration()
    for name, sign in (("inflate", 1.0), ("deflate", -1.0)):
        rows = columns["direction"] == sign
        product = (columns["p_in"] * columns["duration"])[rows]
        expected = np.linalg.lstsq(product[:, None], columns["mass"][rows], rcond=None)[0][0]
        assert found[name] == pytest.approx(expected, rel=1e-12)


def test_pulses_without_masses_can_be_predicted():
    columns = pulses()
    del columns["mass"]
    found = ValvePulse(measured(columns)).calibration()
    assert 1e-11 < found["inflate"] < found["deflate"] < 1e-9


def test_calibration_follows_the_directions_and_effects_at_hand():
    columns = pulses()
    inflating = {name: column[columns["direction"] > 0] for name, column in columns.items()}
    assert list(ValvePulse(measured(inflating)).calibration()) == ["inflate"]
    data = ValvePulse(measured(columns))
    assert list(data.calibration([EFFECTS["pulse_bias"]])) == ["inflate", "deflate"]
    assert data.calibration([EFFECTS["injector_flow"]]) == {}


def test_integrals_that_were_not_recorded_take_constant_pressures():
    columns = pulses()
    short = {name: column for name, column in columns.items() if "integral" not in name}
    drop = columns["p_in"] - columns["p_out"]
    friction = instance("line_friction", c1_inflate=1e-11, c1_deflate=1e-11)
    found = ValvePulse(measured(short)).predict(NAIVE, [friction])
    base = ValvePulse(measured(short)).predict(NAIVE, [])
    assert found - base == pytest.approx(1e-11 * (drop * columns["duration"])[None])
    choked = short["p_out"] / short["p_in"] < 0.5
    injector = instance("injector_flow", c2_inflate=1e-10, c2_deflate=1e-10)
    mass = ValvePulse(measured(short)).predict(NAIVE, [injector])[0]
    expected = 1e-10 * 0.4842 * short["p_in"] * short["duration"]
    assert choked.sum() > 5
    assert mass[choked] == pytest.approx(expected[choked], rel=1e-4)


def test_naive_model_takes_up_droop_and_polytropic_change_as_a_factor():
    """So neither can be seen beside it: the columns are collinear."""
    data = ValvePulse(measured(pulses()))
    base = data.predict(NAIVE, [])
    ratio = data.predict(NAIVE, [instance("supply_droop")])[0] / base[0]
    inflating = pulses()["direction"] > 0
    assert ratio[inflating] == pytest.approx(1 / (1 + 4e9 * 7e-11), rel=1e-12)
    assert ratio[~inflating] == pytest.approx(1.0, rel=1e-14)
    assert data.predict(NAIVE, [instance("polytropic_gas")]) == pytest.approx(1.1 * base)


def test_pulse_shorter_than_the_delay_moves_nothing():
    columns = {name: column[:1] for name, column in pulses().items()}
    data = ValvePulse(measured({**columns, "duration": np.array([0.03])}))
    effects = [instance("valve_delay"), instance("supply_droop"), instance("line_friction")]
    assert data.predict(NAIVE, effects) == pytest.approx(0.0, abs=0)


def test_own_effect_that_acts_on_itself_is_solved():
    class Choke(EFFECTS["supply_droop"]):
        """The inlet falls with the root of the flow: nonlinear in the mass."""

        def act_on_pulse(self, pulse, mass):
            loss = 3e6 * np.sqrt(np.abs(mass) / pulse.duration)
            return pulse.fed_at(pulse.p_in - loss)

    columns = pulses()
    found = ValvePulse(measured(columns)).predict(NAIVE, [Choke(resistance=0.0)])[0]
    for row in range(10):
        c = NAIVE["inflate" if columns["direction"][row] > 0 else "deflate"]
        p_in, duration = columns["p_in"][row], columns["duration"][row]

        def excess(mass, p_in=p_in, duration=duration, c=c):
            return mass - c * duration * (p_in - 3e6 * np.sqrt(mass / duration))

        assert found[row] == pytest.approx(brentq(excess, 0.0, 1e-3, xtol=1e-18), rel=1e-7)


def test_effects_of_other_stages_change_nothing():
    other = type("Odd", (Effect,), {"name": "odd", "stage": "input"})()
    data = ValvePulse(measured(pulses()))
    assert data.predict(NAIVE, [other]) == pytest.approx(data.predict(NAIVE, []), rel=0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"direction": np.zeros(60)}, "run r0: direction: expected inflate or deflate, got 0"),
        ({"duration": np.full(60, -1.0)}, "run r0: duration: expected numbers above 0, got -1"),
        ({"p_in": np.full(60, np.nan)}, "run r0: p_in: expected numbers above 0, got nan"),
    ],
)
def test_unusable_columns_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        ValvePulse(measured({**pulses(), **change}))


def test_missing_column_is_named():
    columns = pulses()
    del columns["p_out"]
    with pytest.raises(ValueError, match="runs.r0: expected the column p_out"):
        ValvePulse(measured(columns))


def least_processor_time(work):
    durations = []
    for _ in range(3):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return min(durations)


def test_pulses_in_lanes_are_predicted_by_arrays_not_one_by_one():
    data = ValvePulse(measured(pulses(100_000)))
    lanes = np.linspace(0.9, 1.1, 10)
    naive = {name: value * lanes for name, value in NAIVE.items()}
    names = ("injector_flow", "line_friction", "switching_volume", "pulse_bias")
    effects = [
        EFFECTS[name].in_lanes({key: value * lanes for key, value in VALUES[name].items()})
        for name in names
    ]
    numbers = np.ones((10, 100_000))
    functions = least_processor_time(lambda: [np.exp(numbers) for _ in range(30)])
    assert least_processor_time(lambda: data.predict(naive, effects)) < functions
