"""The lab beside `mujoco.sysid` on the same hands: `python -m bench.hands.beside_sysid`.

Both are told which effect is hidden, and where, and fit its one parameter together with the modulus
of all rubber. The data are poses of the hand in MuJoCo. `mujoco.sysid` fits with that same engine,
hand, segments and step, so it has no error of the model; the lab fits with its own statics. Printed
for each: the error of the parameter, and the processor time [s].

Plan and criterion, fixed before the first run: the kinds of `KINDS`, strong, seeds from `SEED`. Met
if the sum over the cases of the lab's errors, each over the hidden size, is at most 1.5 times that
of `mujoco.sysid`. Negative control: with an effect at another place, the lab's fit must leave more
than twice the error that it leaves at the right one. Needs `pip install 'mujoco-core[sysid]'`.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import model_lab as lab
from bench.command_line import command_line
from bench.hands.cases import Hidden, hidden_in
from bench.hands.measure import HAND, STEP, measured, poses
from bench.row import at_least, at_most
from model_lab.measurements.measurement_set import MeasurementSet
from pneuflex_sim.engines import MUJOCO
from softhand_common.numerics.arrays import Array
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import HandEffect
from softhand_model.hand.hand import load_hand

SEED = 7700
KINDS = {  # the parameter's name, its value without the effect, and bounds for the fit
    "crosstalk": ("share", 0.0, (0.0, 0.6)),
    "actuator_scatter": ("modulus_factor", 1.0, (0.3, 3.0)),
    "palm_stiffness": ("factor", 1.0, (0.2, 3.0)),
}
SCALES = (0.7, 1.4)  # bounds of the factor on the modulus
MOST, LEAST_ELSEWHERE = 1.5, 2.0  # times the error of mujoco.sysid, and of the right place
ITERATIONS, DIFFERENCE = 8, 0.02  # steps of mujoco.sysid at the most; of its finite differences


def run(kinds: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of kinds of effects: the sum of relative errors of the lab over
    that of mujoco.sysid, and the negative control.
    """
    print("| hidden | value | lab | s | mujoco.sysid | s | at another place, times the error |")
    print("|---|---|---|---|---|---|---|")
    errors, elsewhere = [], []
    for number, kind in enumerate(KINDS):
        if kind not in kinds:
            continue
        random = np.random.default_rng(SEED + number)
        hidden = hidden_in(load_hand(HAND), kind, "strong", random)
        data = measured(hidden, random, engine=MUJOCO)
        ours, took, other = _by_lab(hidden, data)
        elsewhere.append(other)
        theirs, their_time = _by_sysid(hidden, data)
        value = float(hidden.value or 0.0)
        size = abs(value - KINDS[kind][1])
        errors.append([abs(found - value) / size for found in (ours, theirs)])
        place = ">".join(hidden.where.values())
        print(
            f"| {kind} {place} | {value:.3f} | {ours:.4f} | {took:.0f} "
            f"| {theirs:.4f} | {their_time:.0f} | {other:.1f} |",
            flush=True,
        )
    lab_sum, their_sum = np.sum(errors, axis=0)
    name = "error of a told parameter, over that of mujoco.sysid"
    control = "negative control: error left with the effect at another place, over the right one"
    return [
        at_most(name, lab_sum / their_sum, "", MOST),
        at_least(control, np.nanmin(elsewhere), "", LEAST_ELSEWHERE),
    ]


def _by_lab(hidden: Hidden, data: MeasurementSet) -> tuple[float, float, float]:
    """Parameter, processor time [s] and error left at another place over that at the right one."""
    begun = time.process_time()
    fitted = lab.add(_named(hidden.name, hidden.where), data, "gravity")
    took = time.process_time() - begun
    addition = fitted.additions[-1]
    value = float(addition.effect.parameters[KINDS[hidden.name][0]].value)
    places = _kind(hidden.name).places(load_hand(HAND))
    others = [at for at in places if at != hidden.where]
    if not others:
        return value, took, np.nan
    other = lab.add(_named(hidden.name, others[0]), data, "gravity")
    return value, took, other.errors[-1] / fitted.errors[-1]


def _kind(name: str) -> type[HandEffect]:
    found = effect_classes()[name]
    if not issubclass(found, HandEffect):
        raise TypeError(f"{name}: expected an effect of a hand")
    return found


def _named(kind: str, where: dict[str, str]) -> str:
    return f"{kind}[{'>'.join(where.values())}]" if where else kind


def _by_sysid(hidden: Hidden, data: MeasurementSet) -> tuple[float, float]:
    """Parameter and processor time [s] of a fit by mujoco.sysid, in the engine of the data."""
    # here, as the extra `sysid` of mujoco-core is not installed with this project
    from mujoco.sysid import Parameter, ParameterDict, optimize

    name, neutral, bounds = KINDS[hidden.name]
    plain = Hidden(load_hand(HAND), hidden.name, "")
    kind = _kind(hidden.name)
    kind = kind.at(**hidden.where) if hidden.where else kind

    def residual(x: Array, known: Any) -> tuple[list[Array], None, None]:
        scale, value = np.asarray(x, float).ravel()
        acting = replace(plain, effects=(kind(**{name: value}),))
        left = []
        for protocol in dict.fromkeys(run.protocol for run in data.runs):
            runs = [run for run in data.runs if run.protocol == protocol]
            read = np.mean([[run.columns[key] for key in data.inputs] for run in runs], axis=0).T
            seen = np.mean([[run.columns[key] for key in data.outputs] for run in runs], axis=0)
            found = poses(acting, read, runs[0].wrist_rpy, scale, MUJOCO, STEP)
            left.append((found.transpose(1, 2, 0).reshape(seen.shape) - seen).ravel())
        return left, None, None

    start = ParameterDict(
        {
            "modulus_scale": Parameter("modulus_scale", 1.0, *SCALES),
            name: Parameter(name, neutral, *bounds),
        }
    )
    start.move_off_bounds()
    begun = time.process_time()
    with contextlib.redirect_stdout(sys.stderr):  # its steps
        found, _ = optimize(
            start, residual, "scipy", verbose=False, max_iters=ITERATIONS, diff_step=DIFFERENCE
        )
    return float(found[name].value[0]), time.process_time() - begun


if __name__ == "__main__":
    parser = command_line("bench.hands.beside_sysid", __doc__)
    parser.add_argument("kinds", nargs="*", default=list(KINDS), help="default: %(default)s")
    for row in run(parser.parse_args().kinds):
        print(f"{row['name']}: {row['value']:.2f} (target {row['target']})")
