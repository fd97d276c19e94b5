"""A ball that flies against a finger: the chain of the simulator, linear about straight, with the
inertia of its links alone, struck through the skin's spring.

With bends q, the finger's way u = r q where it is struck (r the levers of the joints), and the
ball's way b,

    M q'' = -K q - D q' + r F,    m b'' = -F,    F = k max(b - u, 0).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

from pneuflex_sim.hand.layout import build_layout
from softhand_model.dynamics.chain import inertial_torque, not_placed, place_links
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import load_model
from softhand_model.motion.pressed_body import SKIN_NORMAL
from thesis.frame import Array

BEND_COLUMN = 1  # bending is about y
LONGEST_BLOW, SAMPLES = 0.6, 6001  # [s] that is followed, and times of it
EXACT = 1e-9  # relative error of a step; absolute, of ways in 10 um and of bends in 10 urad


@dataclass(frozen=True)
class Finger:
    """A finger in its bending plane: inertia (n, n) [kg m2], stiffness (n,) [N m/rad] and damping
    (n,) [N m s/rad] of its joints, and their levers (n,) [m] to where it is struck.
    """

    inertia: Array
    stiffness: Array
    damping: Array
    levers: Array

    def scaled(self, factor: float) -> Finger:
        """The same of `factor` [-] times stiffer rubber, with its damping in proportion."""
        return replace(self, stiffness=factor * self.stiffness, damping=factor * self.damping)

    @property
    def apparent_mass(self) -> float:
        """What a short blow feels [kg]: 1/(r M^-1 r) of joints that all give way."""
        return 1.0 / float(self.levers @ np.linalg.solve(self.inertia, self.levers))

    @property
    def locked_mass(self) -> float:
        """The same of a rod [kg] whose joints are locked but for the first."""
        return float(self.inertia[0, 0] / self.levers[0] ** 2)

    @property
    def tip_stiffness(self) -> float:
        """Force over way at rest [N/m] where it is struck."""
        return 1.0 / float(self.levers @ (self.levers / self.stiffness))


def finger_of(hand: HandDescription, place: float, segments: int) -> Finger:
    """The only finger of a hand, straight, struck at a share `place` [-] of its length."""
    layout = build_layout(hand, segments, load_model("base"))
    links, placed = layout.links(0.0), not_placed(len(layout.mass))
    place_links(layout.rest, links, placed)
    columns = []
    for unit in np.eye(3 * len(layout.mass)):
        columns.append(np.empty((len(layout.mass), 3)))
        inertial_torque(unit.reshape(-1, 3), links, placed, columns[-1])
    bends = slice(BEND_COLUMN, None, 3)
    inertia = np.array([column.ravel() for column in columns])[bends, bends]
    length = next(iter(hand.chains[0].actuators.values())).length
    joints = np.cumsum(layout.offset[:, 2])
    stiffness = layout.stiffness[:, BEND_COLUMN]
    levers = np.maximum(place * length - (joints - joints[0] + length / segments / 2.0), 0.0)
    return Finger(inertia, stiffness, layout.damping_time * stiffness, levers)


@dataclass(frozen=True)
class Blow:
    """Course of a blow: time (k,) [s], force (k,) [N], speeds (k,) [m/s] of ball and struck place;
    energies (k,) [J] of the ball, in the skin, moving and elastic in the finger, and lost in it.
    """

    time: Array
    force: Array
    ball: Array
    place: Array
    energies: dict[str, Array]

    @property
    def follows_after(self) -> float:
        """When the struck place first moves as fast as the ball [s]; infinite if it never does."""
        met = np.flatnonzero((self.place >= self.ball) & (self.time > 0.0) & (self.ball > 0.0))
        return float(self.time[met[0]]) if len(met) else float("inf")

    @property
    def balance(self) -> float:
        """Largest change of the sum of all energies, over that at first [-]."""
        total = np.sum(list(self.energies.values()), axis=0)
        return float(np.abs(total / total[0] - 1.0).max())


def strike(finger: Finger, mass: float, speed: float, delay: float = 0.0) -> Blow:
    """A ball [kg] that meets the finger at a speed [m/s]; until a delay [s] has passed the finger
    stands like a wall, as one does whose control has not yet noticed.
    """
    n, rate = len(finger.levers), np.sqrt(SKIN_NORMAL / mass)
    wait = min(delay, np.pi / rate)  # by then a wall has thrown the ball back
    start = np.zeros(2 * n + 3)  # bends, their speeds, way and speed of the ball, energy lost
    start[2 * n] = speed / rate * np.sin(rate * wait)
    start[2 * n + 1] = speed * np.cos(rate * wait)
    inverse = np.linalg.inv(finger.inertia)

    def change(_: float, state: Array) -> Array:
        bend, turning, (way, going) = state[:n], state[n : 2 * n], state[2 * n : 2 * n + 2]
        force = SKIN_NORMAL * max(way - finger.levers @ bend, 0.0)
        braking = finger.damping * turning
        torque = finger.levers * force - finger.stiffness * bend - braking
        lost = float(turning @ braking)
        return np.concatenate([turning, inverse @ torque, [going, -force / mass, lost]])

    time = np.linspace(0.0, LONGEST_BLOW, SAMPLES)
    found = solve_ivp(
        change, (0.0, LONGEST_BLOW), start, "LSODA", time, rtol=EXACT, atol=1e-5 * EXACT
    ).y
    bend, turning = found[:n], found[n : 2 * n]
    way, going, lost = found[2 * n :]
    deep = np.maximum(way - finger.levers @ bend, 0.0)
    energies = {
        "ball": mass * going**2 / 2.0,
        "skin": SKIN_NORMAL * deep**2 / 2.0,
        "moving": np.sum(turning * (finger.inertia @ turning), axis=0) / 2.0,
        "elastic": finger.stiffness @ bend**2 / 2.0,
        "lost": lost,
    }
    before = rate * np.linspace(0.0, wait, 50)[:-1] if wait else np.zeros(0)
    blind = speed * np.sqrt(SKIN_NORMAL * mass) * np.sin(before)
    return Blow(
        np.concatenate([before / rate, time + wait]),
        np.concatenate([blind, SKIN_NORMAL * deep]),
        np.concatenate([speed * np.cos(before), going]),
        np.concatenate([0.0 * before, finger.levers @ turning]),
        {
            name: np.concatenate([_before(name, before, speed, mass), each])
            for name, each in energies.items()
        },
    )


def _before(name: str, angle: Array, speed: float, mass: float) -> Array:
    """Energies [J] while the finger stands like a wall."""
    shares = {"ball": np.cos(angle) ** 2, "skin": np.sin(angle) ** 2}
    return mass * speed**2 / 2.0 * shares.get(name, 0.0 * angle)
