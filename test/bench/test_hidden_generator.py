"""The generator of hidden effects against closed forms and independent integrators."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_bvp, solve_ivp, trapezoid
from scipy.optimize import brentq

from bench.hidden import balance, flow, rubber, sensing
from bench.hidden.case import visible
from bench.hidden.cases import all_cases
from bench.hidden.design import PlannedRun, Scene, specimen
from bench.hidden.flow import Valve, drive, joined, planned
from bench.hidden.laws.registry import LAWS, build
from bench.hidden.measure import measure
from bench.hidden.plant import Plant
from bench.hidden.protocols import Protocol, standard, through, triangles
from bench.hidden.rubber import BoucWen, Loop, Modes, Plays
from bench.hidden.sets.driven import Options, make_set, plan

STEADY = Protocol("steady", 1.0, through([0.0, 1.0], [0.0, 1.0]))


def scene_of(*protocols: Protocol, wall=0.002, modulus=73.7e3, peak=31e3, samples=41, **more):
    runs = tuple(PlannedRun("finger", protocol) for protocol in protocols)
    entry = specimen(wall, shear_modulus=modulus, **more)
    return Scene({"finger": entry}, runs, samples, peak, gains=np.ones(len(runs)))


def final_angle(plant, **more):
    return np.degrees(measure("free_bending", scene_of(STEADY, **more), plant).output[0, -1])


def test_the_base_bends_as_the_checked_values_say():
    assert final_angle(Plant()) == pytest.approx(122.2, abs=0.06)
    assert final_angle(Plant(), modulus=67e3) == pytest.approx(141.2, abs=0.06)


def test_the_printed_approximation_bends_as_the_checked_value_says():
    plant = build(
        [("actuation_nonlinearity", {"a": 4.0, "p0": 0.9 * 8 * 73.7e3 * 0.002 / 0.02})], 1.0
    )
    assert final_angle(plant) == pytest.approx(124.45, abs=0.1)


def test_a_gent_wall_satisfies_its_balance():
    entry = ("gent_stiffening", {"jm": 5.0})
    angle = np.radians(final_angle(build([entry], 1.0)))
    stretch = 1 + angle / 0.09 * 0.02
    ratio = 2 / (1 + 0.018**2 / 0.02**2)
    load = 31e3 * ratio * 0.02 / (4 * 73.7e3 * 0.002)
    invariant = stretch**2 + stretch**-2 - 2
    assert (stretch - stretch**-3) / (1 - invariant / 5.0) == pytest.approx(load, rel=1e-7)


def test_exact_side_walls_give_the_small_load_ratio():
    wall, height = 0.002, 0.02
    scene = scene_of(STEADY, peak=100.0)
    angle = measure("free_bending", scene, build([("side_wall_integral", {})], 1.0)).output[0, -1]
    ratio = 2 / (1 + (1 / 3) * 0.9**3 * 2 * wall / wall)
    slope = ratio * height / (4 * 73.7e3 * wall) / 4 / height * 0.09
    assert angle == pytest.approx(100.0 * slope, rel=2e-3)


def test_stretch_relaxes_with_the_time_constant_of_a_standard_linear_solid():
    """At small load q = 4*(lam-1): s = q + nu jumps by 1/(1+g), then relaxes with tau*(1+g)."""
    step = Protocol("step", 20.0, through([0.0, 1e-3, 20.0], [0.0, 1.0, 1.0]))
    entry = ("viscoelasticity", {"relative_modulus": 0.5, "relaxation_time": 2.0})
    shown = measure("free_bending", scene_of(step, peak=50.0, samples=201), build([entry], 1.0))
    relative = shown.output[0] / shown.output[0, -1]
    expected = 1 - 0.5 / 1.5 * np.exp(-shown.time[0] / 3.0)
    assert relative[5:] == pytest.approx(expected[5:] / expected[-1], abs=2e-3)


def test_modes_agree_with_an_ode_solver():
    time = np.linspace(0, 10, 2001)
    stress = np.sin(time)
    modes = Modes(np.array([0.3, 0.2]), np.array([0.5, 4.0]))
    modes.reset((1,))
    got = []
    for k, dt in enumerate(np.diff(time, prepend=0.0)):
        got.append(modes.trial(stress[k : k + 1], np.array([dt]))[0])
        modes.commit(stress[k : k + 1], np.array([dt]))
    solution = solve_ivp(
        lambda t, nu: [-nu[0] / 0.5 + 0.3 * np.cos(t), -nu[1] / 4 + 0.2 * np.cos(t)],
        (0, 10),
        [0, 0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-11,
    )
    assert np.array(got) == pytest.approx(solution.y.sum(axis=0), abs=2e-5)


def test_a_loop_approaches_its_bound_exponentially_and_does_not_see_the_rate():
    for steps in (400, 1200):
        loop = Loop(1.0, 0.05)
        loop.reset((1,))
        for stretch in np.linspace(1.0, 1.1, steps):
            value = loop.trial(np.array([stretch]))
            loop.commit(np.array([stretch]))
        assert value[0] == pytest.approx(1 - np.exp(-2), abs=1e-4)


@pytest.mark.parametrize("kind", [BoucWen, Plays])
def test_other_loops_are_bounded_and_closed(kind):
    loop = kind(1.0, 0.02)
    loop.reset((1,))
    path = np.concatenate([np.linspace(1, 1.4, 300), np.linspace(1.4, 1, 300)] * 3)
    values = []
    for stretch in path:
        values.append(loop.trial(np.array([stretch]))[0])
        loop.commit(np.array([stretch]))
    assert max(np.abs(values)) <= 1.01
    assert values[-600:] == pytest.approx(values[-1200:-600], abs=1e-3)
    assert trapezoid(values[-600:], path[-600:]) > 0.1


def test_softening_acts_below_the_largest_stretch_only_and_carries_over():
    ramp = Protocol("ramp", 10.0, through([0, 5, 10], [0, 1, 0]))
    entry = ("mullins_softening", {"softening": 0.3, "stretch_scale": 0.1})
    shown = measure("free_bending", scene_of(ramp, ramp), build([entry], 1.0)).output
    base = measure("free_bending", scene_of(ramp, ramp), Plant()).output
    up = slice(0, 21)
    assert shown[0, up] == pytest.approx(base[0, up], abs=1e-7)
    assert np.all(shown[1, 3:18] > base[1, 3:18] + 0.01)
    assert shown[1, up] == pytest.approx(shown[0, ::-1][up], abs=1e-6)


def test_a_lag_follows_a_ramp_late_by_its_time_constant():
    time = np.linspace(0, 10, 101)[None]
    for shown in (
        sensing.first_order(time, time, 0.4),
        sensing.second_order(time, time, 0.4),
    ):
        assert shown[0, -1] == pytest.approx(9.6, abs=1e-4)


def test_a_reading_creeps_until_the_drive_moves_and_not_before():
    time = np.linspace(0.0, 4.0, 41)[None]
    drive = np.interp(time, [0.0, 1.0, 3.0, 4.0], [0.0, 1.0, 1.0, 2.0])
    plant = build([("creeping_reading", {"share": 0.1, "time": 0.5})], 1.0)
    shown = plant.sensors[0](time, np.ones_like(time), drive)[0]
    rests = (time[0] > 1.05) & (time[0] < 3.05)
    assert shown[rests] == pytest.approx(1 + 0.1 * np.log1p((time[0][rests] - 1.0) / 0.5))
    assert shown[time[0] > 3.05] == pytest.approx(1.0)


def test_a_hanging_finger_is_straightened_by_the_moment_of_its_weight():
    """At small bend: fixed point of curvature and weight moment on a fine grid."""
    scene = Scene(
        {"finger": specimen(0.0025, "base_up")},
        scene_of(STEADY).runs,
        5,
        2e3,
        200,
        gains=np.ones(1),
    )
    hanging = measure("free_bending", scene, build([("gravity", {"mass_scale": 3.0})], 1.0))
    level = measure("free_bending", scene, Plant())
    stiffness = 4 * 0.02**2 * 0.02 * 67e3 * 0.0025
    ratio = 2 / (1 + 0.0175**2 / 0.02**2)
    rest = level.output[0, -1] / 0.09
    weight = 3 * 0.035 * 9.81 / 0.09

    places = np.linspace(0, 0.09, 2001)
    kappa = np.full_like(places, rest)
    for _ in range(50):
        angle = np.concatenate([[0], np.cumsum((kappa[1:] + kappa[:-1]) / 2 * np.diff(places))])
        lateral = np.concatenate([[0], np.cumsum((angle[1:] + angle[:-1]) / 2 * np.diff(places))])
        tail = [trapezoid(lateral[k:] - lateral[k], places[k:]) for k in range(len(places))]
        kappa = rest - ratio / 2 * weight * np.array(tail) / stiffness
    assert hanging.output[0, -1] == pytest.approx(trapezoid(kappa, places), rel=0.02)
    assert hanging.output[0, -1] < 0.97 * level.output[0, -1]


def test_a_blocked_straight_finger_pushes_with_its_moment_at_small_load():
    """q is linear there: the moment h^2*z*p/2 against F*(L - x), both weighted by the arm."""
    scene = scene_of(STEADY, peak=50.0)
    scene = Scene(scene.specimens, scene.runs, 5, 50.0, 10, True, np.ones(1))
    force = measure("blocked_tip", scene, Plant()).output[0, -1]
    moment = 0.02**2 * 0.02 * 50.0 / 2
    assert force == pytest.approx(moment * (0.09**2 / 2) / (0.09**3 / 3), rel=1e-3)


def test_a_blocked_finger_bulges_by_a_few_percent():
    """By collocation over the arc: theta' = kappa(M), y' = sin(theta), M' = -F*cos(theta)."""
    scene = scene_of(STEADY)
    scene = Scene(scene.specimens, scene.runs, 5, 31e3, 10, True, np.ones(1))
    straight = measure("blocked_tip", scene, Plant()).output[0, -1]
    force = measure("blocked_tip", scene, build([("finite_rotation", {})], 1.0)).output[0, -1]
    ratio = 2 / (1 + 0.018**2 / 0.02**2)
    load, unit = 31e3 * ratio * 0.02 / (4 * 73.7e3 * 0.002), ratio / (2 * 73.7e3 * 0.02**2 * 0.002)

    def slopes(x, y, p):
        stress = load - unit * y[2]
        stretch = [brentq(lambda lam, q=q: lam - lam**-3 - q, 0.3, 5.0) for q in stress]
        return [(np.array(stretch) - 1) / 0.02, np.sin(y[0]), -p[0] * np.cos(y[0])]

    x = np.linspace(0, 0.09, 15)
    guess = [0 * x, 0 * x, straight * (0.09 - x)]
    found = solve_bvp(
        slopes, lambda a, b, p: [a[0], a[1], b[1], b[2]], x, guess, p=[straight], tol=1e-8
    )
    assert force == pytest.approx(found.p[0], rel=1e-6)
    assert 1.005 < force / straight < 1.03


def test_a_finger_with_a_permanent_set_stays_bent_and_rises_again_on_its_return():
    scene = scene_of(Protocol("two", 8.0, triangles([0.6, 1.0], 0.4)[1]), samples=81)
    share, base = 0.1, measure("free_bending", scene, Plant()).output[0]
    angle = measure("free_bending", scene, build([("permanent_set", {"share": share})], 1.0))
    lam, plain = 1 + np.array([angle.output[0], base]) / 0.09 * 0.02
    largest = np.maximum.accumulate(lam)
    rest = 1 + share * (largest - 1)
    assert lam / rest == pytest.approx(plain, rel=1e-12)  # the rubber's own stretch
    assert lam[-1] == pytest.approx(1 + share * (lam.max() - 1), rel=1e-12)


def test_other_forms_start_with_the_modulus_of_the_base():
    near = np.array([1.0 + 1e-4])
    for mode, slope in (("planar", 4.0), ("uniaxial", 3.0)):
        for factor in (
            rubber.ogden(near, mode, 0.3, 6.0),
            rubber.arruda_boyce(near, mode, 5.0),
            rubber.fung(near, mode, 0.2),
        ):
            stress = rubber.neo_hooke(near, mode) * factor
            assert stress[0] == pytest.approx(slope * 1e-4, rel=2e-3)


def test_the_solution_is_the_root_of_a_bracketing_search():
    plant = build([("yeoh_stiffening", {"c2": 0.1})], 1.0)
    scene = scene_of(STEADY, peak=45e3)
    body = scene.body()
    load = float(plant.load(np.array([[45e3]]), np.array([[293.15]]), body)[0, 0])

    def surplus(stretch):
        invariant = stretch**2 + stretch**-2 - 2
        return (stretch - stretch**-3) * (1 + 0.2 * invariant) - load

    stretch, _ = balance.stretches(
        plant, body, np.array([1.0]), np.array([[45e3]]), np.array([293.15]), False
    )
    assert stretch[0, 0, 0] == pytest.approx(brentq(surplus, 1, 4), abs=1e-8)


def test_error_before_is_the_ratio_that_was_asked_for(tmp_path):
    truth = make_set(tmp_path, "free_bending", [("dead_zone", {})], seed=2, ratio=4.0, noise=0.006)
    assert truth["ratio"] == pytest.approx(4.0, rel=0.03)
    assert truth["floor"] > truth["noise"]


def test_repeats_scatter_by_noise_and_scatter(tmp_path):
    make_set(tmp_path, "free_bending", [], seed=4, noise=0.01, scatter=0.0)
    first, again = (
        np.loadtxt(tmp_path / f"{r}.csv", delimiter=",", skiprows=1) for r in ("r01", "r07")
    )
    assert first[:, :2] == pytest.approx(again[:, :2])
    full = np.max(
        [np.loadtxt(f, delimiter=",", skiprows=1)[:, 2].max() for f in tmp_path.glob("*.csv")]
    )
    assert np.std(first[:, 2] - again[:, 2]) / np.sqrt(2) == pytest.approx(0.01 * full, rel=0.2)


def test_the_folder_does_not_tell_what_is_hidden(tmp_path):
    truth = make_set(tmp_path, "free_bending", [("gent_stiffening", {})], seed=1, ratio=4.0)
    assert truth["hidden"][0]["name"] == "gent_stiffening"
    text = "".join(file.read_text() for file in tmp_path.iterdir())
    assert "gent" not in text and "hidden" not in text
    document = yaml.safe_load((tmp_path / "experiment.yaml").read_text())
    assert document["format"] == "softhand-measurement/1"
    assert len(document["runs"]) == 12


def test_the_same_seed_gives_the_same_set(tmp_path):
    for folder in ("a", "b"):
        make_set(tmp_path / folder, "free_bending", [("tube_lag", {})], seed=9, ratio=2.0)
    for file in (tmp_path / "a").iterdir():
        assert file.read_text() == (tmp_path / "b" / file.name).read_text()


def test_protocols_start_and_the_designs_repeat():
    rng = np.random.default_rng(0)
    for protocol in standard(rng):
        assert float(protocol(np.array([0.0]))[0]) == 0.0
        assert 5.0 < protocol.duration < 60.0
    assert triangles([1.0, 0.5], 0.1)[0] == pytest.approx(30.0)
    for design, count in (("standard", 12), ("walls", 24), ("mounts", 24), ("temperatures", 24)):
        scene = plan("free_bending", Options(design=design), rng)
        assert len(scene.runs) == count


def test_pulses_move_air_by_the_naive_law_and_the_bottle_follows(tmp_path):
    truth = make_set(tmp_path, "valve_pulse", [], seed=3, noise=1e-9, scatter=0.0)
    rows = [line.split(",") for line in (tmp_path / "r04.csv").read_text().splitlines()[1:]]
    inflating = np.array([row[0] == "inflate" for row in rows])
    duration, p_in, p_out, friction, injector, mass = np.array(
        [row[1:] for row in rows], float
    ).T * np.array([[1e-3], [1e3], [1e3], [1.0], [1.0], [1e-6]])
    conductance = np.where(
        inflating, truth["calibration"]["inflate"], truth["calibration"]["deflate"]
    )
    assert mass == pytest.approx(conductance * p_in * duration, rel=1e-5)
    bottle = np.where(inflating, p_out, p_in)
    change = np.where(inflating, mass, -mass) * 287.05 * 293.15 / 0.5e-3
    assert bottle[1:] == pytest.approx((bottle + change)[:-1], rel=1e-5)
    middle = bottle + change / 2
    drop = np.where(inflating, p_in - middle, middle - 101.3e3)
    assert friction == pytest.approx(drop * duration, rel=1e-4)
    choked = inflating & (np.maximum(p_out, p_out + change) / p_in < 0.52)
    assert injector[choked] == pytest.approx((0.484 * p_in * duration)[choked], rel=2e-3)


def test_a_strong_law_leads_the_bottle_neither_below_the_ambient_nor_above_the_supply():
    rows = planned(np.random.default_rng(3), ["low_long", "high_long"], 150, Valve(1.5e-10, 6e-10))
    for bias in (-2e-5, 2e-5):
        valve = Valve(1.5e-10, 6e-10)
        LAWS["pulse_bias"].act(valve, c0_inflate=bias, deflate_over=0.5)
        columns = drive(valve, joined(list(rows.values())))
        inflating = columns["direction"]
        bottle = np.where(inflating, columns["p_out"], columns["p_in"])
        assert bottle.min() >= 101.3e3 + 2e3
        assert (columns["p_out"] <= columns["p_in"]).all()


def test_the_flow_function_is_constant_below_the_critical_ratio():
    assert flow.psi(np.array([0.1, 0.5283, 1.0])) == pytest.approx([0.4842, 0.4842, 0], abs=1e-4)


def test_nothing_in_the_generator_imports_the_project():
    folder = Path(rubber.__file__).parent
    text = "".join(file.read_text() for file in folder.glob("*.py"))
    for package in ("softhand_model", "model_lab", "pneuflex_sim"):
        assert f"import {package}" not in text and f"from {package}" not in text


def test_cases_are_named_once_and_show_what_they_hide(tmp_path):
    cases = all_cases()
    assert len({case.name for case in cases}) == len(cases)
    weak = [case for case in cases if case.name.endswith("/weak")]
    for case in weak[::6]:
        assert visible(case.make(tmp_path / case.name, 0, 0.006))
