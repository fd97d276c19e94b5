"""The scene contract in process: imposed air, and a simulation behind it."""

import math
from types import SimpleNamespace as Fields

import numpy as np
import pytest

from grasp_strategies.in_process_scene import (
    SMALLEST_PULSE,
    ImposedAir,
    InProcessScene,
    build_scene,
)
from grasp_strategies.scene import SceneError
from pneumaticbox_driver.safety import PressureGuard
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT
from softhand_model.pneumatics.parameters import load_pneumatics

AMBIENT = 101300.0
NO_LIMITS = np.full(3, np.inf)
REST_VOLUME = 1e-5  # [m3] of a channel


def choked_flow(pressure, diameter, discharge):
    """Mass flow of a choked orifice [kg/s] from the textbook form with the speed of sound."""
    gamma, heat = 1.4, 287.05 * 293.15
    area = discharge * math.pi / 4 * diameter**2
    return (
        area
        * pressure
        * math.sqrt(gamma / heat)
        * (2 / (gamma + 1)) ** ((gamma + 1) / (2 * (gamma - 1)))
    )


def imposed_air(limits):
    return ImposedAir(limits, np.full(len(limits), REST_VOLUME))


def test_a_channel_fills_at_the_rate_of_the_inlet_choke():
    box = load_pneumatics()
    air = imposed_air(NO_LIMITS[:2])
    air.command(np.array([1e-4, 0.0]))
    for _ in range(100):
        masses = air.advance(0.001, np.array([AMBIENT, AMBIENT]))
    expected = choked_flow(
        box.supply.pressure + AMBIENT,
        box.choke.inlet_diameter,
        np.mean(box.choke.discharge_coefficient),
    )
    assert masses[0] / 0.1 == pytest.approx(expected, rel=0.01)
    assert masses[1] == 0.0


def test_a_command_is_met_to_half_a_pulse_and_then_rests():
    wanted = np.array([4.1e-6, 1.37e-5, 2.5e-6])
    air = imposed_air(NO_LIMITS)
    air.command(wanted)
    for _ in range(3000):
        masses = air.advance(0.001, np.full(3, AMBIENT))
    assert np.abs(masses - wanted).max() <= SMALLEST_PULSE / 2
    assert masses / SMALLEST_PULSE == pytest.approx(np.round(masses / SMALLEST_PULSE))
    assert air.advance(0.001, np.full(3, AMBIENT)).tolist() == masses.tolist()


def test_air_leaves_only_while_the_pressure_is_above_ambient():
    air = imposed_air(NO_LIMITS[:1])
    air.masses = np.array([2e-5])
    air.command(np.zeros(1))
    before = air.masses[0]
    assert air.advance(0.001, np.array([150e3]))[0] < before
    before = air.masses[0]
    assert air.advance(0.001, np.array([AMBIENT]))[0] == before


def test_emptying_through_the_wide_choke_is_faster_than_filling():
    filled, emptied = imposed_air(NO_LIMITS[:1]), imposed_air(NO_LIMITS[:1])
    filled.command(np.array([1e-4]))
    emptied.masses = np.array([1e-4])
    emptied.command(np.zeros(1))
    gain = filled.advance(0.001, np.array([200e3]))[0]
    loss = 1e-4 - emptied.advance(0.001, np.array([200e3]))[0]
    assert loss > 3 * gain


VOLUME = 60e-6  # of a rigid bottle [m3]


def bottle_pressure(air):
    """Absolute pressures (channels,) [Pa] when each channel is a bottle."""
    return AMBIENT + air.masses * 287.05 * 293.15 / VOLUME


def follow(air, steps):
    """Absolute pressures (steps, channels) [Pa] of bottles."""
    found = []
    for _ in range(steps):
        air.advance(0.001, bottle_pressure(air))
        found.append(bottle_pressure(air))
    return np.array(found)


def test_a_channel_is_held_below_its_limit_whatever_is_commanded():
    air = imposed_air(np.array([80e3, 250e3]))
    air.command(np.array([5e-4, 4e-5]))
    gauge = follow(air, 6000) - AMBIENT
    assert 80e3 < gauge[:, 0].max() < 81e3  # one step's air above the limit
    assert 0.96 * 80e3 < gauge[-1, 0] < 0.97 * 80e3
    assert gauge[-1, 1] == pytest.approx(4e-5 * 287.05 * 293.15 / VOLUME)
    assert np.ptp(gauge[4000:], axis=0).max() == 0.0  # control and relief do not take turns
    assert air.limited.tolist() == [True, False]


def test_the_limits_act_as_those_of_the_driver():
    """The same pressures shown to both: what the driver's guard forbids does not happen."""
    limits = np.array([80e3])
    air, guard = imposed_air(limits), PressureGuard(limits)
    goal = np.array([5e-4])
    for k, gauge in enumerate([70e3, 81e3, 79e3, 77e3, 70e3, 70e3, 82e3, 60e3]):
        if k == 5:  # a new command
            air.command(goal)
            guard.unblock((0,))
        elif k == 0:
            air.command(goal)
        before = air.masses
        change = air.advance(0.001, np.array([AMBIENT + gauge])) - before
        assert (
            np.sign(change).tolist()
            == guard.apply(np.array([gauge]), goal, np.ones(1, np.int8)).tolist()
        )


def test_a_relieved_channel_fills_again_at_the_next_command():
    air = imposed_air(np.array([80e3]))
    air.command(np.array([5e-4]))
    follow(air, 4000)
    assert air.limited.all()
    air.command(np.array([5e-5]))
    follow(air, 2000)
    assert air.masses[0] == pytest.approx(5e-5)


class Chamber:
    """One whose volume grows with the gauge pressure [Pa], so that it takes more and more air."""

    def __init__(self, growth):
        self.growth, self.share = growth, 1.0
        self.rest = AMBIENT_PRESSURE * REST_VOLUME  # p V of the fill at rest [J]

    def pressure_abs(self, mass):
        content = self.rest + mass * GAS_CONSTANT * 293.15
        # p (V + growth (p - ambient)) = content, a quadratic equation
        volume = self.share * REST_VOLUME - self.growth * AMBIENT_PRESSURE
        return (-volume + np.sqrt(volume**2 + 4 * self.growth * content)) / (2 * self.growth)

    def follow(self, air, steps):
        for _ in range(steps):
            air.advance(0.005, self.pressure_abs(air.masses))
        return float(self.pressure_abs(air.masses)[0] - AMBIENT_PRESSURE)


@pytest.mark.parametrize("growth", [1e-13, 5e-11, 2e-10])  # [m3/Pa]: up to four times the volume
def test_a_pressure_is_reached_to_a_pulse_and_kept_when_the_hand_is_pushed(growth):
    air, chamber = imposed_air(NO_LIMITS[:1]), Chamber(growth)
    air.command_pressure(np.array([210e3]))
    gauge = chamber.follow(air, 2000)
    mass = air.masses.copy()
    pulse = chamber.pressure_abs(mass + SMALLEST_PULSE) - chamber.pressure_abs(mass)
    assert abs(gauge - 210e3) < max(pulse, 12e3)
    assert chamber.follow(air, 2000) == gauge and (air.masses == mass).all()
    chamber.share = 0.6  # pressed together: the pressure rises, and air is let out
    assert chamber.pressure_abs(mass) - AMBIENT_PRESSURE > gauge
    assert abs(chamber.follow(air, 2000) - 210e3) < 15e3
    assert air.masses < mass


def test_a_channel_obeys_the_last_of_its_commands():
    air = imposed_air(NO_LIMITS[:2])
    air.command(np.array([1e-5, 2e-5]))
    air.command_pressure(np.array([50e3, np.nan]))
    at_goal = np.array([50e3, 0.0]) + AMBIENT_PRESSURE
    for _ in range(2000):
        air.advance(0.005, at_goal)
    assert air.masses == pytest.approx([0.0, 2e-5])  # the first has its pressure as it is
    air.command(np.array([5e-6, np.nan]))
    for _ in range(2000):
        air.advance(0.005, at_goal)
    assert air.masses == pytest.approx([5e-6, 2e-5])


@pytest.mark.parametrize("masses", [np.zeros(3), np.array([np.inf, 0.0])])
def test_a_command_that_cannot_be_met_is_refused(masses):
    with pytest.raises(ValueError, match="air masses: expected 2 finite numbers"):
        imposed_air(NO_LIMITS[:2]).command(masses)


class FakeSimulation:
    """The parts of a simulation that the scene uses, recording what it is told."""

    step_size = 0.002
    channels = ("a", "b")
    hand = Fields(
        chains=[Fields(name="index"), Fields(name="thumb")],
        max_pressures=lambda: np.array([15e3, 25e3]),
    )
    air = Fields(rest_volumes=np.full(2, 1e-5))

    def __init__(self, breaks=False):
        self.steps, self.masses, self.breaks = 0, [], breaks
        self.target = None

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

    def touching_object(self):
        return frozenset({"index", "table"})


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


def test_what_was_observed_stays_as_it_was_while_the_simulation_goes_on(scene):
    start = scene.observe()
    copies = {name: np.array(value) for name, value in vars(start).items()}
    scene.command_wrist(start.wrist_position + [0.0, 0.01, 0.01], start.wrist_orientation)
    scene.command_air(np.full(4, 1e-5))
    scene.step(0.3)
    now = scene.observe()
    for name in ("time", "wrist_position", "wrist_force", "air_mass", "pressure"):
        assert not np.array_equal(getattr(now, name), copies[name])
    assert all(np.array_equal(value, copies[name]) for name, value in vars(start).items())


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


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_touches_press_into_the_object_with_the_friction_of_the_pair(engine):
    """A ball that a spring holds in a hand, before and after the fingers close around it."""
    pytest.importorskip(engine)
    parts = {"scene": "held", "object": "ball", "engine": engine}
    scene = build_scene(**parts, step=0.002, friction_scale=1.1)
    scene.hold_object(np.array([0.055, 0.0, 0.115]), np.array([0.0, 0.0, 0.0, 1.0]))
    assert scene.object_touches() == [] and scene.adaptability().links == 0
    for share in np.linspace(0.0, 1.0, 60):
        scene.command_pressure(share * np.array([60e3, 60e3, 60e3, 90e3]))
        scene.step(0.02)
    scene.step(1.5)
    touches = scene.object_touches()
    pair = scene.simulation.friction.pair("rubber", "pvc")
    centre = scene.simulation.object_pose()[0]
    for touch in touches:
        assert touch.friction == pytest.approx(1.1 * pair)
        assert np.dot(touch.normal, centre - touch.position) > 0.0
        assert touch.part in scene.hand_bodies and 0.0 <= touch.patch < 0.01
    found = scene.adaptability()
    assert found.points == len(touches) and found.parts >= 3
    assert found.area == pytest.approx(sum(np.pi * touch.patch**2 for touch in touches))
    scene.close()
