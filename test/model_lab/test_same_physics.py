"""One effect, one physics: the simulator's chain and the lab's prediction are the same curve."""

import dataclasses

import numpy as np
import pytest
from lab_sets import SIZE, measured, run, specimen

from model_lab.experiments.forward import Forward
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.profile import ConstantProfile
from softhand_model.model_file import Model

EFFECTS = effect_classes()
TIME = np.concatenate([[0.0], np.cumsum(np.tile([0.01, 0.02, 0.05], 40))])
PRESSURE = 45e3 * np.abs(np.sin(2.5 * TIME)) * np.linspace(0.6, 1.0, len(TIME))
RAMPS = 45e3 * np.interp(TIME, TIME[::15], [0.0, 0.7, 0.1, 0.8, 0.0, 1.0, 0.3, 0.9, 0.2])
TEMPERATURE = 303.15
SHAPED = [
    name
    for name, one in EFFECTS.items()
    if "free_bending" in one.experiments
    and one.stage != "output"
    and not one.not_simulated
    and name
    not in ("gravity", "ageing")  # the one acts through the engine, the other in later runs
]


def usual(name):
    """An effect with the usual values of its parameters, or those near the end of the usual range
    where the middle, 0, does nothing.
    """
    effect = EFFECTS[name]
    return effect(**{p.name: p.usual() or p.usual(0.9) for p in effect.parameters})


def level_finger(effects):
    """Chain of a finger of constant section, as of the lab's specimen."""
    part = dataclasses.replace(
        load_actuator("P10.finger"),
        length=SIZE["length"],
        height=ConstantProfile(SIZE["height"]),
        width=ConstantProfile(SIZE["width"]),
        wall=ConstantProfile(SIZE["wall"]),
        side_wall=ConstantProfile(SIZE["side_wall"]),
        shear_modulus=SIZE["shear_modulus"],
    )
    description = load_hand("single_finger").chain("finger")
    name = next(iter(description.actuators))
    changed = dataclasses.replace(description, actuators={name: part})
    return discretise(changed, 5, Model(effects=tuple(effects)))


def course(effects):
    """Pressure [Pa]: in straight lines, as a chain has it between ticks, for what takes time."""
    return RAMPS if any(effect.has_memory for effect in effects) else PRESSURE


def simulated(effects, pressure):
    """Tip angles [rad] of the chain, stepped from sample to sample."""
    chain = level_finger(effects)
    steps = zip(np.diff(TIME, prepend=0.0), pressure, strict=True)
    rotations = [chain.free_rotation(dt, [pressure], TEMPERATURE) for dt, pressure in steps]
    return np.array(rotations)[:, :, 1].sum(axis=1)


def predicted(effects, pressure):
    """Tip angles [rad] of the lab."""
    one = run("r", TIME, pressure=pressure, temperature=TEMPERATURE)
    data = measured("free_bending", [one], specimen())
    forward = Forward(data, fixed=effects, free_calibration=False)
    return forward.predict(np.zeros((1, 0)))[0]


@pytest.mark.parametrize("name", SHAPED)
def test_chain_and_lab_bend_alike(name):
    effect = usual(name)
    pressure = course([effect])
    together = predicted([effect], pressure)
    assert simulated([effect], pressure) == pytest.approx(together, rel=1e-7, abs=1e-9)
    assert np.abs(together - predicted([], pressure)).max() > 0.05


def test_several_effects_act_together_alike():
    chosen = ["tube_lag", "section_rounding", "gent_stiffening", "viscoelasticity", "hysteresis"]
    effects = [usual(name) for name in reversed(chosen)]
    found = simulated(effects, RAMPS)
    assert found == pytest.approx(predicted(effects, RAMPS), rel=1e-6, abs=1e-8)


def test_sensor_of_the_simulated_hand_and_of_the_lab_read_alike():
    from pneuflex_sim.hand.kinematics import TipSensors

    effects = [usual(name) for name in ("angle_offset", "angle_sensor_lag")]
    sensors = TipSensors(Model(effects=tuple(effects)))
    shown = []
    for dt, angle in zip(np.diff(TIME, prepend=0.0), simulated([], RAMPS), strict=True):
        sensors.step(dt, {"finger": angle})
        shown.append(sensors.readings({})["finger"])
    assert np.array(shown) == pytest.approx(predicted(effects, RAMPS), rel=1e-6, abs=1e-8)
