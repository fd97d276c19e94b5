"""The catalogue's own effects, straight from its equations."""

from __future__ import annotations

import numpy as np

from bench.hidden import rubber, sensing
from bench.hidden.laws.registry import law, log_uniform
from bench.hidden.plant import Plant
from bench.hidden.rubber import Loop, Modes, Softening

ROOM = 293.15


@law("pressure_offset", ("offset", 30.0, 9000.0), signed=True)
def pressure_offset(plant: Plant, offset: float) -> None:
    """The gauge shows more than acts."""
    plant.gauge.append(lambda p: p + offset)


@law("pressure_gain", ("gain", 1.01, 1.5))
def pressure_gain(plant: Plant, gain: float) -> None:
    """The gauge shows a multiple of what acts."""
    plant.gauge.append(lambda p: gain * p)


@law("tube_lag", ("time_constant", 0.01, 3.0))
def tube_lag(plant: Plant, time_constant: float) -> None:
    """The chamber lags the gauge."""
    plant.moving = True
    plant.chamber.append(lambda t, p: sensing.first_order(t, p, time_constant))


@law("dead_zone", ("threshold", 50.0, 15e3))
def dead_zone(plant: Plant, threshold: float) -> None:
    """Nothing happens below a threshold."""
    plant.chamber.append(lambda t, p: np.maximum(0.0, p - threshold))


@law("temperature_modulus", ("coefficient", 2e-4, 0.02), signed=True)
def temperature_modulus(plant: Plant, coefficient: float) -> None:
    """The modulus changes with temperature."""
    plant.modulus.append(lambda warm: 1 + coefficient * (warm - ROOM))


@law(
    "section_rounding",
    ("gain", 0.01, 0.95),
    lambda rng: {"pressure_scale": log_uniform(rng, 6e3, 20e3)},
)
def section_rounding(plant: Plant, gain: float, pressure_scale: float) -> None:
    """A section that first rounds up bends less."""
    plant.loads.append(lambda s, p: s * (1 - gain * np.exp(-np.maximum(p, 0) / pressure_scale)))


@law("gravity", ("mass_scale", 0.05, 5.0))
def gravity(plant: Plant, mass_scale: float) -> None:
    """The weight of what lies beyond."""
    plant.mass_scale = mass_scale


@law("tip_load", ("mass", 5e-4, 0.2))
def tip_load(plant: Plant, mass: float) -> None:
    """Something hangs at the tip."""
    plant.tip_mass = mass


@law("gent_stiffening", ("jm", 400.0, 1.8))
def gent_stiffening(plant: Plant, jm: float) -> None:
    """Chains of limited length."""
    plant.factors.append(lambda lam, body: rubber.gent(lam, plant.mode, jm))


@law("yeoh_stiffening", ("c2", 5e-4, 1.0))
def yeoh_stiffening(plant: Plant, c2: float) -> None:
    """A second-order term of the energy."""
    plant.factors.append(lambda lam, body: rubber.yeoh(lam, plant.mode, c2))


@law("mooney_rivlin", ("c01_ratio", 0.02, 5.0))
def mooney_rivlin(plant: Plant, c01_ratio: float) -> None:
    """A term of the second invariant."""
    plant.factors.append(lambda lam, body: rubber.mooney_rivlin(lam, plant.mode, c01_ratio))


@law("thick_wall", ("gain", 0.05, 8.0))
def thick_wall(plant: Plant, gain: float) -> None:
    """A thick wall is stiffer near rest."""
    plant.factors.append(lambda lam, body: rubber.thick_wall(lam, body.wall / body.height, gain))


@law(
    "mullins_softening",
    ("softening", 0.01, 0.8),
    lambda rng: {"stretch_scale": log_uniform(rng, 0.06, 0.25)},
)
def mullins_softening(plant: Plant, softening: float, stretch_scale: float) -> None:
    """Softer below the largest stretch so far."""
    plant.moving = True
    plant.softening = Softening(softening, stretch_scale)


@law(
    "viscoelasticity",
    ("relative_modulus", 0.005, 3.0),
    lambda rng: {"relaxation_time": log_uniform(rng, 0.6, 8.0)},
)
def viscoelasticity(plant: Plant, relative_modulus: float, relaxation_time: float) -> None:
    """Standard linear solid."""
    plant.moving = True
    plant.modes = Modes(np.array([relative_modulus]), np.array([relaxation_time]))


@law(
    "hysteresis",
    ("relative_pressure", 0.002, 0.6),
    lambda rng: {"stretch_scale": log_uniform(rng, 0.02, 0.12)},
)
def hysteresis(plant: Plant, relative_pressure: float, stretch_scale: float) -> None:
    """Rate-independent friction within the rubber."""
    plant.moving = True
    plant.loop = Loop(relative_pressure, stretch_scale)


@law("side_wall_integral", None)
def side_wall_integral(plant: Plant) -> None:
    """Side walls integrated over their height."""
    plant.side_walls = True


@law("actuation_nonlinearity", ("a", 4.0, 14.0), lambda rng: {"p0": rng.uniform(45e3, 75e3)})
def actuation_nonlinearity(plant: Plant, a: float, p0: float) -> None:
    """Curvature by 5.2 and 5.3; 5.6 gives p0 = 60 kPa for a wall of 2.5 mm."""
    plant.printed = (a, p0)


@law("permanent_set", ("share", 1e-3, 0.5))
def permanent_set(plant: Plant, share: float) -> None:
    """Rubber stays longer; a strip hangs slack below that, a finger stays bent."""
    plant.set_share = share


@law("finite_rotation", None)
def finite_rotation(plant: Plant) -> None:
    """A blocked finger bulges."""
    plant.bulges = True


@law("machine_compliance", ("stiffness", 1e9, 3e4))
def machine_compliance(plant: Plant, stiffness: float) -> None:
    """The grips yield, too."""
    plant.grips = 1.0 / stiffness


@law("gauge_compliance", ("stiffness", 2e4, 20.0))
def gauge_compliance(plant: Plant, stiffness: float) -> None:
    """The gauge yields."""
    plant.tip_compliance = lambda force: force / stiffness


@law("tip_friction", ("coefficient", 0.003, 0.6))
def tip_friction(plant: Plant, coefficient: float) -> None:
    """The tip sticks on the gauge."""
    plant.moving = True
    plant.sensors.append(lambda t, y, p: y * (1 - coefficient * _direction(y, plant.parts)))


def _direction(value: np.ndarray, parts: int) -> np.ndarray:
    """Sign of the change over the last sample's time, zero where nothing changes."""
    back = np.maximum(np.arange(value.shape[1]) - parts, 0)
    change = value - value[:, back]
    return np.sign(np.where(np.abs(change) > 1e-7 * np.abs(value).max(), change, 0.0))


@law("angle_sensor_lag", ("time_constant", 0.01, 3.0))
def angle_sensor_lag(plant: Plant, time_constant: float) -> None:
    """The angle sensor lags."""
    plant.moving = True
    plant.sensors.append(lambda t, y, p: sensing.first_order(t, y, time_constant))


@law("angle_offset", ("offset", 0.002, 0.8), signed=True)
def angle_offset(plant: Plant, offset: float) -> None:
    """The angle sensor's zero is off."""
    plant.sensors.append(lambda t, y, p: y + offset)


@law("force_offset", ("offset", 0.001, 5.0), signed=True)
def force_offset(plant: Plant, offset: float) -> None:
    """The force gauge's zero is off."""
    plant.sensors.append(lambda t, y, p: y + offset)


@law("stress_offset", ("offset", 10.0, 3e5), signed=True)
def stress_offset(plant: Plant, offset: float) -> None:
    """The load cell of a tension test was not tared."""
    plant.sensors.append(lambda t, y, p: y + offset)


@law("stretch_offset", ("offset", 3e-4, 0.2), signed=True)
def stretch_offset(plant: Plant, offset: float) -> None:
    """A strip is taut at another reading than 1."""
    plant.gauge.append(lambda strain: strain + offset)


@law("angle_gain", ("gain", 1.01, 1.5))
def angle_gain(plant: Plant, gain: float) -> None:
    """The scale of the angle sensor is off."""
    plant.sensors.append(lambda t, y, p: gain * y)


@law("bend_twist_coupling", ("k45", 0.01, 0.7), signed=True)
def bend_twist_coupling(plant: Plant, k45: float) -> None:
    """A finger that twists when it is bent sideways."""
    plant.bend_twist = k45


@law("passive_layer_slack", ("ratio", 0.99, 0.15))
def passive_layer_slack(plant: Plant, ratio: float) -> None:
    """A passive layer that hangs loose while it is straightened."""
    plant.slack = ratio


@law("clock_offset", ("offset", 0.004, 1.5), lambda rng: {"drift": 0.0}, signed=True)
def clock_offset(plant: Plant, offset: float, drift: float) -> None:
    """The output's clock is another than the pressure's."""
    plant.moving = True
    plant.chamber.append(lambda t, p: sensing.late(t, p, offset + drift * (t - t[:, :1])))


@law("chamber_contact", ("gain", 0.02, 20.0), lambda rng: {"onset": rng.uniform(14e3, 28e3)})
def chamber_contact(plant: Plant, gain: float, onset: float) -> None:
    """Chambers that touch push one another."""
    plant.loads.append(lambda s, p: s * (1 + gain * np.maximum(p - onset, 0) / onset))


@law(
    "ballooning",
    ("gain", 0.02, 8.0),
    lambda rng: {"onset": rng.uniform(20e3, 34e3), "sharpness": log_uniform(rng, 8.0, 25.0)},
)
def ballooning(plant: Plant, gain: float, onset: float, sharpness: float) -> None:
    """Chambers that swell at a pressure."""

    def load(s: np.ndarray, p: np.ndarray) -> np.ndarray:
        power = (np.maximum(p, 0) / onset) ** sharpness
        return s * (1 + gain * power / (1 + power))

    plant.loads.append(load)


@law("ageing", ("per_run", 3e-4, 0.08), signed=True)
def ageing(plant: Plant, per_run: float) -> None:
    """A modulus that changes from run to run."""
    plant.ageing.append(lambda before: 1 + per_run * before)


@law("creep", ("rate", 0.002, 0.14), lambda rng: {"onset_time": log_uniform(rng, 0.05, 0.6)})
def creep(plant: Plant, rate: float, onset_time: float) -> None:
    """Logarithmic creep: log(1 + x) by thirty modes over nine decades."""
    plant.moving = True
    speeds, step = np.linspace(np.log(1e-8), np.log(8.0), 30, retstep=True)
    weights = rate / np.log(10) * step * np.exp(-np.exp(speeds))
    at_once = 1 - weights.sum()
    plant.factors.append(lambda lam, body: at_once)
    plant.modes = Modes(weights / at_once, onset_time / np.exp(speeds))


@law("camera_perspective", ("foreshortening", 0.99, 0.35))
def camera_perspective(plant: Plant, foreshortening: float) -> None:
    """A camera that looks aslant, from afar."""

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        seen = np.arctan2(foreshortening * np.sin(y), np.cos(y))
        return seen + 2 * np.pi * np.round((y - seen) / (2 * np.pi))

    plant.sensors.append(shown)


@law(
    "sensor_drift",
    ("rate", 1e-5, 1e4),
    lambda rng: {"settling_time": log_uniform(rng, 6.0, 30.0), "per_run": 0.0},
    signed=True,
)
def sensor_drift(plant: Plant, rate: float, settling_time: float, per_run: float) -> None:
    """The zero drifts in every run and from run to run."""

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        within = -rate * settling_time * np.expm1(-(t - t[:, :1]) / settling_time)
        return y + within + per_run * np.arange(len(y))[:, None]

    plant.sensors.append(shown)


@law("saturation", ("limit", 1e7, 0.01))
def saturation(plant: Plant, limit: float) -> None:
    """The sensor ends at a limit."""
    plant.sensors.append(lambda t, y, p: np.minimum(y, limit))
