"""Parameters of the node `hand_sim`, and the simulation that they configure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from softhand_model.usual_step import USUAL_STEP
from softhand_ros.parameters import Parameter
from softhand_ros.single import ALLOW_SECOND

if TYPE_CHECKING:
    from pneuflex_sim.simulation import SimulationConfig

CHANGING_RATES = ("joint_rate", "wrench_rate")  # these may change while the node runs
SOLVERS = ("fast", "default", "stable")  # pneuflex_sim.world.SETTINGS
ENGINE_CHOICES = ("", "pybullet", "mujoco")
PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter("scene", "table", "scene by name or path of its YAML"),
    Parameter("object", "cylinder", "object by name or path of its YAML, STL or OBJ"),
    Parameter(
        "wall_inclination",
        0.0,
        "inclination of the wall against the table, 5 or more; 0: the scene's",
        "deg",
        (0.0, 120.0),
    ),
    Parameter("friction_file", "", "pairs of materials on top of the shipped table of friction"),
    Parameter("object_offset", [0.0, 0.0], "shift of the object in the world, x and y", "m"),
    Parameter("object_upright", False, "stand the object up, its axes along those of the world"),
    Parameter("object_mass_scale", 1.0, "factor on the object's mass", "-", (0.01, 100.0)),
    Parameter("model_file", "", "softhand-model/1 file; empty: actuators with their weight"),
    Parameter("allow_effect_files", False, "run the Python files that the model file names"),
    Parameter("engine", "", "physics engine; empty: PyBullet if installed", choices=ENGINE_CHOICES),
    Parameter("step", USUAL_STEP, "physics step", "s", (0.0001, 0.01)),
    Parameter("solver", "default", "settings of the contact solver", choices=SOLVERS),
    Parameter("finger_contact", False, "neighbouring fingers touch each other"),
    Parameter("segments", 5, "segments an actuator", bounds=(1, 15)),
    Parameter("seed", 0, "seed of sensors and valves", bounds=(0, 2**31 - 1)),
    Parameter("gui", False, "open PyBullet's window"),
    Parameter("lockstep", True, "wait for the driver's answers and for commanders"),
    Parameter("await_commander", False, "in lockstep, stand at the start until a strategy runs"),
    ALLOW_SECOND,
    Parameter("publish_clock", True, "publish /clock; false: follow another simulator's"),
    Parameter(
        "real_time_factor",
        1.0,
        "upper bound of simulated over wall time; 0: as fast as it goes",
        "-",
        (0.0, 1000.0),
    ),
    Parameter("marker_rate", 10.0, "rate of hand/markers in simulated time", "Hz", (0.1, 100.0)),
    Parameter(
        "joint_rate",
        50.0,
        "rate of hand/joint_states, tip_angles and fingertips in simulated time; 0: every sample",
        "Hz",
        (0.0, 1000.0),
        read_only=False,
    ),
    Parameter(
        "wrench_rate",
        100.0,
        "rate of wrist/wrench in simulated time, 100 or more for the sequencer; 0: every sample",
        "Hz",
        (0.0, 1000.0),
        read_only=False,
    ),
    Parameter("wrist_stiffness", 1000.0, "stiffness of the compliant wrist", "N/m", (1.0, 1e6)),
    Parameter("wrist_force_limit", 20.0, "largest force of the wrist's spring", "N", (0.1, 1e4)),
    Parameter(
        "workspace",
        2.0,
        "how far targets of the wrist may lie from the world's origin along each axis",
        "m",
        (0.1, 100.0),
    ),
)


def configuration(value: Mapping[str, Any]) -> SimulationConfig:
    """Configuration of the simulation from the values of PARAMETERS by name.

    Raises ValueError for values that cannot be used.
    """
    # loaded here: the help prints the parameters, and need not wait for the physics
    from pneuflex_sim.engines import default_engine
    from pneuflex_sim.hand.wrist import WristParameters
    from pneuflex_sim.simulation import SimulationConfig
    from pneuflex_sim.world import solver_settings

    return SimulationConfig(
        hand=value["hand"],
        object=value["object"],
        scene=value["scene"],
        model=value["model_file"] or None,
        allow_effect_files=value["allow_effect_files"],
        step=value["step"],
        segments=value["segments"],
        seed=value["seed"],
        gui=value["gui"],
        object_offset=tuple(value["object_offset"]),
        object_rpy=(0.0, 0.0, 0.0) if value["object_upright"] else None,
        object_mass_scale=value["object_mass_scale"],
        wrist=WristParameters(
            stiffness=value["wrist_stiffness"],
            force_limit=value["wrist_force_limit"],
            workspace=value["workspace"],
        ),
        solver=solver_settings(value["solver"]),
        wall_inclination=value["wall_inclination"] or None,
        friction=value["friction_file"] or None,
        finger_contact=value["finger_contact"],
        engine=value["engine"] or default_engine(),
    )
