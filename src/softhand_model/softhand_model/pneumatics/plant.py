"""The pneumatic plant: air in channels, dead volumes and supply behind slow valves."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softhand_model.gas import (
    GAS_CONSTANT,
    line_conductance,
    orifice_conductance,
    series_flow,
)
from softhand_model.pneumatics.command_watch import checked_valves
from softhand_model.pneumatics.parameters import Pneumatics, load_pneumatics
from softhand_model.pneumatics.sensors import build_sensors
from softhand_model.pneumatics.valves import Valves

Floats = NDArray[np.float64]
SLOTS = 8  # channels of one Pneumaticbox
LONGEST_SUBSTEP = 1e-3  # [s]
IN, OUT = 0, 1  # rows of the arrays over flow paths


class PneumaticPlant:
    """Valves, chokes, tubes, supply and sensors of a pneumatic box with a hand on it.

    Per channel one inlet and one outlet path: valve, dead volume, choke, tube, actuator. While a
    valve is open its dead volume stands at supply or ambient pressure; when it has closed, the
    dead volume and the channel even out through the choke. Isothermal.

    `mass` counts all air behind the valves, dead volumes included, so with closed valves it does
    not change whatever the hand's volumes do.

    Args:
        channels: names of the channels, at most 8; channel i is outlet i of the box.
        volumes: rest volumes of the channels, tubes included (n,) [m3].
        parameters: constants; None for those of `data/pneumatics.yaml`.
        seed: of noise and jitter. The tolerances of the box come from `parameters.box_seed`.

    Raises:
        ValueError: too many channels, or volumes of the wrong shape or not above zero.

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
    ) -> None:
        if not 1 <= len(channels) <= SLOTS:
            raise ValueError(f"channels must be 1 to {SLOTS} names, got {list(channels)}")
        self.channels = tuple(channels)
        self.parameters = load_pneumatics() if parameters is None else parameters
        self._seed = seed
        self._gas = GAS_CONSTANT * self.parameters.temperature  # [J/kg]
        self._build_box(len(self.channels))
        self.reset(volumes)

    def _build_box(self, n: int) -> None:
        p = self.parameters
        tolerances = np.random.default_rng(p.box_seed)
        self._valves = Valves(p.valve, tolerances, n, SLOTS)
        self._sensors = build_sensors(
            p.channel_sensor, p.supply_sensor, p.ambient_pressure, tolerances, n, SLOTS
        )
        diameter = np.array([[p.choke.inlet_diameter], [p.choke.outlet_diameter]])
        foil = tolerances.uniform(*p.choke.discharge_coefficient, (2, SLOTS))[:, :n]
        self._choke = orifice_conductance(foil * np.pi / 4 * diameter**2, p.temperature)
        valve = orifice_conductance(np.pi / 4 * p.valve.diameter**2, p.temperature)
        self._choke_and_valve = 1 / np.sqrt(self._choke**-2 + valve**-2)
        length = tolerances.uniform(*p.line.length, SLOTS)[:n]
        self._line = line_conductance(p.line.diameter, length, p.temperature)
        self._dead_capacity = p.choke.dead_volume / self._gas  # [kg/Pa]
        self._supply_capacity = p.supply.volume / self._gas

    def reset(self, volumes: ArrayLike | None = None) -> None:
        """Go back to time zero: closed valves, all air at ambient pressure, fresh noise.

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
        self.set_supply(self.parameters.supply.pressure)
        self.supply_pressure = self._supply_setpoint
        self._net_flow: Floats = np.zeros(n)
        self.inflow: Floats = np.zeros(n)
        self.outflow: Floats = np.zeros(n)
        self.fill(self.rest_mass(self._volumes))
        self._sensors.filtered[-1] = self.supply_pressure

    def set_supply(self, pressure: float) -> None:
        """Turn the regulator of the supply to a gauge `pressure` [Pa]."""
        self._supply_setpoint = pressure + self.parameters.ambient_pressure

    def rest_mass(self, volumes: ArrayLike) -> Floats:
        """Air behind the valves at ambient pressure: the zero of the box's air mass.

        Args:
            volumes: rest volumes (n,) [m3].

        Returns:
            Mass (n,), dead volumes included [kg].
        """
        capacity = np.asarray(volumes, dtype=float) / self._gas + 2 * self._dead_capacity
        return np.asarray(self.parameters.ambient_pressure * capacity)

    def fill(self, mass: ArrayLike) -> None:
        """Put a total `mass` (n,) [kg] behind the valves at once, evened out, valves apart."""
        share = np.asarray(mass, dtype=float)
        pressure = share / (self._volumes / self._gas + 2 * self._dead_capacity)
        self._air: Floats = np.asarray(pressure * self._volumes / self._gas)
        self._dead: Floats = np.vstack([pressure, pressure]) * self._dead_capacity

    @property
    def mass(self) -> Floats:
        """Air behind the valves per channel, dead volumes included (n,) [kg]."""
        return np.asarray(self._air + self._dead.sum(axis=0))

    @property
    def pressures(self) -> Floats:
        """Absolute pressure in the actuators (n,) [Pa]."""
        return np.asarray(self._air * self._gas / self._volumes)

    @property
    def valve_states(self) -> NDArray[np.int8]:
        """Where the spools are: +1 inflating, -1 deflating, 0 closed (n,)."""
        return self._valves.state.copy()

    def read(self) -> Floats:
        """Read the sensors: absolute pressures of the channels, then the supply (n + 1,) [Pa]."""
        return self._sensors.read(self._noise)

    def step(self, dt: float, valves: ArrayLike, volumes: ArrayLike) -> Floats:
        """Advance by `dt`, in substeps of 1 ms or less.

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
        command = checked_valves(valves, len(self.channels))
        target = self._checked_volumes(volumes)
        self._valves.command(self.time, command, self._noise)
        count = math.ceil(dt / LONGEST_SUBSTEP - 1e-9)
        change = (target - self._volumes) / count
        for left in range(count - 1, -1, -1):
            self._volumes = target - left * change
            self._substep(dt / count)
        return self.pressures

    def _checked_volumes(self, volumes: ArrayLike) -> Floats:
        given = np.asarray(volumes, dtype=float)
        if given.shape != (len(self.channels),):
            raise ValueError(f"volumes must have shape ({len(self.channels)},), got {given.shape}")
        if not (given > 0).all():
            raise ValueError(f"volumes must be above 0 m3, got {given.tolist()}")
        return given

    def _substep(self, dt: float) -> None:
        state = self._valves.advance(self.time + dt / 2)
        capacity = self._volumes / self._gas
        pressure = self._air / capacity
        opened = self._open_paths(state)
        moved = self._moved(dt, opened, pressure, capacity)
        net = moved[IN] + moved[OUT]
        self._air = self._air + net
        self._net_flow = net / dt
        through = opened * moved
        self._dead -= moved - through
        self.inflow += through[IN]
        self.outflow -= through[OUT]
        self._supply_step(dt, float(through[IN].sum()))
        self._follow(dt, self._air / capacity)
        self.time += dt

    def _open_paths(self, state: NDArray[np.int8]) -> NDArray[np.bool_]:
        """Tell which paths (2, n) are open; their dead volumes take the outer pressure at once."""
        opened = np.array([state > 0, state < 0])
        if opened.any():
            outer = np.array([[self.supply_pressure], [self.parameters.ambient_pressure]])
            exchanged = opened * (outer * self._dead_capacity - self._dead)
            self._dead += exchanged
            self.inflow += exchanged[IN]
            self.outflow -= exchanged[OUT]
            self.supply_pressure -= float(exchanged[IN].sum()) / self._supply_capacity
        return opened

    def _moved(
        self, dt: float, opened: NDArray[np.bool_], pressure: Floats, capacity: Floats
    ) -> Floats:
        """Mass that flows from the dead volumes into the channels within `dt` (2, n) [kg]."""
        inner = self._dead / self._dead_capacity
        choke = np.where(opened, self._choke_and_valve, self._choke)
        high, low = np.maximum(inner, pressure), np.minimum(inner, pressure)
        flow = series_flow(high, low, choke, self._line)
        # at most what evens out the two sides, or the step would overshoot the equilibrium
        closed_capacity = capacity * self._dead_capacity / (capacity + self._dead_capacity)
        most = (high - low) * np.where(opened, capacity, closed_capacity)
        return np.asarray(np.copysign(np.minimum(flow * dt, most), inner - pressure))

    def _supply_step(self, dt: float, taken: float) -> None:
        """Let the regulator refill the reservoir for `dt` [s] after `taken` [kg] has left."""
        supply = self.parameters.supply
        self.supply_pressure -= taken / self._supply_capacity
        rate = dt / (dt + supply.droop * self._supply_capacity)
        self.supply_pressure += rate * (self._supply_setpoint - self.supply_pressure)

    def _follow(self, dt: float, pressure: Floats) -> None:
        # the sensors sit in the box: while air flows they see the drop along the tube too
        at_box = np.empty(len(pressure) + 1)
        at_box[:-1] = np.sqrt(np.maximum(pressure * pressure + self._net_flow / self._line, 0.0))
        at_box[-1] = self.supply_pressure
        self._sensors.follow(dt, at_box)

    def save(self) -> dict[str, Any]:
        """Return a copy of the whole state, random generators included, for `restore`."""
        arrays = ("_volumes", "_air", "_dead", "_net_flow", "inflow", "outflow")
        return {
            "time": self.time,
            "supply": (self.supply_pressure, self._supply_setpoint),
            "arrays": {name: getattr(self, name).copy() for name in arrays},
            "valves": self._valves.save(),
            "sensors": self._sensors.filtered.copy(),
            "noise": self._noise.bit_generator.state,
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to what `save` returned; the run then repeats bit for bit."""
        self.time = saved["time"]
        self.supply_pressure, self._supply_setpoint = saved["supply"]
        for name, values in saved["arrays"].items():
            setattr(self, name, values.copy())
        self._valves.restore(saved["valves"])
        self._sensors.filtered = saved["sensors"].copy()
        self._noise.bit_generator.state = saved["noise"]
