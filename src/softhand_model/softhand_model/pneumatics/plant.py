"""The pneumatic plant: air in channels, dead volumes and supply behind slow valves."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.documents.quoted import listed
from softhand_common.numerics.arrays import Array, Spools
from softhand_model.effects.stages import FlowEffect
from softhand_model.gas import GAS_CONSTANT, line_conductance, orifice_conductance
from softhand_model.pneumatics.air_flow import ChannelHeat, Contents, Paths, move_air
from softhand_model.pneumatics.leaks_and_faults import Escapes, Faults
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics
from softhand_model.pneumatics.pulse_effects import PulseEffects
from softhand_model.pneumatics.sensors import build_sensors
from softhand_model.pneumatics.sound_step import step_sound_plant
from softhand_model.pneumatics.supply import AirSupply
from softhand_model.pneumatics.valves import Valves, checked_valves

SLOTS = 8  # channels of one Pneumaticbox
MOST_SIMULATED_CHANNELS = 64  # of a simulated hand, on as many boxes as that takes
LONGEST_SUBSTEP = 1e-3  # [s]
SHORTEST_SUBSTEP = 1e-6  # resolution of the times at which spools move [s]


class PneumaticPlant:
    """Compressor, valves, chokes, tubes and sensors of a pneumatic box with a hand on it.

    Per channel one inlet and one outlet path: valve, dead volume, choke, tube, actuator. While a
    valve is open its dead volume stands at supply or ambient pressure; when it has closed,
    pressures of dead volume and channel become equal through the choke. Isothermal, unless the
    parameters give the gas a thermal time constant; chokes and tubes always pass air as at room
    temperature.

    `mass` counts all air behind the valves, dead volumes included, so with closed valves and tight
    tubes it does not change whatever the hand's volumes do: it is what has come in less what has
    left, `inflow - outflow - leaked - relieved`. `faults` simulates faults.

    Args:
        channels: names of the channels, at most 64; channel i is outlet i of the box. From the
            ninth on they belong to further boxes on the same supply.
        volumes: rest volumes of the channels, tubes included (n,) [m3].
        parameters: constants of the box; None: those of `load_pneumatics()`.
        seed: seed of noise and jitter. The tolerances of the box come from `parameters.box_seed`.
        relief_pressures: gauge pressures (n,) [Pa] at which a mechanical relief valve on each
            channel begins to open (see `Relief.pressures`); None without relief valves.
        effects: flow effects of a model file, which act on each pulse of a valve.

    Raises:
        ValueError: too many channels; volumes or relief pressures of the wrong shape or not above
            zero.

    >>> plant = PneumaticPlant(["a"], [30e-6])
    >>> for _ in range(200):
    ...     pressures = plant.step(0.001, [1], [30e-6])
    >>> bool(pressures[0] > 102e3)
    True
    """

    def __init__(
        self,
        channels: Sequence[str],
        volumes: ArrayLike,
        parameters: Pneumatics | None = None,
        seed: int = 0,
        relief_pressures: ArrayLike | None = None,
        effects: Sequence[FlowEffect] = (),
    ) -> None:
        if not 1 <= len(channels) <= MOST_SIMULATED_CHANNELS:
            raise ValueError(
                f"channels must be 1 to {MOST_SIMULATED_CHANNELS} names, got {len(channels)}: "
                f"{listed(channels)}"
            )
        self.channels = tuple(channels)
        self.parameters = load_pneumatics() if parameters is None else parameters
        self._seed = seed
        self._gas = GAS_CONSTANT * self.parameters.temperature  # [J/kg]
        self.faults = Faults(self.channels)
        self._build_box(len(self.channels), relief_pressures)
        self._pulses = (
            PulseEffects(effects, self._paths.choke_and_valve, self.parameters.ambient_pressure)
            if effects
            else None
        )
        self.reset(volumes)

    def _build_box(self, n: int, relief_pressures: ArrayLike | None) -> None:
        p, slots = self.parameters, SLOTS * -(-n // SLOTS)
        tolerances = np.random.default_rng(p.box_seed)
        self._valves = Valves(p.valve, tolerances, n, slots)
        self._sensors = build_sensors(
            p.channel_sensor, p.supply_sensor, p.ambient_pressure, tolerances, n, slots
        )
        diameter = np.array([[p.choke.inlet_diameter], [p.choke.outlet_diameter]])
        foil = tolerances.uniform(*p.choke.discharge_coefficient, (2, slots))[:, :n]
        choke = orifice_conductance(foil * np.pi / 4 * diameter**2, p.temperature)
        valve = orifice_conductance(np.pi / 4 * p.valve.diameter**2, p.temperature)
        length = tolerances.uniform(*p.line.length, slots)[:n]
        line = line_conductance(p.line.diameter, length, p.temperature)
        dead_capacity = p.choke.dead_volume / self._gas
        self._paths = Paths(choke, 1 / np.sqrt(choke**-2 + valve**-2), line, dead_capacity)
        leak = tolerances.uniform(*p.leak.conductance, slots)[:n]
        self._escapes = Escapes(p, leak, relief_pressures)
        self._supply = AirSupply(p)

    def reset(self, volumes: ArrayLike | None = None) -> None:
        """Reset to time zero: no faults, closed valves, air at ambient pressure, new noise.

        Args:
            volumes: rest volumes (n,) [m3]; None keeps those of before.
        """
        if volumes is not None:
            self._volumes = self._checked_volumes(volumes)
        n = len(self.channels)
        self.time = 0.0
        self._noise = np.random.default_rng([self._seed, self.parameters.box_seed])
        self._valves.reset(n)
        self._sensors.reset()
        self._supply.reset()
        self.faults.reset()
        if self._pulses is not None:
            self._pulses.reset()
        gas = self.parameters.gas
        self._heat = (
            ChannelHeat(self.parameters.temperature, gas.time_constants(self._volumes))
            if gas.thermal_time_constant
            else None
        )
        self._leaked: Array = np.zeros(n)
        self._relieved: Array = np.zeros(n)
        self._at_box: Array = np.empty(n + 1)
        self._contents = Contents(
            *(np.zeros((2, n) if f == "dead" else n) for f in Contents._fields)
        )
        self.fill(self.rest_mass(self._volumes))
        self._sensors.filtered[-1] = self._supply.pressure

    def set_supply(self, pressure: float) -> None:
        """Set the regulator of the supply to a gauge `pressure` [Pa]."""
        self._supply.set(pressure)

    def rest_mass(self, volumes: ArrayLike) -> Array:
        """Air behind the valves at ambient pressure: the zero of the box's air mass.

        Args:
            volumes: rest volumes (n,) [m3].

        Returns:
            Mass (n,), dead volumes included [kg].
        """
        capacity = np.asarray(volumes, dtype=float) / self._gas + 2 * self._paths.dead_capacity
        return np.asarray(self.parameters.ambient_pressure * capacity)

    def fill(self, mass: ArrayLike) -> None:
        """Set the total `mass` (n,) [kg] behind the valves, in balance and at room temperature."""
        if self._heat is not None:
            self._heat.temperature[:] = self.parameters.temperature
        pressure = np.asarray(mass, dtype=float) / (
            self._volumes / self._gas + 2 * self._paths.dead_capacity
        )
        self._contents.air[:] = pressure * self._volumes / self._gas
        self._contents.dead[:] = pressure * self._paths.dead_capacity

    @property
    def mass(self) -> Array:
        """Air behind the valves per channel, dead volumes included (n,) [kg]."""
        return np.asarray(self._contents.air + self._contents.dead.sum(axis=0))

    @property
    def inflow(self) -> Array:
        """Air that has flowed in from the supply since the start (n,) [kg]."""
        return self._contents.inflow.copy()

    @property
    def outflow(self) -> Array:
        """Air that has left through the outlets since the start (n,) [kg]."""
        return self._contents.outflow.copy()

    @property
    def leaked(self) -> Array:
        """Air lost through leaks and burst tubes since the start (n,) [kg]."""
        return self._leaked.copy()

    @property
    def relieved(self) -> Array:
        """Air lost through relief valves since the start (n,) [kg]."""
        return self._relieved.copy()

    @property
    def pressures(self) -> Array:
        """Absolute pressure in the actuators (n,) [Pa]."""
        return np.asarray(self._contents.air / self._capacity)

    @property
    def temperatures(self) -> Array:
        """Temperature of the air in the actuators (n,) [K]."""
        if self._heat is None:
            return np.full(len(self.channels), self.parameters.temperature)
        return self._heat.temperature.copy()

    @property
    def wall_heat(self) -> Array:
        """Heat absorbed by the walls of the actuators since the start (n,) [J]."""
        return np.zeros(len(self.channels)) if self._heat is None else self._heat.heat.copy()

    @property
    def supply_pressure(self) -> float:
        """Absolute pressure in the reservoir of the box [Pa]."""
        return self._supply.pressure

    @property
    def tank_pressure(self) -> float:
        """Absolute pressure in the compressor's tank [Pa]."""
        return self._supply.tank_pressure

    @property
    def valve_states(self) -> Spools:
        """Positions of the spools: +1 inflating, -1 deflating, 0 closed (n,)."""
        return self.faults.spools(self._valves.state).copy()

    @property
    def _capacity(self) -> Array:
        # mass per pressure in the actuators (n,) [kg/Pa]
        if self._heat is None:
            return np.asarray(self._volumes / self._gas)
        return np.asarray(self._volumes / (GAS_CONSTANT * self._heat.temperature))

    def read(self) -> Array:
        """Read the sensors: absolute pressures of the channels, then the supply (n + 1,) [Pa]."""
        return self.faults.readings(self._sensors.read(self._noise))

    def step(self, dt: float, valves: ArrayLike, volumes: ArrayLike) -> Array:
        """Advance by `dt`, in substeps of 1 ms or less that end when a spool moves.

        Args:
            dt: time to advance [s], above zero.
            valves: electrical command (n,): +1 inflate, -1 deflate, 0 closed.
            volumes: volumes of the channels at the end of the step (n,) [m3].

        Returns:
            Absolute pressure in the actuators (n,) [Pa].

        Raises:
            ValueError: an argument of the wrong shape or value.
        """
        if not dt > 0:
            raise ValueError(f"dt must be above 0 s, got {dt}")
        target = self._checked_volumes(volumes)
        if not self._valves.commanded(valves):
            command = checked_valves(valves, len(self.channels))
            self._valves.command(self.time, command, self._noise)
        count = math.ceil(dt / LONGEST_SUBSTEP - 1e-9)
        self._valves.advance(self.time + SHORTEST_SUBSTEP)
        if self._sound and self._valves.next_change > self.time + dt:
            return self._step_sound(dt / count, count, target)
        change = (target - self._volumes) / count
        for left in range(count - 1, -1, -1):
            self._substep(dt / count, target - left * change)
        return self.pressures

    @property
    def _sound(self) -> bool:
        """Whether `step_sound_plant` has all that acts now."""
        faults = self.faults.burst_any or self.faults.supply_bleed
        return self._heat is None and self._pulses is None and not (self._escapes.any or faults)

    def _step_sound(self, dt: float, count: int, target: Array) -> Array:
        pressures, sensors = np.empty_like(target), self._sensors
        step_sound_plant(
            dt,
            count,
            self.faults.spools(self._valves.state),
            target,
            self._volumes,
            self._gas,
            self.parameters.ambient_pressure,
            tuple(self._paths),  # numba takes plain tuples faster than named ones
            tuple(self._contents),
            (self._supply.state, tuple(self._supply.constants)),
            (sensors.time_constant, self._at_box, sensors.filtered),
            pressures,
        )
        self._volumes = target
        for _ in range(count):
            self.time += dt
        return pressures

    def _checked_volumes(self, volumes: ArrayLike) -> Array:
        given = np.asarray(volumes, dtype=float)
        if given.shape != (len(self.channels),):
            raise ValueError(
                f"volumes must have shape ({len(self.channels)},), one for each channel, "
                f"got {given.shape}"
            )
        if not all(volume > 0 for volume in given.tolist()):
            raise ValueError(f"volumes must be above 0 m3, got {given.tolist()}")
        return given

    def _substep(self, dt: float, volumes: Array) -> None:
        while True:
            self._valves.advance(self.time + SHORTEST_SUBSTEP)
            part = self._valves.next_change - self.time
            if part > dt - SHORTEST_SUBSTEP:
                break
            self._move(part, self._volumes + part / dt * (volumes - self._volumes))
            dt -= part
        self._move(dt, volumes)

    def _move(self, dt: float, volumes: Array) -> None:
        # spools held
        if self._heat is not None:
            self._heat.compress(self._volumes, volumes)
        self._volumes = volumes
        capacity = self._capacity
        if self._escapes.any or self.faults.burst_any or self._pulses is not None:
            self._let_escape(dt, capacity)
        taken = self._flow(dt, capacity)
        if self.faults.supply_bleed:
            self._supply.bleed(dt, taken, self.faults.supply_bleed)
        else:
            self._supply.step(dt, taken)
        self._at_box[-1] = self._supply.pressure
        self._sensors.follow(dt, self._at_box)
        self.time += dt

    def _flow(self, dt: float, capacity: Array) -> float:
        contents, before = self._contents, self._contents
        if self._pulses is not None:
            before = self._copied_contents()
        spools = self.faults.spools(self._valves.state)
        taken = move_air(
            dt,
            spools,
            (self._supply.pressure, self.parameters.ambient_pressure),
            capacity,
            tuple(self._paths),  # numba takes plain tuples faster than named ones
            tuple(contents),
            # the sensors sit in the box: while air flows they see the drop along the tube too
            self._at_box,
        )
        if self._pulses is not None:
            taken += self._pulses.add(dt, spools, self._supply.pressure, before, contents, capacity)
            square = (contents.air / capacity) ** 2 + contents.net_flow / self._paths.line
            self._at_box[:-1] = np.sqrt(np.maximum(square, 0.0))
        if self._heat is not None:
            self._heat.mix(dt, contents.air, contents.received, dt * contents.net_flow)
        return taken

    def _copied_contents(self) -> Contents:
        return Contents(*(array.copy() for array in self._contents))

    def _let_escape(self, dt: float, capacity: Array) -> None:
        air, before = self._contents.air, self._contents.air.copy()
        if self._escapes.relieves:
            relieved = self._escapes.relieved(dt, air / capacity, capacity)
            air -= relieved
            self._relieved += relieved
        if self._escapes.leaks or self.faults.burst_any:
            leaked = self._escapes.leaked(dt, air / capacity, capacity, self.faults.holes)
            air -= leaked
            self._leaked += leaked
        if self._pulses is not None:
            spools = self.faults.spools(self._valves.state)
            leaked = self._pulses.leaked(dt, spools, air / capacity, capacity)
            air -= leaked
            self._leaked += leaked
        if self._heat is not None:
            net = air - before
            self._heat.mix(0.0, air, np.maximum(net, 0.0), net)

    def save(self) -> dict[str, Any]:
        """Return a copy of the whole state, random generators included, for `restore`."""
        return {
            "time": self.time,
            "supply": self._supply.save(),
            "escaped": (self._leaked.copy(), self._relieved.copy()),
            "heat": None if self._heat is None else self._heat.save(),
            "faults": self.faults.save(),
            "pulses": None if self._pulses is None else self._pulses.save(),
            "volumes": self._volumes.copy(),
            "contents": self._copied_contents(),
            "valves": self._valves.save(),
            "sensors": self._sensors.filtered.copy(),
            "noise": self._noise.bit_generator.state,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Restore what `save` returned; the run then repeats bit for bit."""
        self.time = saved["time"]
        self._supply.restore(saved["supply"])
        self._leaked, self._relieved = (array.copy() for array in saved["escaped"])
        self.faults.restore(saved["faults"])
        if self._heat is not None:
            self._heat.restore(saved["heat"])
        if self._pulses is not None:
            self._pulses.restore(saved["pulses"])
        self._volumes = saved["volumes"].copy()
        self._contents = Contents(*(array.copy() for array in saved["contents"]))
        self._valves.restore(saved["valves"])
        self._sensors.filtered = saved["sensors"].copy()
        self._noise.bit_generator.state = saved["noise"]
