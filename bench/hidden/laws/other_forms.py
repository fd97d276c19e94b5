"""Relatives of the catalogue's effects: the same cause in another functional form."""

from __future__ import annotations

import numpy as np

from bench.hidden import rubber, sensing
from bench.hidden.laws.catalogue import ROOM
from bench.hidden.laws.registry import law, log_uniform
from bench.hidden.plant import Plant
from bench.hidden.rubber import BoucWen, Modes, OgdenRoxburgh, Plays


@law("ogden", ("share", 0.003, 0.95), lambda rng: {"exponent": rng.uniform(5.0, 9.0)})
def ogden(plant: Plant, share: float, exponent: float) -> None:
    """Two-term Ogden law."""
    plant.factors.append(lambda lam, body: rubber.ogden(lam, plant.mode, share, exponent))


@law("arruda_boyce", ("links", 80.0, 0.9))
def arruda_boyce(plant: Plant, links: float) -> None:
    """Eight-chain law."""
    plant.factors.append(lambda lam, body: rubber.arruda_boyce(lam, plant.mode, links))


@law("fung", ("b", 1e-3, 1.5))
def fung(plant: Plant, b: float) -> None:
    """Exponential stiffening."""
    plant.factors.append(lambda lam, body: rubber.fung(lam, plant.mode, b))


@law("gent_thomas", ("ratio", 0.02, 5.0))
def gent_thomas(plant: Plant, ratio: float) -> None:
    """A logarithm of the second invariant in place of Mooney's linear term (uniaxial)."""

    def factor(lam: np.ndarray, body: object) -> np.ndarray:
        second = 2 * lam + lam**-2.0
        return (1 + ratio * 3 / (lam * second)) / (1 + ratio)

    plant.factors.append(factor)


@law(
    "two_modes",
    ("g", 0.005, 3.0),
    lambda rng: {
        "fast": log_uniform(rng, 0.5, 1.2),
        "slow": log_uniform(rng, 4.0, 12.0),
        "share": rng.uniform(0.35, 0.65),
    },
)
def two_modes(plant: Plant, g: float, fast: float, slow: float, share: float) -> None:
    """Two-term Prony series."""
    plant.moving = True
    plant.modes = Modes(np.array([g * share, g * (1 - share)]), np.array([fast, slow]))


@law("power_law", ("g", 0.005, 3.0), lambda rng: {"exponent": rng.uniform(0.1, 0.3)})
def power_law(plant: Plant, g: float, exponent: float) -> None:
    """Relaxation like a power of time: many modes, evenly spread over three decades."""
    plant.moving = True
    times = np.geomspace(0.05, 60.0, 12)
    weights = times**-exponent
    plant.modes = Modes(g * weights / weights.sum(), times)


@law("bouc_wen", ("strength", 0.002, 0.6), lambda rng: {"scale": log_uniform(rng, 0.02, 0.1)})
def bouc_wen(plant: Plant, strength: float, scale: float) -> None:
    """Bouc-Wen loop."""
    plant.moving = True
    plant.loop = BoucWen(strength, scale)


@law("plays", ("strength", 0.002, 0.6), lambda rng: {"scale": log_uniform(rng, 0.02, 0.1)})
def plays(plant: Plant, strength: float, scale: float) -> None:
    """Prandtl-Ishlinskii loop of five elements."""
    plant.moving = True
    plant.loop = Plays(strength, scale)


@law("ogden_roxburgh", ("inverse_r", 0.01, 0.8), lambda rng: {"m": log_uniform(rng, 0.02, 0.12)})
def ogden_roxburgh(plant: Plant, inverse_r: float, m: float) -> None:
    """Softening that goes with the energy."""
    plant.moving = True
    plant.softening = OgdenRoxburgh(inverse_r, m)


@law(
    "second_order_tube",
    ("time_constant", 0.01, 3.0),
    lambda rng: {"damping": rng.uniform(0.7, 1.1)},
)
def second_order_tube(plant: Plant, time_constant: float, damping: float) -> None:
    """Air with inertia in the tube."""
    plant.moving = True
    plant.chamber.append(lambda t, p: sensing.second_order(t, p, time_constant, damping))


@law("orifice_tube", ("time_constant", 0.02, 6.0), lambda rng: {"scale": rng.uniform(5e3, 15e3)})
def orifice_tube(plant: Plant, time_constant: float, scale: float) -> None:
    """A tube that throttles with the square of the flow."""
    plant.moving = True
    plant.chamber.append(lambda t, p: sensing.orifice(t, p, time_constant, scale))


@law("soft_dead_zone", ("threshold", 50.0, 15e3), lambda rng: {"softness": rng.uniform(0.15, 0.35)})
def soft_dead_zone(plant: Plant, threshold: float, softness: float) -> None:
    """A dead zone without an edge."""
    plant.chamber.append(lambda t, p: sensing.softplus(p, threshold, softness * threshold))


@law("curved_zero", ("offset", 30.0, 9000.0), lambda rng: {"curve": rng.uniform(0.15, 0.3)}, True)
def curved_zero(plant: Plant, offset: float, curve: float) -> None:
    """A gauge whose zero error changes a little over its range."""
    plant.gauge.append(lambda p: p + offset * (1 - curve * np.tanh(p / 20e3)))


@law("arrhenius", ("rate", 60.0, 4000.0), signed=True)
def arrhenius(plant: Plant, rate: float) -> None:
    """A modulus that goes exponentially with the inverse temperature; rate [K]."""
    plant.modulus.append(lambda warm: np.exp(rate * (1 / warm - 1 / ROOM)))


@law("rational_rounding", ("gain", 0.01, 0.95), lambda rng: {"scale": log_uniform(rng, 8e3, 20e3)})
def rational_rounding(plant: Plant, gain: float, scale: float) -> None:
    """A section that rounds up with another dependence on pressure."""
    plant.loads.append(lambda s, p: s * (1 - gain / (1 + (np.maximum(p, 0) / scale) ** 2)))


@law("tip_heavy", ("mass_scale", 0.05, 5.0), lambda rng: {"tilt": rng.uniform(0.3, 0.6)})
def tip_heavy(plant: Plant, mass_scale: float, tilt: float) -> None:
    """A finger that is heavier towards its tip."""
    plant.mass_scale, plant.mass_tilt = mass_scale, tilt


@law("rational_thick_wall", ("gain", 0.05, 8.0))
def rational_thick_wall(plant: Plant, gain: float) -> None:
    """A thick wall with another decay."""
    plant.factors.append(
        lambda lam, body: rubber.thick_wall_rational(lam, body.wall / body.height, gain)
    )


@law("cascaded_sensor", ("time_constant", 0.01, 3.0), lambda rng: {"share": rng.uniform(0.3, 0.5)})
def cascaded_sensor(plant: Plant, time_constant: float, share: float) -> None:
    """A sensor with two lags, one after the other."""
    plant.moving = True
    for part in (share, 1 - share):
        plant.sensors.append(lambda t, y, p, k=part: sensing.first_order(t, y, k * time_constant))


@law("hardening_gauge", ("stiffness", 2e4, 20.0), lambda rng: {"half": rng.uniform(1.5, 4.0)})
def hardening_gauge(plant: Plant, stiffness: float, half: float) -> None:
    """A gauge that yields less the harder it is pushed: half of it left at the force `half` [N]."""
    plant.tip_compliance = lambda force: force / stiffness / (1 + np.abs(force) / half)


@law("smooth_tip_friction", ("coefficient", 0.003, 0.6))
def smooth_tip_friction(plant: Plant, coefficient: float) -> None:
    """A tip whose friction grows smoothly with the rate of the force."""
    plant.moving = True

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        rate = np.gradient(y, axis=1) / (t[:, 1:2] - t[:, :1])
        return y * (1 - coefficient * np.tanh(rate / (0.03 * np.abs(y).max())))

    plant.sensors.append(shown)


@law("soft_saturation", ("share", 1.2, 0.3))
def soft_saturation(plant: Plant, share: float) -> None:
    """The sensor nears a limit within a few percent of its range."""

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        level = share * y.max()
        width = 0.04 * level
        return level - width * np.logaddexp(0, (level - y) / width)

    plant.sensors.append(shown)


@law("clock_drift", ("drift", 3e-4, 0.3), signed=True)
def clock_drift(plant: Plant, drift: float) -> None:
    """The output's clock runs at another speed than the pressure's."""
    plant.moving = True

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        rows = [np.interp(a * (1 + drift), a, b) for a, b in zip(t, y, strict=True)]
        return np.array(rows)

    plant.sensors.append(shown)


@law("warming_sensor", ("size", 0.001, 0.8), lambda rng: {"time": rng.uniform(6.0, 15.0)}, True)
def warming_sensor(plant: Plant, size: float, time: float) -> None:
    """The zero creeps from the start of every run, whatever the load."""
    plant.sensors.append(lambda t, y, p: y - size * y.max() * np.expm1(-(t - t[:, :1]) / time))


@law("log_chamber_contact", ("gain", 0.02, 40.0), lambda rng: {"onset": rng.uniform(14e3, 28e3)})
def log_chamber_contact(plant: Plant, gain: float, onset: float) -> None:
    """Chambers that touch softly, and on an area that grows ever more slowly."""

    def load(s: np.ndarray, p: np.ndarray) -> np.ndarray:
        above = sensing.softplus(p, onset, 0.05 * onset) / onset
        return s * (1 + gain * np.log1p(above))

    plant.loads.append(load)


@law(
    "balloon_series",
    ("gain", 0.02, 8.0),
    lambda rng: {"onset": rng.uniform(20e3, 32e3), "spread": rng.uniform(0.03, 0.09)},
)
def balloon_series(plant: Plant, gain: float, onset: float, spread: float) -> None:
    """Five chambers that give way one after the other, each within a twentieth of its pressure."""
    onsets = onset * (1 + spread * np.linspace(-1, 1, 5))

    def load(s: np.ndarray, p: np.ndarray) -> np.ndarray:
        come = [0.5 + np.arctan((p - each) / (0.03 * onset)) / np.pi for each in onsets]
        at_rest = [0.5 + np.arctan(-each / (0.03 * onset)) / np.pi for each in onsets]
        return s * (1 + gain * (np.mean(come, axis=0) - np.mean(at_rest)))

    plant.loads.append(load)


@law("fatigue", ("loss", 1e-3, 0.35))
def fatigue(plant: Plant, loss: float) -> None:
    """A modulus that falls with the logarithm of the number of runs."""
    plant.ageing.append(lambda before: 1 - loss * np.log1p(before) / np.log(12.0))


@law("power_creep", ("rate", 0.005, 0.6), lambda rng: {"exponent": rng.uniform(0.05, 0.12)})
def power_creep(plant: Plant, rate: float, exponent: float) -> None:
    """Relaxation like a small power of time, over five decades."""
    plant.moving = True
    times = np.geomspace(0.05, 5e3, 26)
    weights = times**-exponent
    plant.modes = Modes(rate * weights / weights.sum(), times)


@law("near_camera", ("tilt", 0.08, 1.2), lambda rng: {"distance": rng.uniform(0.4, 0.8)})
def near_camera(plant: Plant, tilt: float, distance: float) -> None:
    """A pinhole camera at a distance [m], tilted [rad]."""
    plant.sensors.append(lambda t, y, p: sensing.seen_aslant(y, 0.09, tilt, distance))


@law("session_creep", ("size", 0.001, 0.8), signed=True)
def session_creep(plant: Plant, size: float) -> None:
    """The zero creeps over the session, ever more slowly."""

    def shown(t: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        spent = np.concatenate([[0.0], np.cumsum(t[:, -1] - t[:, 0])])
        session = (spent[:-1, None] + t - t[:, :1]) / spent[-1]
        return y + size * y.max() * np.sqrt(session + 0.02)

    plant.sensors.append(shown)
