"""What is hidden in a hand that moves, and the plan, fixed before anything was run."""

from __future__ import annotations

import numpy as np

from bench.hands.cases import Hidden
from softhand_model.effects.hand import ActuatorScatter, Crosstalk, MountTilt
from softhand_model.effects.hand_motion import ChannelLag, JointDamping
from softhand_model.effects.hand_parts import TipMass
from softhand_model.hand.hand import HandDescription

SEED = 7700  # of the first case; the others follow
CONTROL = "markers_shuffled"
PLAN = [
    ("nothing", ""),
    ("joint_damping", "strong"),
    ("channel_lag", "strong"),
    (CONTROL, "control"),
    ("tip_mass", "strong"),
    ("actuator_scatter", "strong"),
    ("nothing", ""),
    ("crosstalk", "strong"),
    ("mount_tilt", "strong"),
    ("channel_lag", "weak"),
    ("joint_damping", "weak"),
    ("tip_mass", "weak"),
    (CONTROL, "control"),
    ("nothing", ""),
]
SIZES = {  # (strong, weak)
    "joint_damping": (0.02, 0.013),  # [s]
    "channel_lag": (0.06, 0.02),  # [s]
    "tip_mass": (0.006, 0.002),  # [kg]
    "actuator_scatter": (0.72, 0.90),  # modulus over the nominal one
    "crosstalk": (0.20, 0.06),  # share of the pressure
    "mount_tilt": (0.10, 0.04),  # [rad] about an axis that is drawn
}


def hidden_in(
    hand: HandDescription, kind: str, strength: str, random: np.random.Generator
) -> Hidden:
    """A case of the plan, at a place that is drawn."""
    if kind not in SIZES:
        return Hidden(hand, kind, strength)
    size = SIZES[kind][strength == "weak"]
    if kind == "joint_damping":
        return Hidden(hand, kind, strength, effects=(JointDamping(time=size),), value=size)
    if kind == "mount_tilt":
        turn = random.standard_normal(3)
        turn *= size / np.linalg.norm(turn)
        where = {"chain": str(random.choice([chain.name for chain in hand.chains]))}
        values = dict(zip(("roll", "pitch", "yaw"), turn.tolist(), strict=True))
        return Hidden(hand, kind, strength, where, (MountTilt.at(**where)(**values),))
    makers = {
        "channel_lag": (ChannelLag, "time_constant"),
        "tip_mass": (TipMass, "mass"),
        "actuator_scatter": (ActuatorScatter, "modulus_factor"),
        "crosstalk": (Crosstalk, "share"),
    }
    made, parameter = makers[kind]
    places = made.places(hand)
    where = places[random.integers(len(places))]
    effect = made.at(**where)(**{parameter: size})
    return Hidden(hand, kind, strength, where, (effect,), value=size)
