"""An effect of one's own that has a memory, with a kernel that makes it fast in the lab: friction
among the particles of a filler, as many small sliders (W. D. Iwan, J. Appl. Mech. 33, 1966).

The methods `stress` and `remember` are all that is needed; the kernel does the same for the
compiled loops of the lab. A file of an effect is loaded faster if it imports little: tests of this
one are in `test/model_lab/test_effect_with_memory.py`. `python examples/effect_with_memory.py`
prints a loop, and `python -m bench.effects` measures what the kernel saves.
"""

import numpy as np

from softhand_model.effects import ElasticEffect, Kernel, Parameter, compiled

SLIDERS = 10
YIELDS = (np.arange(SLIDERS) + 0.5) / SLIDERS  # where each slips, over the largest slip stretch


@compiled
def _slide(stress, trial, values, state):
    """The same as the methods below, in loops: rows of values are the parameters, rows of state
    what each slider is stretched by, and the stretch.
    """
    for lane in range(len(stress)):
        moved = trial.stretch[lane] - state[SLIDERS, lane]
        total = 0.0
        for slider in range(SLIDERS):
            most = YIELDS[slider] * values[1, lane]
            held = min(max(state[slider, lane] + moved, -most), most)
            total += held
            if trial.accepted:
                state[slider, lane] = held
        if trial.accepted:
            state[SLIDERS, lane] = trial.stretch[lane]
        stress[lane] += values[0, lane] * 2.0 * total / (SLIDERS * values[1, lane])


class FillerFriction(ElasticEffect):
    """Sliders side by side, which slip at stretches evenly spread from 0 to slip_stretch.

    Each is stretched with the rubber until it slips. From rest the stress of all together is
    relative_pressure*u*(2 - u), u the stretch over slip_stretch, up to u = 1; after each turn it
    follows that curve twice as large, so small loops within a large one close.
    """

    name = "filler_friction"
    experiments = frozenset({"free_bending", "blocked_tip", "base_torque", "uniaxial", "rubber"})
    parameters = (
        Parameter(
            "relative_pressure",
            "",
            0.0,
            3.0,
            "stress when all slip, in units of the load s",
            typical=(0.02, 0.4),
            neutral=0.0,
        ),
        Parameter(
            "slip_stretch",
            "",
            1e-3,
            5.0,
            "stretch at which the last one slips",
            typical=(0.02, 0.5),
            logarithmic=True,
        ),
    )
    has_memory = True
    adds = True
    rank = 1
    kernel = Kernel(_slide, rest=(*np.zeros(SLIDERS), 1.0))

    def stress(self, stress, strain, shape, memory, dt):
        """Stress [-] with the friction."""
        total = np.sum(self._held(strain, memory), axis=-1)
        share = 2.0 * total / (SLIDERS * self.values["slip_stretch"])
        return stress + self.values["relative_pressure"] * share

    def remember(self, stress, strain, shape, memory, dt):
        """Keep what each slider is stretched by, and the stretch."""
        memory["state"] = self._held(strain, memory), strain.stretch

    def _held(self, strain, memory):
        """What each slider is stretched by (..., SLIDERS)."""
        held, before = memory.get("state", (0.0, 1.0))
        moved = np.asarray(strain.stretch - before)[..., None]
        most = YIELDS * np.asarray(self.values["slip_stretch"])[..., None]
        return np.clip(held + moved, -most, most)


if __name__ == "__main__":
    from softhand_model.chain.chain import discretise
    from softhand_model.hand.hand import load_hand
    from softhand_model.model_file import Model

    effect = FillerFriction(relative_pressure=0.2, slip_stretch=0.1)
    chain = discretise(load_hand("single_finger").chain("finger"), 5, Model(effects=(effect,)))
    for pressure in (0, 20e3, 40e3, 20e3, 0):
        angle = np.degrees(chain.step(0.1, [pressure], np.zeros((5, 3)))[:, 1].sum())
        print(f"{pressure / 1e3:4.0f} kPa: the finger is bent by {angle:5.1f} deg")
