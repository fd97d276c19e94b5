"""What is hidden in a hand that is pressed, and the plan, fixed before anything was run."""

from __future__ import annotations

import numpy as np

from bench.hands.cases import Hidden
from softhand_model.effects.elastic import GentStiffening
from softhand_model.effects.hand import ActuatorScatter
from softhand_model.effects.hand_parts import Friction, PalmStiffness, StrutStiffness
from softhand_model.effects.hand_wrench import WrenchBias, WrenchGain
from softhand_model.hand.hand import HandDescription

SEED = 7900  # of the first case; the others follow
CONTROL = "samples_shuffled"
PLATE_HEIGHT, TARED = "plate_height", "tared"
HIGHER = {"strong": 3e-3, "weak": 1e-3}  # [m] by which the plate is higher than stated, or lower
PLAN = [
    ("nothing", ""),
    ("friction", "strong"),
    ("actuator_scatter", "strong"),
    (CONTROL, "control"),
    ("wrench_gain", "strong"),
    ("strut_stiffness", "strong"),
    ("nothing", ""),
    ("gent_stiffening", "outside"),
    ("palm_stiffness", "strong"),
    ("wrench_bias", "strong"),
    ("friction", "weak"),
    ("actuator_scatter", "weak"),
    (CONTROL, "control"),
    ("nothing", ""),
    # later, before any of these was run
    (PLATE_HEIGHT, "strong"),
    (PLATE_HEIGHT, "weak"),
    (TARED, "slip"),
]
SIZES = {  # (strong, weak)
    "friction": (0.5, 0.8),  # factor
    "actuator_scatter": (0.72, 0.90),  # modulus over the nominal one
    "strut_stiffness": (0.4, 0.75),  # factor
    "palm_stiffness": (2.5, 1.4),  # factor
    "wrench_gain": (1.2, 1.05),  # factor
    "wrench_bias": (0.3, 0.1),  # [N] along an axis that is drawn, and a tenth of that in [N m]
    "gent_stiffening": (6.0, 20.0),  # jm
}
OF_WHOLE = {
    "friction": Friction,
    "strut_stiffness": StrutStiffness,
    "palm_stiffness": PalmStiffness,
    "wrench_gain": WrenchGain,
}


def hidden_in(
    hand: HandDescription,
    kind: str,
    strength: str,
    random: np.random.Generator,
    share: float | None = None,
) -> Hidden:
    """A case of the plan, at a place that is drawn; share: of the way from the strong size to the
    weak one.
    """
    if kind == PLATE_HEIGHT:
        higher = float(random.choice([-1.0, 1.0])) * HIGHER[strength]
        return Hidden(hand, kind, strength, value=higher)
    if kind == TARED:
        return Hidden(hand, kind, strength, slip=(TARED, "all forces"))
    if kind not in SIZES:
        return Hidden(hand, kind, strength)
    strong, weak = SIZES[kind]
    way = float(strength == "weak") if share is None else share
    size = strong ** (1.0 - way) * weak**way
    if kind in OF_WHOLE:
        return Hidden(hand, kind, strength, effects=(OF_WHOLE[kind](factor=size),), value=size)
    if kind == "gent_stiffening":
        return Hidden(hand, kind, strength, effects=(GentStiffening(jm=size),))
    if kind == "wrench_bias":
        ways = random.standard_normal((2, 3))
        ways *= size / np.linalg.norm(ways, axis=1)[:, None]
        names = [parameter.name for parameter in WrenchBias.parameters]
        values = (ways * [[1.0], [0.1]]).ravel().tolist()
        bias = WrenchBias(**dict(zip(names, values, strict=True)))
        return Hidden(hand, kind, strength, effects=(bias,))
    places = ActuatorScatter.places(hand)
    where = places[random.integers(len(places))]
    effect = ActuatorScatter.at(**where)(modulus_factor=size)
    return Hidden(hand, kind, strength, where, (effect,), value=size)
