"""Sets with a slip in what the file says, with and without a hidden effect, and controls."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from .hidden import hide
from .rig import Rig, new_rig, outputs, record, write
from .series_faults import exchanged as exchanged_runs
from .series_faults import odd_run
from .truth import Truth

SIZES = {  # usual units: factor to SI
    "pressure": {"kPa": 1e3, "psi": 6894.76, "bar": 1e5, "mbar": 100.0, "mmHg": 133.322},
    "tip_angle": {"deg": np.pi / 180, "rad": 1.0, "turn": 2 * np.pi},
    "tip_force": {"N": 1.0, "gram_force": 9.80665e-3, "pound_force": 4.44822},
    "stress": {"kPa": 1e3, "MPa": 1e6, "psi": 6894.76},
}


def unit(rng: np.random.Generator, rig: Rig) -> Truth:
    """A column's values are in one unit, the file says another that is far off."""
    columns = [c for c in (rig.inputs, rig.output) if c in SIZES]
    column = str(rng.choice(columns))
    names = list(SIZES[column])
    while True:
        real, said = (str(name) for name in rng.choice(names, 2, replace=False))
        factor = SIZES[column][real] / SIZES[column][said]
        if not 0.6 < factor < 1.7:  # nearer ones hide behind the calibration
            break
    rig.units[column] = (said, SIZES[column][real])
    return Truth(f"unit of {column}", slip="unit", factor=float(factor))


def _rewrite(column: str, change: Callable) -> Callable[[np.random.Generator, Rig], Truth]:
    """A slip that rewrites a column of every run, in SI units; named by the caller."""

    def slip(rng: np.random.Generator, rig: Rig) -> Truth:
        for run in rig.runs:
            run.data[column] = change(run.data[column], run.data)
        return Truth("")

    return slip


def youngs_modulus(rng: np.random.Generator, rig: Rig) -> Truth:
    """Young's modulus where the shear modulus belongs."""
    return _restate(rig, {"shear_modulus": 3.0})


def wall_total(rng: np.random.Generator, rig: Rig) -> Truth:
    """Both walls together where one belongs."""
    return _restate(rig, {"wall": 2.0, "side_wall": 2.0})


def radius(rng: np.random.Generator, rig: Rig) -> Truth:
    """Half the height and the width."""
    return _restate(rig, {"height": 0.5, "width": 0.5})


def _restate(rig: Rig, factors: dict[str, float]) -> Truth:
    for stated in rig.stated.values():
        for key, factor in factors.items():
            value = np.array(stated[key]) * (factor if np.isscalar(stated[key]) else [1.0, factor])
            stated[key] = value.tolist()
    return Truth("")


def exchanged(rng: np.random.Generator, rig: Rig) -> Truth:
    """The names of two specimens are exchanged in the whole file, or two plugs once."""
    if rng.random() < 0.5:
        return exchanged_runs(rng, rig)
    first, second = list(rig.true)
    rig.true[second] = replace(rig.true[first], wall=rig.true[first].wall * 1.4)
    record(rig, rng)
    rig.stated[second] = dict(rig.stated[first])
    rig.stated[first] = {**rig.stated[first], "wall": round(rig.true[second].wall, 5)}
    return Truth("")


def _wrap(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi


BENDING, FORCE, TENSION = "free_bending", "blocked_tip", "uniaxial"
SLIPS: dict[str, tuple[tuple[str, ...], Callable[[np.random.Generator, Rig], Truth]]] = {
    "unit": ((BENDING, BENDING, FORCE, TENSION), unit),
    "absolute": ((BENDING, FORCE), _rewrite("pressure", lambda p, data: p + 101.3e3)),
    "percent": ((TENSION,), _rewrite("stretch", lambda lam, data: lam * 100)),
    "strain": ((TENSION,), _rewrite("stretch", lambda lam, data: lam - 1)),
    "true_stress": ((TENSION,), _rewrite("stress", lambda y, data: y * data["stretch"])),
    "youngs_modulus": ((BENDING, TENSION), youngs_modulus),
    "radius": ((FORCE,), radius),
    "wall_total": ((BENDING,), wall_total),
    "sign": ((BENDING, FORCE), lambda rng, rig: _rewrite(rig.output, lambda y, _: -y)(rng, rig)),
    "supplement": ((BENDING,), _rewrite("tip_angle", lambda y, data: np.pi - y)),
    "complement": ((BENDING,), _rewrite("tip_angle", lambda y, data: np.pi / 2 - y)),
    "chord": ((BENDING,), _rewrite("tip_angle", lambda y, data: y / 2)),
    "wrapped": ((BENDING,), _rewrite("tip_angle", lambda y, data: _wrap(y))),
    "exchanged": ((BENDING,), exchanged),
    "odd_run": ((BENDING,), odd_run),
}
BESIDE = (  # effects that are hidden beside a slip: none of them is a mere factor
    "angle_offset",
    "viscoelasticity",
    "hysteresis",
    "gent_stiffening",
    "ballooning",
)
BESIDE_TENSION = ("gent_stiffening", "viscoelasticity", "mullins_softening")
BESIDE_FORCE = ("force_offset", "tip_friction", "dead_zone")


def slip_of(seed: int) -> tuple[str, bool]:
    """Name of the slip of a seed, and whether an effect is hidden beside it.

    Each slip comes in turn; every third set is a control without one, whose name is empty. Every
    other round of all slips has a hidden effect as well, and every other control.
    """
    turn = seed // 3 * 2 + seed % 3
    if seed % 3 == 2:
        return "", (seed // 3) % 2 == 1
    return list(SLIPS)[turn % len(SLIPS)], (turn // len(SLIPS)) % 2 == 1


def make(seed: int, folder: Path) -> Truth:
    """Write the set of a seed and return its truth."""
    rng = np.random.default_rng([seed, 3])
    name, with_effect = slip_of(seed)
    experiment = str(rng.choice(SLIPS[name][0])) if name else BENDING
    rig, truth = _rig(rng, experiment, name, with_effect)
    record(rig, rng)
    if name:
        slip = SLIPS[name][1](rng, rig)
        label = " + ".join(part for part in (slip.label or name, *truth.values) if part)
        truth = replace(
            truth, label=label, slip=name, factor=slip.factor, runs=slip.runs, event=slip.event
        )
    write(rig, folder)
    return truth


def _rig(rng, experiment: str, name: str, with_effect: bool) -> tuple[Rig, Truth]:
    few = {"specimens": 2 if name == "exchanged" else 1, "protocols": 2, "repeats": 2}
    if name == "odd_run":
        few["repeats"] = 3
    angle = 4.0 if name == "wrapped" else None
    names = {BENDING: BESIDE, FORCE: BESIDE_FORCE, TENSION: BESIDE_TENSION}[experiment]
    while True:
        rig, truth = new_rig(rng, experiment, peak_angle=angle, **few), Truth("nothing")
        try:
            if with_effect:
                truth = hide(rng, rig, "effect", str(rng.choice(names)))
        except ValueError:  # the effect does not show in this one
            continue
        if name != "wrapped" or max(y.max() for y in outputs(rig, rig.effects)) > np.pi:
            return rig, truth  # an angle that an effect keeps small has nothing to wrap
