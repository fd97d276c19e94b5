"""Where the free tip of a chain of segments lies, at every pressure up to the actuator's limit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softhand_model.actuator import Actuator
from softhand_model.rest_table import segment_angles

Array = NDArray[np.float64]

PRESSURES = 101  # from 0 to the limit
MOST = 40  # segments that are tried
TARGET = 1.0  # [% of the length] that a tip may be off


def free_tips(actuator: Actuator, segments: int, pressures: Array) -> Array:
    """Places (m, 2) [m], x and z, of the free tip at pressures (m,) [Pa]: a joint in the middle of
    each segment, as the simulator has them.

    >>> from softhand_model.actuator import load_actuator
    >>> free_tips(load_actuator("P10.finger"), 5, np.array([0.0])).round(6).tolist()
    [[0.0, 0.09]]
    """
    angles = segment_angles(actuator, segments, pressures)[0]
    turned = np.hstack([np.zeros((len(angles), 1)), np.cumsum(angles, axis=1)])
    along = np.full(segments + 1, actuator.length / segments)
    along[[0, -1]] /= 2.0
    return np.stack([np.sin(turned) @ along, np.cos(turned) @ along], axis=1)


def sweep(actuator: Actuator, segments: Sequence[int], finest: int) -> dict[str, Any]:
    """Pressures [Pa]; `off`, by number of segments, how far tips are from that of the finest chain
    [% of the length]; `enough`: least number of segments with which TARGET holds up to each
    pressure.
    """
    pressures = np.linspace(0.0, actuator.max_pressure, PRESSURES)
    fine = free_tips(actuator, finest, pressures)

    def off(count: int) -> Array:
        apart = np.linalg.norm(free_tips(actuator, count, pressures) - fine, axis=1)
        return 100.0 * apart / actuator.length

    tried = np.array([np.maximum.accumulate(off(count)) for count in range(2, MOST + 1)])
    beyond = np.vstack([np.ones(PRESSURES, bool), tried > TARGET])
    # the last number that misses it, so that all larger ones keep it as well
    last = len(beyond) - 1 - np.argmax(beyond[::-1], axis=0)
    return {
        "pressure": pressures.tolist(),
        "off": {str(count): off(count).tolist() for count in segments},
        "enough": (last + 2).tolist(),
    }


def worst(swept: dict[str, Any], segments: int) -> tuple[float, float]:
    """Farthest that the tip is off [% of the length], and at which pressure [Pa]."""
    off = swept["off"][str(segments)]
    return max(off), swept["pressure"][int(np.argmax(off))]


def holds_up_to(swept: dict[str, Any], segments: int) -> float:
    """Pressure [Pa] up to which TARGET holds.

    >>> holds_up_to({"pressure": [0.0, 1e3, 2e3, 3e3], "off": {"5": [0.0, 0.5, 1.5, 0.2]}}, 5)
    1000.0
    """
    beyond = np.flatnonzero(np.array(swept["off"][str(segments)]) > TARGET)
    return float(swept["pressure"][beyond[0] - 1 if len(beyond) else -1])
