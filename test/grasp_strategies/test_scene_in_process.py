from types import SimpleNamespace as Fields

import numpy as np
import pytest

from grasp_strategies.in_process_scene import InProcessScene, build_scene
from grasp_strategies.scene import SceneError


class FakeSimulation:
    """The parts of a simulation that the scene uses, recording what it is told."""

    step_size = 0.002
    channels = ("a", "b")
    hand = Fields(
        chains=[Fields(name="index"), Fields(name="thumb")],
        max_pressures=lambda: np.array([15e3, 25e3]),
    )

    def __init__(self, breaks=False):
        self.steps, self.masses, self.breaks = 0, [], breaks
        self.target = None
        self.pairs = [("index", "object"), ("object", "table")]

    @property
    def time(self):
        return self.steps * self.step_size

    def set_air_masses(self, masses):
        self.masses.append(np.array(masses))

    def step(self):
        if self.breaks:
            raise RuntimeError("the simulation diverged")
        self.steps += 1

    def command_wrist(self, position, orientation):
        self.target = (position, orientation)

    def pressures(self):
        return np.array([1e4, 2e4])  # below the limits

    def wrist_pose(self):
        return np.array([0.0, 0.0, 0.4]), np.array([0.0, 0.0, 0.0, 1.0])

    def wrist_wrench(self):
        return np.array([1.0, 2.0, 3.0]), np.zeros(3)

    def object_pose(self):
        return np.array([0.0, 0.0, 0.03]), np.array([0.0, 0.0, 0.0, 1.0])

    def object_contacts(self):
        return [Fields(first=first, second=second) for first, second in self.pairs]


def test_a_control_step_is_a_whole_number_of_physics_steps():
    simulation = FakeSimulation()
    scene = InProcessScene(simulation)
    scene.step(0.01)
    assert simulation.steps == 5
    assert scene.time == pytest.approx(0.01)
    scene.step(0.0001)
    assert simulation.steps == 6


def test_the_air_in_the_channels_is_imposed_before_every_physics_step():
    simulation = FakeSimulation()
    scene = InProcessScene(simulation)
    scene.command_air(np.array([1e-4, 0.0]))
    scene.step(0.01)
    rising = [masses[0] for masses in simulation.masses]
    assert len(rising) == 5
    assert np.diff(rising).min() > 0
    assert scene.observe().air_mass == pytest.approx(simulation.masses[-1])


def test_venting_empties_the_channels():
    simulation = FakeSimulation()
    scene = InProcessScene(simulation)
    scene.command_air(np.array([5e-6, 5e-6]))
    scene.step(0.5)
    scene.vent()
    scene.step(0.5)
    assert scene.observe().air_mass.tolist() == [0.0, 0.0]


def test_observation_names_what_touches_the_object_and_what_belongs_to_the_hand():
    scene = InProcessScene(FakeSimulation())
    seen = scene.observe()
    assert seen.touching == {"index", "table"}
    assert scene.hand_bodies == {"index", "thumb", "palm_plate"}
    assert seen.wrist_force.tolist() == [1.0, 2.0, 3.0]
    assert seen.pressure.tolist() == [1e4, 2e4]


def test_a_simulation_that_diverges_ends_the_scene():
    with pytest.raises(SceneError, match="diverged"):
        InProcessScene(FakeSimulation(breaks=True)).step(0.01)


# ---------------------------------------------------------------- the real simulation
@pytest.fixture
def scene():
    scene = build_scene(step=0.002)
    yield scene
    scene.close()


def test_the_real_object_rests_on_the_table_and_nothing_else(scene):
    scene.step(0.2)
    seen = scene.observe()
    assert seen.touching == {"table"}
    assert not seen.touching & scene.hand_bodies
    assert seen.object_position[2] == pytest.approx(0.0325, abs=1e-3)
    assert seen.air_mass.tolist() == [0.0] * len(scene.channels)


def test_the_real_wrist_goes_where_it_is_told(scene):
    start = scene.observe()
    goal = start.wrist_position + [0.0, 0.0, 0.01]
    scene.command_wrist(goal, start.wrist_orientation)
    scene.step(0.5)
    assert scene.observe().wrist_position == pytest.approx(goal, abs=5e-4)


def test_the_real_pressures_rise_with_the_air_that_is_commanded(scene):
    scene.command_air(np.array([1e-5, 0.0, 0.0, 0.0]))
    scene.step(1.0)
    pressure = scene.observe().pressure
    assert pressure[0] > 5e3
    assert np.abs(pressure[1:]).max() < 0.2 * pressure[0]


def test_a_real_finger_is_kept_to_its_pressure_limit():
    scene = build_scene(hand="single_finger", step=0.005, segments=3)
    (limit,) = scene.simulation.hand.max_pressures()
    scene.command_air(np.array([0.5]))
    pressures = []
    for _ in range(500):
        scene.step(0.01)
        pressures.extend(scene.observe().pressure)
    scene.close()
    assert limit < max(pressures) < 1.02 * limit
    assert pressures[-1] < 0.99 * limit
    assert scene.limited == ("a",)


def test_an_unknown_hand_lists_those_there_are():
    with pytest.raises(ValueError, match="rbo_hand_2"):
        build_scene(hand="fist")
