"""Elastic effects with memory: softening, relaxation and hysteresis of the rubber."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import RUBBER, Parameter
from softhand_model.effects.kernel import Kernel, Trial
from softhand_model.effects.lags import lags_kernel
from softhand_model.effects.stages import ElasticEffect, Memory, SectionShape, Strain, decay

MODES, DECADES = 10, 5.0  # lags of creep, and the decades of time over which they are spread
# rates v of these lags over that of the onset, and their shares exp(-v) of the logarithm's width
RATES = np.geomspace(10.0 ** (0.5 - DECADES), 10.0**0.5, MODES)
WEIGHTS = np.exp(-RATES) * np.log(RATES[1] / RATES[0])


@compiled
def softened(below: Any, softening: Any, scale: Any) -> Any:
    """Factor [-] 1 - softening*(1 - exp(-below/scale)) at a stretch that is `below` [-] under the
    largest one so far.
    """
    return 1.0 + softening * np.expm1(-below / scale)


LARGEST = 0  # row of its state


@compiled
def _soften(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        stretch = trial.stretch[lane]
        below = state[LARGEST, lane] - stretch
        if below > 0.0:
            stress[lane] *= softened(below, values[0, lane], values[1, lane])
        elif trial.accepted:
            state[LARGEST, lane] = stretch


class MullinsSoftening(ElasticEffect):
    """Softening below the largest stretch so far (Mullins effect): factor 1 - softening*(1 -
    exp(-(lam_max - lambda)/stretch_scale)).

    The largest stretch belongs to the specimen, not to the run. (L. Mullins.)
    """

    name = "mullins_softening"
    experiments = RUBBER
    parameters = (
        Parameter(
            "softening",
            "",
            0.0,
            0.95,
            "share of the stress that is lost far below the largest stretch",
            (0.05, 0.5),
            neutral=0.0,
        ),
        Parameter(
            "stretch_scale",
            "",
            0.005,
            10.0,
            "distance from the largest stretch over which it is lost",
            (0.05, 1.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "hysteresis": "both part loading from unloading: small loops after large ones tell"
    }
    has_memory = True
    largest: ClassVar[Mapping[str, float]] = {"largest_stretch": 1.0}
    kernel = Kernel(_soften)

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) times the factor."""
        below = np.maximum(memory.get("largest_stretch", 1.0) - strain.stretch, 0.0)
        values = self.values
        return stress * softened.py_func(below, values["softening"], values["stretch_scale"])

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Store the largest stretch."""
        before = memory.get("largest_stretch", 1.0)
        memory["largest_stretch"] = np.maximum(strain.stretch, before)


class Viscoelasticity(ElasticEffect):
    """Standard linear solid (Zener): nu' = -nu/tau + g*Q', where nu is added to the elastic stress
    Q.

    The shear modulus is the relaxed one; under sudden stretch the rubber is 1 + g times as stiff. Q
    is the stress after the stiffening factors. The solution is exact for a stress that is linear
    over a step.
    """

    name = "viscoelasticity"
    cause, member = "relaxation", "one relaxation time"
    experiments = RUBBER
    parameters = (
        Parameter(
            "relative_modulus",
            "",
            0.0,
            5.0,
            "modulus of the part that relaxes, over the relaxed one",
            (0.03, 0.6),
            neutral=0.0,
        ),
        Parameter(
            "relaxation_time",
            "s",
            1e-3,
            1e4,
            "time in which that part relaxes",
            (0.1, 60.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate; steps and rates tell them apart",
    }
    has_memory = True
    adds = True
    kernel = lags_kernel(1)
    _decay: tuple[Array | float, Array, Array] | None = None

    def kernel_values(self) -> list[Array]:
        """Rows for `lags.lags_kernel`: share of the stress that acts at once, weight and time
        constant [s] of the lag.
        """
        modulus, time = super().kernel_values()
        return [np.ones(1), modulus, time]

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) plus the part that has not relaxed yet."""
        return stress + self._overstress(stress, memory, dt)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Store the part that has not relaxed, and the stress."""
        memory["state"] = self._overstress(stress, memory, dt), stress

    def _overstress(self, stress: Array, memory: Memory, dt: Array | float) -> Array:
        over, before = memory.get("state", (0.0, 0.0))
        if self._decay is None or self._decay[0] is not dt:  # the same in all calls of a step
            self._decay = dt, *decay(dt, self.values["relaxation_time"])
        _, left, share = self._decay
        return left * over + self.values["relative_modulus"] * share * (stress - before)


class Creep(ElasticEffect):
    """Logarithmic creep: the modulus falls by `rate` of itself with every decade of time.

    The stress is Q(t) - rate*int(log10(1 + (t - u)/onset_time)*dQ(u)), Boltzmann's superposition; Q
    is the stress after the stiffening factors, G the modulus under sudden stretch. log(1 + x), the
    integral over v of (1 - exp(-x*v))*exp(-v)/v, is computed as a sum of MODES lags over DECADES of
    time. Under a constant load the stretch grows without end, while with `viscoelasticity` it comes
    to rest.
    """

    name = "creep"
    cause, member = "relaxation", "many relaxation times"
    experiments = RUBBER
    parameters = (
        Parameter(
            "rate",
            "",
            0.0,
            0.15,
            "share of the modulus that is lost with every decade of time",
            (0.01, 0.1),
            neutral=0.0,
        ),
        Parameter(
            "onset_time",
            "s",
            1e-3,
            100.0,
            "time after which it shows",
            (0.02, 2.0),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "viscoelasticity": "alike over a decade of time, within which that relaxes",
        "tube_lag": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate; steps and rates tell them apart",
    }
    has_memory = True
    endless = True
    adds = True
    rank = 0
    kernel = lags_kernel(MODES)
    _decay: tuple[Array | float, Array, Array] | None = None

    def kernel_values(self) -> list[Array]:
        """Rows for `lags.lags_kernel`: share of the stress that acts at once, weights and time
        constants [s] of the lags.
        """
        rate, onset = super().kernel_values()
        share = rate / np.log(10.0)
        weights = [share * weight for weight in WEIGHTS]
        return [1.0 - share * WEIGHTS.sum(), *weights, *(onset / rate for rate in RATES)]

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) less the part that has crept away."""
        rate = self.values["rate"] / np.log(10.0)
        return stress - rate * np.sum(self._crept(stress, memory, dt) * WEIGHTS, axis=-1)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Store the lagging stresses, and the stress."""
        memory["state"] = self._crept(stress, memory, dt), stress

    def _crept(self, stress: Array, memory: Memory, dt: Array | float) -> Array:
        """What lags behind the stress (..., MODES)."""
        follows, before = memory.get("state", (0.0, 0.0))
        if self._decay is None or self._decay[0] is not dt:  # the same in all calls of a step
            steps = np.asarray(dt, float)[..., None]
            constants = np.asarray(self.values["onset_time"])[..., None] / RATES
            self._decay = dt, *decay(steps, constants)
        _, left, share = self._decay
        now, then = np.asarray(stress)[..., None], np.asarray(before)[..., None]
        return now - share * (now - then) + left * (follows - then)


@compiled
def friction(moved: Any, turned: Any, scale: Any) -> Any:
    """Friction w [-] after a motion, given that before it."""
    towards = np.sign(moved)
    return towards + (turned - towards) * np.exp(-np.abs(moved) / scale)


TURNED, BEFORE = 0, 1  # rows of its state: w and the stretch


@compiled
def _rub(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    for lane in range(len(stress)):
        stretch = trial.stretch[lane]
        turned = friction(stretch - state[BEFORE, lane], state[TURNED, lane], values[1, lane])
        stress[lane] += values[0, lane] * turned
        if trial.accepted:
            state[TURNED, lane], state[BEFORE, lane] = turned, stretch


class Hysteresis(ElasticEffect):
    """Rate-independent friction: s_c*w is added to the stress, with dw = (sign(dlambda) -
    w)*abs(dlambda)/stretch_scale.

    This is the model of Duhem and Dahl, exact for any step in one direction. In section 5.2.4 it
    amounts to 1 to 2 mm at the tip.
    """

    name = "hysteresis"
    experiments = RUBBER
    parameters = (
        Parameter(
            "relative_pressure",
            "",
            0.0,
            3.0,
            "half the height of the loop in units of the load s",
            (0.02, 0.4),
            neutral=0.0,
        ),
        Parameter(
            "stretch_scale",
            "",
            1e-3,
            5.0,
            "stretch over which the friction turns",
            (0.01, 0.3),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "viscoelasticity": "alike on triangles of one rate",
        "tube_lag": "alike on triangles of one rate",
        "mullins_softening": "both part loading from unloading",
    }
    has_memory = True
    adds = True
    rank = 1
    kernel = Kernel(_rub, rest=(0.0, 1.0))

    def stress(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> Array:
        """Stress [-] (divided by the shear modulus) plus the friction s_c*w."""
        return stress + self.values["relative_pressure"] * self._turned(strain.stretch, memory)

    def remember(
        self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Array | float
    ) -> None:
        """Store w and the stretch."""
        memory["state"] = self._turned(strain.stretch, memory), strain.stretch

    def _turned(self, stretch: Array, memory: Memory) -> Array:
        turned, before = memory.get("state", (0.0, 1.0))
        return np.asarray(friction.py_func(stretch - before, turned, self.values["stretch_scale"]))
