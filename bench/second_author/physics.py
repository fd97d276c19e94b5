"""Base model and hidden effects, from the equations of the thesis.

`Effects` is a dictionary: name of an effect to its parameters in SI units. Names of the catalogue
have the catalogue's equation; other names are other forms of an effect, or effects that it has not.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

Effects = dict[str, dict[str, float]]

ROOM_TEMPERATURE = 293.15  # [K]
GRAVITY = 9.81  # [m/s2]
STRETCHES = np.linspace(0.5, 4.5, 40001)  # where elastic laws are tabulated


@dataclass(frozen=True)
class Finger:
    """A finger whose height falls linearly from `height` to `tip_height` [m]; modulus G in Pa."""

    length: float
    height: float
    tip_height: float
    width: float
    wall: float
    side_wall: float
    modulus: float
    mass: float = 0.03
    mount: str = "bending_plane_level"

    def nodes(self, count: int) -> np.ndarray:
        """Positions [m] of the middles of `count` equal pieces, shape (count,)."""
        return (np.arange(count) + 0.5) * self.length / count

    def heights(self, count: int) -> np.ndarray:
        """Heights [m] at the nodes, shape (count,)."""
        return self.height + (self.tip_height - self.height) * self.nodes(count) / self.length

    def ratio(self, h: np.ndarray) -> np.ndarray:
        """Ratio of eq. 3.35 for heights h [m]."""
        side = (h - self.wall).clip(0) ** 2 / (h * self.width) * self.side_wall / self.wall
        return 2 / (1 + side)


def strain_invariant(lam: np.ndarray) -> np.ndarray:
    """J1 in pure shear (eq. 3.18)."""
    return lam**2 + lam**-2 - 2


def stiffening(effects: Effects, lam: np.ndarray, j1: np.ndarray) -> np.ndarray:
    """Product of the stiffening factors that depend on the stretch alone."""
    factor = np.ones_like(lam)
    if "gent_stiffening" in effects:
        factor = factor / (1 - j1 / effects["gent_stiffening"]["jm"]).clip(1e-6)
    if "yeoh_stiffening" in effects:
        factor = factor * (1 + 2 * effects["yeoh_stiffening"]["c2"] * j1)
    if "exponential_stiffening" in effects:  # Fung's law
        factor = factor * np.exp(effects["exponential_stiffening"]["b"] * j1)
    if "mooney_rivlin" in effects:  # in uniaxial tension
        b = effects["mooney_rivlin"]["c01_ratio"]
        factor = factor * (1 + b / lam) / (1 + b)
    return factor


def wall_law(effects: Effects, finger: Finger, h: float) -> np.ndarray:
    """Elastic side Q at `STRETCHES` for a section of height h [m]."""
    lam = STRETCHES
    q = lam - lam**-3
    law = q * stiffening(effects, lam, strain_invariant(lam))
    if "thick_wall" in effects:
        gain = effects["thick_wall"]["gain"] * min(2 * finger.wall / h, 1) ** 2
        law = law * (1 + gain * np.exp(-(lam - 1) / 0.25))
    if "side_wall_integral" in effects:
        y, kappa = h - finger.wall, (lam - 1) / h
        term = y**2 / 2 + kappa * y**3 / 3 - y**2 / (2 * (1 + kappa * y) ** 2)
        term = term * 2 * finger.side_wall / (h * finger.width * finger.wall)
        law = finger.ratio(np.array(h)) / 2 * (law + term)
    return law


def lagged(time: np.ndarray, signal: np.ndarray, time_constant: float) -> np.ndarray:
    """First-order lag of a signal on an even grid, from rest at its first value."""
    decay = np.exp(-(time[1] - time[0]) / time_constant)
    return signal[0] + lfilter([1 - decay], [1, -decay], signal - signal[0])


def play(signal: np.ndarray, half_width: float) -> np.ndarray:
    """A play (backlash) of the half width, starting at 0."""
    out, position = np.empty_like(signal), 0.0
    for i, value in enumerate(signal):
        position = min(max(position, value - half_width), value + half_width)
        out[i] = position
    return out


def chamber(effects: Effects, time: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Pressure [Pa] that acts in the chamber, where `pressure` stands at the sensor."""
    p = pressure
    if "clock_offset" in effects:
        p = np.interp(time - effects["clock_offset"]["offset"], time, p, left=0.0)
    if "tube_lag" in effects:
        p = lagged(time, p, effects["tube_lag"]["time_constant"])
    if "two_lags" in effects:
        half = effects["two_lags"]["time_constant"] / 2
        p = lagged(time, lagged(time, p, half), half)
    if "dead_zone" in effects:
        p = (p - effects["dead_zone"]["threshold"]).clip(0)
    if "soft_dead_zone" in effects:
        threshold = effects["soft_dead_zone"]["threshold"]
        p = p - threshold * (1 - np.exp(-p / threshold))
    return p


def load_factor(effects: Effects, p: np.ndarray, run: int, temperature: float) -> np.ndarray:
    """Factor on the load s by effects on the load or on the modulus, for pressures p [Pa]."""
    factor = np.ones_like(p)
    if "temperature_modulus" in effects:
        warmer = temperature - ROOM_TEMPERATURE
        factor = factor / (1 + effects["temperature_modulus"]["coefficient"] * warmer)
    if "ageing" in effects:
        factor = factor / (1 + effects["ageing"]["per_run"] * run)
    if "section_rounding" in effects:
        e = effects["section_rounding"]
        factor = factor * (1 - e["gain"] * np.exp(-p / e["pressure_scale"]))
    if "rational_rounding" in effects:
        e = effects["rational_rounding"]
        factor = factor * (1 - e["gain"] / (1 + (p / e["pressure_scale"]) ** 2))
    if "ballooning" in effects:
        e = effects["ballooning"]
        r = (p / e["onset"]) ** e["sharpness"]
        factor = factor * (1 + e["gain"] * r / (1 + r))
    if "logistic_ballooning" in effects:
        e = effects["logistic_ballooning"]
        factor = factor * (1 + e["gain"] / (1 + np.exp((e["onset"] - p) / e["width"])))
    if "chamber_contact" in effects:
        e = effects["chamber_contact"]
        factor = factor * (1 + e["gain"] * (p - e["onset"]).clip(0) / e["onset"])
    if "kink" in effects:  # above it, the pressure acts less: outside of the catalogue
        e = effects["kink"]
        factor = factor * (1 - e["loss"] * (p - e["onset"]).clip(0) / p.clip(1.0))
    return factor


def relaxed(effects: Effects, time: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Elastic part of the load s, of shape (times, nodes), where the rubber creeps or relaxes."""
    branches = []
    if "viscoelasticity" in effects:
        e = effects["viscoelasticity"]
        branches = [(e["relative_modulus"], e["relaxation_time"])]
    if "two_branches" in effects:
        e = effects["two_branches"]
        half = e["relative_modulus"] / 2
        branches = [(half, e["relaxation_time"] / 2), (half, e["relaxation_time"] * 2)]
    if branches:
        return _branch_relaxation(branches, time, s)
    if "log_compliance" in effects:  # creep, as a compliance
        e = effects["log_compliance"]
        since = time - time[0]
        compliance = e["rate"] * np.log10(1 + since / e["onset_time"])
        steps = np.diff(s, axis=0, prepend=s[:1])
        return s + np.stack(
            [np.convolve(compliance, column)[: len(time)] for column in steps.T], axis=1
        )
    return s


def _branch_relaxation(branches: list, time: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Q of Q + sum(nu) = s, nu' = -nu/tau + g*Q', by the trapezoidal rule."""
    dt = time[1] - time[0]
    g = np.array([branch[0] for branch in branches])[:, None]
    tau = np.array([branch[1] for branch in branches])[:, None]
    keep, take = (1 - dt / tau / 2) / (1 + dt / tau / 2), g / (1 + dt / tau / 2)
    nu, elastic = np.zeros((len(branches), s.shape[1])), np.zeros_like(s)
    for i in range(1, len(s)):
        rise = (s[i] - elastic[i - 1] - (keep * nu).sum(0)) / (1 + take.sum(0))
        nu = keep * nu + take * rise
        elastic[i] = elastic[i - 1] + rise
    return elastic


def with_friction(e: dict[str, float], law: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Stretch for loads s (times,) with the friction of `hysteresis` beside the elastic law."""
    slope = np.gradient(law, STRETCHES)
    height, scale = e["relative_pressure"], e["stretch_scale"]
    steps = np.interp(np.arange(0, len(s) - 1 + 1e-9, 0.1), np.arange(len(s)), s)  # finer
    lam, w, out = 1.0, 0.0, np.empty(len(steps))
    first, width = STRETCHES[0], STRETCHES[1] - STRETCHES[0]
    out[0] = lam
    for i, rise in enumerate(np.diff(steps)):
        way = 1.0 if rise > 0 else -1.0
        place = min(int((lam - first) / width), len(slope) - 1)
        stiffness = slope[place] + height * (1 - way * w) / scale
        change = rise / stiffness
        w = way + (w - way) * np.exp(-abs(change) / scale)
        lam += change
        out[i + 1] = lam
    return out[::10]


def softened(
    effects: Effects, law: np.ndarray, s: np.ndarray, largest: float
) -> tuple[np.ndarray, float]:
    """Stretch for loads s (times,) of a wall that has been at the stretch `largest`; its new one.

    `mullins_softening` as in the catalogue; `tanh_softening` has another course below the largest.
    """
    name = "mullins_softening" if "mullins_softening" in effects else "tanh_softening"
    share, scale = effects[name]["softening"], effects[name]["stretch_scale"]
    course = np.tanh if name == "tanh_softening" else lambda x: 1 - np.exp(-x)
    virgin = np.interp(s, law, STRETCHES)
    most = np.maximum(np.maximum.accumulate(virgin), largest)
    low, high = np.full_like(s, STRETCHES[0]), most.copy()
    for _ in range(40):
        middle = (low + high) / 2
        stress = np.interp(middle, STRETCHES, law) * (1 - share * course((most - middle) / scale))
        low, high = np.where(stress < s, middle, low), np.where(stress < s, high, middle)
    return np.where(virgin >= most, virgin, (low + high) / 2), float(most[-1])


def stretch_of_load(
    effects: Effects, law: np.ndarray, s: np.ndarray, largest: float
) -> tuple[np.ndarray, float]:
    """Stretch for the elastic loads s (times,) of one node, and the largest stretch so far."""
    if "hysteresis" in effects:
        return with_friction(effects["hysteresis"], law, s), largest
    if "stack_of_plays" in effects:
        e = effects["stack_of_plays"]
        plays = [play(s, e["width"] * k) for k in (0.5, 1.0, 2.0)]
        s = (1 - e["share"]) * s + e["share"] * np.mean(plays, axis=0)
    if "mullins_softening" in effects or "tanh_softening" in effects:
        return softened(effects, law, s, largest)
    return np.interp(s, law, STRETCHES), largest


def reading(effects: Effects, time: np.ndarray, y: np.ndarray, run: int) -> np.ndarray:
    """What the output's sensor shows of y, in its own unit."""
    if "camera_perspective" in effects:
        f = effects["camera_perspective"]["foreshortening"]
        turns = np.round(y / np.pi) * np.pi
        y = turns + np.arctan(f * np.tan(y - turns))
    if "distorting_lens" in effects:  # outside of the catalogue
        e = effects["distorting_lens"]
        y = y + e["height"] * np.sin(2 * np.pi * y / e["period"])
    if "mount_backlash" in effects:  # outside of the catalogue
        y = play(y, effects["mount_backlash"]["half_width"])
    if "angle_sensor_lag" in effects:
        y = lagged(time, y, effects["angle_sensor_lag"]["time_constant"])
    if "moving_average" in effects:
        count = max(1, round(2 * effects["moving_average"]["time_constant"] / (time[1] - time[0])))
        y = lfilter(np.full(count, 1 / count), [1.0], y)
    for name in ("angle_offset", "force_offset"):
        if name in effects:
            y = y + effects[name]["offset"]
    if "sensor_drift" in effects:
        e = effects["sensor_drift"]
        settled = -np.expm1(-(time - time[0]) / e["settling_time"])
        y = y + e["per_run"] * run + e["rate"] * e["settling_time"] * settled
    if "saturation" in effects:
        y = np.minimum(y, effects["saturation"]["limit"])
    return y


def pressure_reading(effects: Effects, pressure: np.ndarray) -> np.ndarray:
    """What the pressure sensor shows."""
    gain = effects.get("pressure_gain", {}).get("gain", 1.0)
    return gain * pressure + effects.get("pressure_offset", {}).get("offset", 0.0)


def curvature(
    finger: Finger,
    effects: Effects,
    time: np.ndarray,
    p: np.ndarray,
    factor: np.ndarray,
    moment: np.ndarray | float,
    largest: np.ndarray,
    count: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Curvatures [1/m] (times, nodes) for chamber pressures p [Pa]; the largest stretches (nodes,).

    factor: on the load, (times,). moment: M [N m] (times, nodes), positive when it straightens.
    """
    h = finger.heights(count)
    ratio, stiffness = finger.ratio(h), finger.modulus * h * finger.wall
    s = (p * factor)[:, None] * ratio * h**2 / (4 * stiffness)
    s = s - ratio * moment / (2 * stiffness * finger.width)
    s = relaxed(effects, time, s)
    lam, most = np.empty_like(s), np.empty(count)
    for i in range(count):
        law = wall_law(effects, finger, h[i])
        lam[:, i], most[i] = stretch_of_load(effects, law, s[:, i], largest[i])
    return (lam - 1) / h, most


def printed_curvature(finger: Finger, e: dict[str, float], p: np.ndarray, h: np.ndarray):
    """Curvature by eq. 5.2 and 5.3 with the parameters a and p0 of `actuation_nonlinearity`."""
    a, p0 = e["a"], e["p0"]
    nonlin = 1 / np.sqrt(a) + p / np.sqrt(p**2 / (a - 1) + (a - 1) * p0**2)
    return (p * nonlin)[:, None] * finger.ratio(h) / (8 * finger.modulus * finger.wall)


def tip_angle(
    finger: Finger,
    effects: Effects,
    time: np.ndarray,
    pressure: np.ndarray,
    run: int = 0,
    temperature: float = ROOM_TEMPERATURE,
    largest: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Tip angle [rad] (times,) as the sensor shows it, and the largest stretches (nodes,).

    time [s]: an even grid; pressure [Pa] at the sensor's place, without the sensor's own errors;
    run: how many runs the specimen had before; largest: the stretches that these reached.
    """
    count = 1 if finger.tip_height == finger.height and "gravity" not in effects else 21
    largest = np.ones(count) if largest is None else largest
    p = chamber(effects, time, pressure)
    factor = load_factor(effects, p, run, temperature)
    if "actuation_nonlinearity" in effects:
        e = effects["actuation_nonlinearity"]
        kappa, most = printed_curvature(finger, e, p, finger.heights(count)), largest
    else:
        moment: np.ndarray | float = 0.0
        rounds = 30 if "gravity" in effects else 1
        for _ in range(rounds):
            kappa, most = curvature(finger, effects, time, p, factor, moment, largest, count)
            if "gravity" in effects:
                moment = (moment + weight_moment(finger, effects["gravity"], kappa)) / 2
    angle = kappa.mean(axis=1) * finger.length
    return reading(effects, time, angle, run), most


def weight_moment(finger: Finger, e: dict[str, float], kappa: np.ndarray) -> np.ndarray:
    """Moment [N m] (times, nodes) of the weight beyond each node, positive when it straightens."""
    if finger.mount == "bending_plane_level":
        return np.zeros_like(kappa)
    count = kappa.shape[1]
    step = finger.length / count
    angle = np.cumsum(kappa, axis=1) * step - kappa * step / 2
    sideways = np.cumsum(np.sin(angle), axis=1) * step - np.sin(angle) * step / 2
    pull = e["mass_scale"] * finger.mass * GRAVITY / count
    beyond = np.arange(count, 0, -1) - 1
    lever = np.cumsum(sideways[:, ::-1], axis=1)[:, ::-1] - sideways - beyond * sideways
    return pull * lever * (1.0 if finger.mount == "base_up" else -1.0)


def tip_force(
    finger: Finger,
    effects: Effects,
    time: np.ndarray,
    pressure: np.ndarray,
    run: int = 0,
    temperature: float = ROOM_TEMPERATURE,
) -> np.ndarray:
    """Force [N] of the blocked tip of a finger of constant section, as the gauge shows it."""
    p = chamber(effects, time, pressure)
    h, count = finger.height, 60
    ratio = float(finger.ratio(np.array(h)))
    stiffness = finger.modulus * h * finger.wall
    s = p * load_factor(effects, p, run, temperature) * ratio * h**2 / (4 * stiffness)
    s = relaxed(effects, time, s[:, None])[:, 0]
    lever = finger.length - finger.nodes(count)
    law = wall_law(effects, finger, h)
    compliance = 1 / effects.get("gauge_compliance", {}).get("stiffness", np.inf)

    def deflection(force: np.ndarray) -> np.ndarray:
        moment = force[:, None] * lever * ratio / (2 * stiffness * finger.width)
        lam = np.interp(s[:, None] - moment, law, STRETCHES)
        return ((lam - 1) / h * lever).sum(axis=1) * finger.length / count - force * compliance

    low, high = np.zeros_like(p), 2 * p.max() * h**2 * finger.width / finger.length + 0 * p
    for _ in range(45):
        middle = (low + high) / 2
        bent = deflection(middle) > 0
        low, high = np.where(bent, middle, low), np.where(bent, high, middle)
    force = (low + high) / 2
    if "tip_friction" in effects:
        way = last_direction(force)
        force = force * (1 - effects["tip_friction"]["coefficient"] * way)
    return reading(effects, time, force, run)


def last_direction(signal: np.ndarray) -> np.ndarray:
    """Sign of the last change of the signal that is more than rounding; 0 before the first."""
    change = np.diff(signal, prepend=signal[0])
    moved = np.abs(change) > 1e-7 * np.abs(signal).max()
    last = np.maximum.accumulate(np.where(moved, np.arange(len(signal)), 0))
    return np.sign(change[last]) * moved[last]


def tension(
    modulus: float, effects: Effects, time: np.ndarray, stretch: np.ndarray, run: int, most: float
) -> tuple[np.ndarray, float]:
    """Nominal stress [Pa] of a strip in tension as its gauge shows it, and its largest stretch."""
    j1 = stretch**2 + 2 / stretch - 3
    q = (stretch - stretch**-2) * stiffening(effects, stretch, j1)
    if "ogden" in effects:
        a = effects["ogden"]["exponent"]
        q = 2 / a * (stretch ** (a - 1) - stretch ** (-a / 2 - 1))
    largest = np.maximum(np.maximum.accumulate(stretch), most)
    for name, course in (
        ("mullins_softening", lambda x: 1 - np.exp(-x)),
        ("tanh_softening", np.tanh),
    ):
        if name in effects:
            e = effects[name]
            q = q * (1 - e["softening"] * course((largest - stretch) / e["stretch_scale"]))
    for g, tau in _tension_branches(effects):
        decay = np.exp(-(time[1] - time[0]) / tau)
        gain = g * (1 - decay) * tau / (time[1] - time[0])
        q = q + lfilter([gain], [1, -decay], np.diff(q, prepend=q[0]))
    return reading(effects, time, modulus * q, run), float(largest[-1])


def _tension_branches(effects: Effects) -> list[tuple[float, float]]:
    if "viscoelasticity" in effects:
        e = effects["viscoelasticity"]
        return [(e["relative_modulus"], e["relaxation_time"])]
    return []


def scaled(finger: Finger, scale: float) -> Finger:
    """The finger with `scale` times its modulus."""
    return replace(finger, modulus=finger.modulus * scale)
