"""The monitor's shadow beside the simulated hand: as it lies, with a soft finger, on a table."""

from dataclasses import replace

import numpy as np
import pytest
from held_hand import held, settled_tips

from model_lab.live.shadow import HandShadow, Seen, ShadowLimits
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.status import Level
from softhand_model.effects.hand import ActuatorScatter
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

HAND, LIMITS = load_hand("rbo_hand_2"), ShadowLimits(0.005, 0.2)
PRESSURES, PALM_DOWN = np.full(4, 20e3), (0.0, np.pi / 2.0, 0.0)
BASE = load_model()
SOFT = replace(
    BASE, effects=(*BASE.effects, ActuatorScatter.at(actuator="index")(modulus_factor=0.6))
)


def seen_in(simulation, tips):
    _, orientation = simulation.wrist_pose()
    force, _ = simulation.wrist_wrench()
    return Seen(PRESSURES, True, np.array([*tips.values()]), orientation, force)


def judged(seen, model):
    """The reports of a shadow that looks twice."""
    shadow = HandShadow(HAND, "rbo_hand_2", model, LIMITS)
    predicted = shadow.fingertips(seen.pressures, seen.orientation)
    return [shadow.report(seen, predicted) for _ in range(2)]


@pytest.fixture(scope="module")
def soft_in_air():
    simulation = held(SOFT, PALM_DOWN, segments=10)
    return seen_in(simulation, settled_tips(simulation, PRESSURES))


def test_the_shadow_lies_where_the_simulated_hand_rests(soft_in_air):
    shadow = HandShadow(HAND, "rbo_hand_2", SOFT, LIMITS)
    predicted = shadow.fingertips(PRESSURES, soft_in_air.orientation)
    # ten segments of the simulator against twenty
    assert np.abs(soft_in_air.fingertips - predicted).max() < 5e-4
    upright = shadow.fingertips(PRESSURES, np.array([0.0, 0.0, 0.0, 1.0]))
    assert np.abs(upright - predicted).max() > 3e-3  # weight pulls otherwise


def test_without_a_force_at_the_wrist_the_model_lacks_something(soft_in_air):
    first, second = judged(soft_in_air, BASE)
    assert first.level == Level.OK and "moving" in first.message  # one look shows no rest
    assert second.level == Level.WARN
    assert "index_tip" in second.message and "the model lacks an effect" in second.message
    assert judged(soft_in_air, SOFT)[1].level == Level.OK


def test_with_a_force_at_the_wrist_it_is_contact():
    table = replace(
        load_scene("table"),
        has_object=False,
        rigid_wrist=False,
        wrist_position=(0.0, 0.0, 0.05),
        wrist_rpy=PALM_DOWN,
    )
    simulation = Simulation(SimulationConfig(hand="rbo_hand_2", scene=table, model=BASE))
    seen = seen_in(simulation, settled_tips(simulation, PRESSURES, still=1e-2))
    assert np.linalg.norm(seen.force) > 2.0 * LIMITS.contact_force
    report = judged(seen, BASE)[1]
    assert report.level == Level.WARN and "contact, as the wrist bears" in report.message
    unknown = judged(replace(seen, force=None), BASE)[1]
    assert "no message on wrist/wrench" in unknown.message


def test_nothing_is_said_of_a_hand_that_moves(soft_in_air):
    shadow = HandShadow(HAND, "rbo_hand_2", BASE, LIMITS)
    predicted = shadow.fingertips(PRESSURES, soft_in_air.orientation)
    for step in range(3):
        moved = replace(soft_in_air, fingertips=soft_in_air.fingertips + 0.002 * step)
        assert "moving" in shadow.report(moved, predicted).message
    unsettled = replace(soft_in_air, stood=False)
    assert "moving" in [shadow.report(unsettled, predicted) for _ in range(2)][1].message
