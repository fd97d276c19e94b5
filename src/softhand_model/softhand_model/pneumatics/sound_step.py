"""A step of a plant without faults in one compiled call, used for nearly all steps."""

from typing import Any

from softhand_common.numerics.arrays import Array, Spools
from softhand_common.numerics.compiled import compiled
from softhand_model.pneumatics.air_flow import move_air
from softhand_model.pneumatics.sensors import follow_low_pass
from softhand_model.pneumatics.supply import RESERVOIR, supply_air


@compiled
def step_sound_plant(
    dt: float,
    count: int,
    spools: Spools,
    target: Array,
    volumes: Array,
    gas: float,
    ambient: float,
    paths: Any,
    contents: Any,
    supply: Any,
    sensors: Any,
    pressures_abs: Array,
) -> None:
    """Let air flow for `count` substeps of `dt` [s], the spools held: isothermal, no leaks, relief
    valves, flow effects or faults of the supply. Changes what is named below in place.

    Args:
        dt: substep [s].
        count: number of substeps.
        spools: (n,) +1 inflating, -1 deflating, 0 closed.
        target, volumes: of the channels at the end and now (n,) [m3].
        gas: product of gas constant and temperature [J/kg].
        ambient: absolute pressure of the surroundings [Pa].
        paths, contents: the fields of `Paths` and of `Contents`, the latter changed.
        supply: state of an `AirSupply`, changed, and its constants.
        sensors: time constants (n + 1,) [s], and what is changed: absolute pressures (n + 1,) [Pa]
            at the box and behind the sensors' low-pass.
        pressures_abs: result, absolute in the actuators (n,) [Pa].
    """
    reservoir, constants = supply
    time_constant, at_box, filtered = sensors
    capacity = pressures_abs  # until the end
    for left in range(count - 1, -1, -1):
        for i in range(len(target)):
            change = (target[i] - volumes[i]) / count
            capacity[i] = (target[i] - left * change) / gas
        outer = reservoir[RESERVOIR], ambient
        taken = move_air(dt, spools, outer, capacity, paths, contents, at_box)
        supply_air(dt, taken, reservoir, constants)
        at_box[-1] = reservoir[RESERVOIR]
        follow_low_pass(dt, time_constant, at_box, filtered)
    for i in range(len(target)):
        pressures_abs[i] = contents[0][i] / capacity[i]
