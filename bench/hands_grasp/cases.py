"""What is hidden in a hand that grasps, and the plan, fixed before anything was run."""

from __future__ import annotations

import numpy as np

from bench.hands.cases import Hidden
from model_lab.experiments.grasp_rollouts import Engine
from softhand_model.effects import effect_classes
from softhand_model.effects.elastic import GentStiffening
from softhand_model.effects.hand import ActuatorScatter
from softhand_model.effects.hand_parts import Friction, ObjectMass, PalmStiffness, StrutStiffness
from softhand_model.effects.hand_wrench import WrenchGain
from softhand_model.hand.hand import HandDescription

SEED = 9100  # of the first case; the others follow
ELSEWHERE = Engine(segments=7, step=0.001, name="mujoco")
STEPPED = Engine(segments=7, step=0.001)  # the lab's engine, otherwise
GAUGE = "channel_gauge"  # the gauge of a channel reads too much: not in the catalogue
DRAWN = "drawn"  # strength
DRAWN_POWERS = (0.5, 1.3)  # of a factor of `SIZES`, between which a drawn one lies
PLAN = [  # what, how strong, in which engine
    ("nothing", "", ELSEWHERE),
    ("actuator_scatter", "strong", ELSEWHERE),
    ("object_mass", "strong", ELSEWHERE),
    ("friction", "strong", ELSEWHERE),
    ("gent_stiffening", "outside", ELSEWHERE),
    ("nothing", "", STEPPED),
    ("friction", "strong", STEPPED),
    ("palm_stiffness", "strong", ELSEWHERE),
    ("actuator_scatter", "strong", STEPPED),
    ("strut_stiffness", "strong", ELSEWHERE),
    ("wrench_gain", "strong", ELSEWHERE),
    (GAUGE, "outside", ELSEWHERE),
    ("nothing", "", ELSEWHERE),
    ("actuator_scatter", "strong", ELSEWHERE),
    # added before they were run, after case 9 had shown what interpolated predictions err
    ("strut_stiffness", DRAWN, ELSEWHERE),
    ("palm_stiffness", DRAWN, ELSEWHERE),
    ("object_mass", DRAWN, ELSEWHERE),
    ("friction", DRAWN, ELSEWHERE),
    ("actuator_scatter", DRAWN, ELSEWHERE),
    ("strut_stiffness", DRAWN, ELSEWHERE),
    # added before they were run, after case 17 had shown what a lost object does to interpolation
    ("friction", DRAWN, ELSEWHERE),
    ("friction", DRAWN, ELSEWHERE),
    # added before they were run, after case 21 had shown that interpolation hides a friction
    ("friction", DRAWN, ELSEWHERE),
    ("nothing", "", ELSEWHERE),
    ("actuator_scatter", DRAWN, ELSEWHERE),
    ("gent_stiffening", "outside", ELSEWHERE),
    ("friction", DRAWN, ELSEWHERE),
    ("object_mass", DRAWN, ELSEWHERE),
    (GAUGE, "outside", ELSEWHERE),
    ("palm_stiffness", DRAWN, ELSEWHERE),
    ("nothing", "", STEPPED),
    ("strut_stiffness", DRAWN, ELSEWHERE),
]
SIZES = {  # factors
    "friction": 0.55,
    "actuator_scatter": 0.7,
    "object_mass": 1.6,
    "palm_stiffness": 2.5,
    "strut_stiffness": 0.4,
    "wrench_gain": 1.25,
}
GENT_LIMIT = 6.0  # jm of the stiffening that is outside of what is searched
GAUGE_READS = 1.2  # times the pressure of a channel that is drawn
SEARCHED = {name: effect_classes()[name] for name in SIZES}
OF_WHOLE = {
    "friction": Friction,
    "object_mass": ObjectMass,
    "palm_stiffness": PalmStiffness,
    "strut_stiffness": StrutStiffness,
    "wrench_gain": WrenchGain,
}


def hidden_in(
    hand: HandDescription, kind: str, strength: str, random: np.random.Generator
) -> Hidden:
    """A case of the plan, at a place that is drawn."""
    power = random.uniform(*DRAWN_POWERS) if strength == DRAWN else 1.0
    size = SIZES.get(kind, 1.0) ** power
    if kind in OF_WHOLE:
        return Hidden(hand, kind, strength, effects=(OF_WHOLE[kind](factor=size),), value=size)
    if kind == "gent_stiffening":
        return Hidden(hand, kind, strength, effects=(GentStiffening(jm=GENT_LIMIT),))
    if kind == "actuator_scatter":
        places = ActuatorScatter.places(hand)
        where = places[random.integers(len(places))]
        effect = ActuatorScatter.at(**where)(modulus_factor=size)
        return Hidden(hand, kind, strength, where, (effect,), value=size)
    return Hidden(hand, kind, strength)
