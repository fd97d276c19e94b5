"""Rehearsal of a user's effect file, in a process of its own: every method is called once, and
kernels are compared with the methods.

`own_file` starts it; a file that ends or blocks its process does so here.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_model.effects.catalogue import STAGE_CLASSES
from softhand_model.effects.effect import Effect
from softhand_model.effects.own.guard import effect_errors, own_methods
from softhand_model.effects.own.kernel_check import check_kernel
from softhand_model.effects.own.own_file import THROUGH, load_guarded
from softhand_model.effects.stages import FlowEffect, Pulse, SectionShape, Strain

REHEARSED_LANES, REHEARSED_ROWS, REHEARSED_SECTIONS = 2, 3, 4  # of the arrays in a rehearsal


def _rehearse(path: Path) -> None:
    """Call every method that the effects of a file have of their own, and their kernels."""
    for effect in load_guarded(path).values():
        start = {parameter.name: parameter.usual() for parameter in effect.parameters}
        with effect_errors(f"{path}: {effect.__name__}"):
            single = effect(**start)
        _call_methods(single)
        _call_methods(
            effect.in_lanes({name: [value] * REHEARSED_LANES for name, value in start.items()})
        )
        check_kernel(effect)


def _call_methods(effect: Effect) -> None:
    of_stage = next(base for base in STAGE_CLASSES if isinstance(effect, base))
    samples = _pulse_samples() if of_stage is FlowEffect else _samples()
    memory = dict(getattr(effect, "largest", {}))
    for name in own_methods(type(effect), of_stage):
        asked = _arguments(getattr(of_stage, name))
        getattr(effect, name)(*(memory if key == "memory" else samples[key] for key in asked))


def _arguments(method: Any) -> list[str]:
    return list(method.__code__.co_varnames[1 : method.__code__.co_argcount])


def _samples() -> dict[str, Any]:
    """Plausible arguments by name: a soft finger at 20 kPa."""

    def rows(value: float) -> Array:
        return np.full((REHEARSED_LANES, REHEARSED_ROWS, 1), value)

    def sections(value: float) -> Array:
        return np.full((REHEARSED_LANES, REHEARSED_ROWS, REHEARSED_SECTIONS), value)

    shape = SectionShape(
        rows(0.02), rows(0.02), rows(0.0025), rows(0.0025), sections(1.0), rows(67e3)
    )
    return {
        "pressure": rows(20e3),
        "temperature": rows(293.15),
        "elapsed": rows(0.5),
        "runs": rows(3.0),
        "load": sections(0.3),
        "stress": sections(0.3),
        "strain": Strain(sections(1.1)),
        "shape": shape,
        "curvature": sections(10.0),
        "bend": sections(0.2),
        "rest": sections(0.3),
        "force": rows(0.1),
        "value": rows(0.5),
        "dt": np.full((REHEARSED_ROWS, 1), 0.01),
    }


def _pulse_samples() -> dict[str, Any]:
    """Pulses of 20 ms: an inflation, a deflation, an inflation."""
    pulses = np.ones((1, REHEARSED_ROWS))
    pulse = Pulse(
        inflating=np.array([[True, False, True]]),
        duration=0.02 * pulses,
        p_in=300e3 * pulses,
        p_out=120e3 * pulses,
        friction_integral=5e3 * pulses,
        injector_integral=5e3 * pulses,
        naive=5e-6 * pulses,
    )
    return {"pulse": pulse, "mass": 5e-6 * pulses, "pressure_abs": np.full(REHEARSED_ROWS, 120e3)}


def main(path: str, writer: str) -> None:
    """Rehearse the effects of a file; errors are written to the file descriptor with the number
    `writer`.
    """
    try:
        _rehearse(Path(path))
        verdict = THROUGH
    except ValueError as reason:
        verdict = str(reason)
    with os.fdopen(int(writer), "w", encoding="utf-8") as said:
        said.write(verdict)


if __name__ == "__main__":
    main(*sys.argv[1:])
