"""Bags of hands that grasp or press, as sets of `grasp` and `press`."""

from dataclasses import replace

import numpy as np
import pytest
from hand_bag import RATE, touching

from model_lab.api.data import import_files
from model_lab.cli.main import main
from model_lab.importing.hand_sets import set_of_hand
from model_lab.measurements.hands import Grasped, Plate
from model_lab.measurements.load import load_measurements
from pneuflex_sim.engines import MUJOCO
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects.load import Gravity
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

HAND = "rbo_hand_2"
CYLINDER, PLATE = Grasped("cylinder"), Plate(0.3)
TOUCHED, LIFTED, LOWERED, END = 3.0, 5.0, 7.0, 9.0  # [s] in a grasp


def grasp(time):
    """A hand that comes down, closes, lifts the object, holds it and puts it down again."""
    wrist = np.interp(time, [0, 2, 5, 6, 7, 8], [0.3, 0.15, 0.15, 0.25, 0.25, 0.15])
    thing = 0.03 + max(0.0, wrist - 0.15) * (time > LIFTED)
    air = np.interp(time, [TOUCHED, 4.0], [0.0, 1.0])
    return -2.0 * (TOUCHED < time < 8.0), wrist, thing, 2e-5 * air, 4e4 * air


def grasped(folder, *results):
    rows = [grasp(step / RATE) for step in range(round(END * RATE))]
    return touching(folder, rows, results or [(5.0 + END, "from_above")])


def press(time):
    """Two presses of different force, 0.8 s of rest between."""
    force = 1.0 * (1.0 < time < 2.0) + 3.0 * (2.8 < time < 3.6)
    return force, 0.2, None, 0.0, 2e4


@pytest.fixture
def pressed(tmp_path):
    return touching(tmp_path / "pressed", [press(step / RATE) for step in range(round(5 * RATE))])


def test_a_grasp_begins_before_it_touches_and_ends_where_the_wrist_comes_down(tmp_path):
    found, _ = set_of_hand([grasped(tmp_path / "a")], HAND, "grasp", touched=CYLINDER)
    (run,) = found.runs
    time, height = run.columns["time"], run.columns["wrist.z"]
    assert time[-1] == pytest.approx(LOWERED - TOUCHED + 0.5, abs=0.15)
    assert height[-1] == pytest.approx(0.25, abs=3e-3)
    assert np.abs(run.columns["wrench.fz"][:9]).max() == 0.0 and run.columns["wrench.fz"][20] == -2
    assert run.columns["wrench.tx"][20] == pytest.approx(-200.0)  # N mm
    assert np.ptp(run.columns["mass.b"]) == pytest.approx(20.0)  # mg
    assert run.columns["pressure.c"][-1] == pytest.approx(40.0)  # kPa
    assert run.columns["object.z"][-1] == pytest.approx(130.0, abs=3.0)  # mm
    assert found.document["runs"]["r1"]["protocol"] == "from_above"


def test_grasps_by_one_strategy_are_repeats_and_the_set_is_one_that_the_lab_reads(tmp_path, capsys):
    bags = [grasped(tmp_path / name, (13.0, name[:-1])) for name in ("push1", "push2", "edge1")]
    out = tmp_path / "set"
    about = ["--hand", HAND, "--experiment", "grasp", "--object", "ball", "--scene", "wall"]
    main(["import", *map(str, bags), "-o", str(out), *about])
    assert "--object ball --scene wall" in capsys.readouterr().out
    data = load_measurements(out)
    assert data.grasped == Grasped("ball", "wall")
    assert [run.protocol for run in data.runs] == ["push", "push", "edge"]


def test_the_result_of_an_earlier_grasp_is_not_that_of_this_one(tmp_path):
    bag = grasped(tmp_path / "a", (2.0, "earlier"), (13.0, "now"))  # latched, as the sequencer does
    found, _ = set_of_hand([bag], HAND, "grasp", touched=CYLINDER)
    assert found.document["runs"]["r1"]["protocol"] == "now"


def test_a_bag_of_two_grasps_is_refused(tmp_path):
    bag = grasped(tmp_path / "a", (9.0, "one"), (13.0, "two"))
    with pytest.raises(DocumentError, match="expected one grasp, got the results of 2"):
        set_of_hand([bag], HAND, "grasp", touched=CYLINDER)


def test_mass_is_that_of_the_channel_when_the_driver_tells_it_before_the_air_has_flowed(tmp_path):
    lead = 0.06  # [s]
    rows = []
    for step in range(1800):
        told, there = (grasp((step / 200.0) + shift) for shift in (lead, 0.0))
        rows.append((*there[:3], told[3], there[4]))
    bag = touching(tmp_path / "a", rows, [(14.0, "from_above")], rate=200.0)
    found, _ = set_of_hand([bag], HAND, "grasp", touched=CYLINDER)
    run = found.runs[0].columns
    more = run["mass.b"] - run["mass.b"][0]
    assert more == pytest.approx(run["pressure.b"] / 2.0, abs=0.15)  # mg, of 20; kPa / 2


@pytest.mark.parametrize("rpy", [(0.0, 0.75 * np.pi, 0.6), (0.0, 0.0, 0.0), (0.0, -1.57, 0.0)])
def test_mass_counts_from_the_unbent_hand_when_the_driver_counts_from_the_hanging_one(
    tmp_path, rpy
):
    """The other engine moves a hand with open channels until it hangs still."""
    high = replace(load_scene("table"), wrist_position=(0.0, 0.0, 0.6), wrist_rpy=rpy)
    about = {"hand": load_hand(HAND), "model": Model(effects=(Gravity(mass_scale=1.0),))}
    simulation = Simulation(SimulationConfig(scene=high, step=0.002, engine=MUJOCO, **about))
    ambient, turns = simulation.ambient, simulation.bodies
    for _ in range(300):
        held = np.full(4, ambient), ambient, simulation.temperature, turns.rotations
        air = simulation.air.masses(*held)
        simulation.set_air_masses(air)
        simulation.step()
    simulation.close()

    bag = touching(tmp_path / "a", [grasp(step / RATE) for step in range(400)], rpy=rpy)
    found, _ = set_of_hand([bag], HAND, "grasp", touched=CYLINDER)
    empty = [found.runs[0].columns[f"mass.{name}"][0] for name in "abcd"]  # the driver tells 0
    assert empty == pytest.approx((1e6 * air).tolist(), abs=0.005)  # mg
    assert np.abs(empty).max() > 0.1


def test_noise_between_two_samples_averages_out(tmp_path):
    random = np.random.default_rng(1)
    rows = [
        (-2.0 + random.normal(), 0.2, 0.03, 1e-5, 2e4 + 1e3 * random.normal()) for _ in range(2000)
    ]
    found, _ = set_of_hand(
        [touching(tmp_path / "a", rows, rate=500.0)], HAND, "grasp", touched=CYLINDER
    )
    scatter = found.runs[0].columns["wrench.fz"][1:-1].std()
    assert scatter == pytest.approx(1.0 / np.sqrt(500.0 / 20.0), rel=0.3)  # 25 readings a sample


def test_presses_are_parted_where_the_hand_is_free(tmp_path, pressed):
    found, _ = set_of_hand([pressed], HAND, "press", touched=PLATE)
    assert [run.columns["wrench.fz"].max() for run in found.runs] == [1.0, 3.0]
    assert [run.columns["wrench.fz"][0] for run in found.runs] == [0.0, 0.0]
    assert np.ptp(found.runs[0].columns["time"]) == pytest.approx(1.4, abs=0.1)
    assert found.document["plate"] == {"friction": 0.3, "height": 0.0}
    found.write(tmp_path / "set")
    assert load_measurements(tmp_path / "set").plate == PLATE


def test_presses_of_several_bags_are_repeats_by_their_order(tmp_path, pressed):
    found, _ = set_of_hand([pressed, pressed], HAND, "press", touched=PLATE)
    told = [entry["protocol"] for entry in found.document["runs"].values()]
    assert told == ["press_1", "press_2", "press_1", "press_2"]


@pytest.mark.parametrize(
    ("experiment", "touched", "told"),
    [
        ("grasp", CYLINDER, "lacks scene/object_pose"),
        ("grasp", None, "expected --object NAME, got none"),
        ("press", None, "expected --plate FRICTION, got none"),
        ("press", CYLINDER, "--object: expected --experiment grasp, got --experiment press"),
        (None, PLATE, "--plate: expected --experiment press, got none"),
    ],
)
def test_what_a_bag_or_a_command_lacks_is_told(pressed, experiment, touched, told):
    with pytest.raises(DocumentError, match=told):
        set_of_hand([pressed], HAND, experiment, touched=touched)


def test_a_hand_that_touches_nothing_is_refused(tmp_path):
    free = touching(tmp_path / "free", 50 * [(0.0, 0.2, 0.03, 0.0, 0.0)])
    for experiment, touched in (("grasp", CYLINDER), ("press", PLATE)):
        with pytest.raises(DocumentError, match="got none"):
            set_of_hand([free], HAND, experiment, touched=touched)


def test_files_of_another_kind_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text("time [s],wrench.fx [N]\n0,1\n1,2\n")
    with pytest.raises(DocumentError, match="expected bags that this suite recorded"):
        set_of_hand([tmp_path / "a.csv"], HAND, "press", touched=PLATE)


def test_in_python_an_object_or_a_friction_says_what_was_touched(tmp_path, pressed):
    one = import_files([grasped(tmp_path / "a")], "grasp", hand=HAND, touched="cylinder")
    two = import_files([pressed], "press", hand=HAND, touched=0.3)
    assert "protocol from_above" in str(one) and "protocol press_2" in str(two)


def test_an_object_that_the_simulator_does_not_know_is_the_users_mistake(tmp_path, capsys):
    found, _ = set_of_hand([grasped(tmp_path / "a")], HAND, "grasp", touched=Grasped("can"))
    found.write(tmp_path / "set")
    assert main(["compare", str(tmp_path / "set")]) == 2
    assert "object: expected one of cylinder" in capsys.readouterr().err


def test_a_bag_of_another_hand_is_refused(pressed):
    with pytest.raises(DocumentError, match="is --hand the hand that was recorded"):
        set_of_hand([pressed], "rbo_hand_1", "press", touched=PLATE)
