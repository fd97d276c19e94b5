"""Air in the channels of a recorded hand, from the masses that the driver tells.

The driver tells the air above that at ambient pressure in the hand as it hung when it was zeroed,
and tells it as soon as a valve is commanded. A set states the air that is in a channel at a time,
above that at ambient pressure in the unbent hand, which is how a simulator counts.
"""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.hand_bags import interpolated
from model_lab.measurements.measurement_set import INVERSE_QUATERNION
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.numerics.rotations import rotate
from softhand_model.chain.chain import discretise
from softhand_model.chain.free_response import NoEquilibriumError
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.chain.volumes import VOLUME_SEGMENTS
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

LONGEST_LEAD = 0.15  # [s] by which a mass is told before the air has flowed
LEAD_STEP = 0.002  # [s]
FLOW_OVER = 0.02  # [s] over which a flow is taken from a mass or a pressure


def lead_of_masses(known: Array, masses: Array, pressures: Array) -> float:
    """Time [s] by which masses (n, channels) lead pressures (n, channels) [Pa] at times [s].

    The driver tells the mass after its valves, if switched off now, have closed, which is ahead of
    the air in the channel by the delay of a valve: the shift at which the flows into the channels
    correlate best with how fast the pressures rise; 0 if no air flows.
    """
    time = np.arange(known[0], known[-1], LEAD_STEP)
    if len(time) <= 2 * LONGEST_LEAD / LEAD_STEP:
        return 0.0
    span, most = round(FLOW_OVER / LEAD_STEP), round(LONGEST_LEAD / LEAD_STEP)
    flow, rise = (
        found[span:] - found[:-span]
        for found in (interpolated(time, known, masses), interpolated(time, known, pressures))
    )
    flow, rise = (part / np.maximum(np.std(part, axis=0), 1e-300) for part in (flow, rise))
    told = [np.sum(flow[most - lead : len(flow) - lead] * rise[most:]) for lead in range(most + 1)]
    return LEAD_STEP * int(np.argmax(told)) if np.any(flow) else 0.0


def hanging_air(hand: HandDescription, wrist: Array, segments: int | None = None) -> Array:
    """Air (channels,) [kg] by which the hand holds more at ambient pressure when its weight bends
    it than unbent; less than none if it is bent backwards.

    wrist: quaternion (4,) in the world. segments: number per actuator of a simulated hand; None:
    of a real one.

    Raises DocumentError for a hand that cannot carry its weight.
    """
    down = STANDARD_GRAVITY * rotate(INVERSE_QUATERNION * wrist, [0.0, 0.0, -1.0])
    count, empty = segments or VOLUME_SEGMENTS, np.zeros((len(hand.channels), 1))
    try:
        bodies = settled_hand(hand, Model(), count, empty, down[None])
    except NoEquilibriumError as reason:
        raise DocumentError(
            f"--hand: expected a hand that carries its weight, got {hand.name}: {reason}"
        ) from reason
    volumes = np.zeros(len(hand.channels))
    for body, shape in bodies:
        frames = shape.frames[0]
        unbent = np.concatenate([body.arrays.frame[None], frames[:-1]]) @ body.arrays.rest
        bends = _bends(unbent.swapaxes(1, 2) @ frames)
        for name, joints in body.joints.items():
            chain = hand.chain(name)
            fed = [hand.channel_of(actuator) for actuator in chain.actuators]
            np.add.at(volumes, fed, discretise(chain, count, Model()).volume_gain @ bends[joints])
    return air_mass(AMBIENT_PRESSURE, volumes)


def _bends(turns: Array) -> Array:
    """Rotations about the bending axis (n,) [rad], of turns (n, 3, 3) of joints."""
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    return np.asarray(Rotation.from_matrix(turns).as_rotvec()[:, BEND_AXIS])
