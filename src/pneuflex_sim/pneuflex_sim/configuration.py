"""The simulation that the node's parameters ask for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pneuflex_sim.simulation import SimulationConfig
from pneuflex_sim.solver import solver_settings
from pneuflex_sim.wrist import WristParameters


def configuration(value: Callable[[str], Any]) -> SimulationConfig:
    """Configuration by the values of the parameters in `pneuflex_sim.parameters`.

    Raises ValueError for values that cannot be used.
    """
    return SimulationConfig(
        hand=value("hand"),
        object=value("object"),
        scene=value("scene"),
        model=value("model_file") or None,
        step=value("step"),
        segments=value("segments"),
        seed=value("seed"),
        gui=value("gui"),
        object_offset=tuple(value("object_offset")),
        object_mass_scale=value("object_mass_scale"),
        wrist=WristParameters(
            stiffness=value("wrist_stiffness"), force_limit=value("wrist_force_limit")
        ),
        solver=solver_settings(value("solver")),
        wall_inclination=value("wall_inclination") or None,
        friction=value("friction_file") or None,
        finger_contact=value("finger_contact"),
    )
