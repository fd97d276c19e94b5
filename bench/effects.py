"""What the kernels of effects save: time of the lab's predictions with and without (`python -m
bench.effects`).

Each effect with memory predicts free bending, 8 trial values of 12 runs with 200 samples, with its
kernel and without, in turn. The effect of `examples/effect_with_memory.py` is one of them.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

from bench.command_line import command_line
from model_lab.bench.synthesize import EMPTY
from model_lab.experiments.forward import Forward
from softhand_model.effects import Effect, effect_classes, effects_in_file

OWN = Path(__file__).parents[1] / "examples" / "effect_with_memory.py"
LANES, ROUNDS = 8, 5
YARDSTICK = "hysteresis"  # the built-in effect to which one of a user's own is compared


def main() -> None:
    """Print a line for each effect."""
    command_line("bench.effects", __doc__).parse_args()
    with tempfile.TemporaryDirectory(prefix="bench-effects-") as folder:
        file, started = Path(shutil.copy(OWN, folder)), time.perf_counter()
        effects_in_file(file)
        print(f"{OWN.name}: loaded in {time.perf_counter() - started:.1f} s for the first time")
    started, own = time.perf_counter(), effects_in_file(OWN)
    print(f"{OWN.name}: loaded in {time.perf_counter() - started:.1f} s, compiled before")
    built_in = {name: effect for name, effect in effect_classes().items() if effect.has_memory}
    with_kernel = {n: e for n, e in {**built_in, **own}.items() if e.kernel is not None}
    compiled: dict[str, list[float]] = {name: [] for name in with_kernel}
    plain: dict[str, list[float]] = {name: [] for name in with_kernel}
    for _ in range(ROUNDS):
        for name, effect in with_kernel.items():
            compiled[name].append(seconds(predictions(effect), 10))
            plain[name].append(seconds(predictions(without_kernel(effect)), 1))
    for name in with_kernel:
        fast, slow = median(compiled[name]), median(plain[name])
        beside = fast / median(compiled[YARDSTICK])
        print(
            f"{name}: {1e3 * fast:.2f} ms with its kernel ({beside:.2f} times {YARDSTICK}), "
            f"{1e3 * slow:.0f} ms without, {slow / fast:.0f} times as long"
        )


def without_kernel(effect: type[Effect]) -> type[Effect]:
    """The same effect in Python alone."""
    return type(effect.__name__, (effect,), {"kernel": None})


def predictions(effect: type[Effect]) -> Callable[[], object]:
    """A call that predicts free bending with usual values of the effect's parameters."""
    forward = Forward(EMPTY["free_bending"](np.random.default_rng(0)), effects=[effect])
    shares = np.linspace(0.2, 0.8, LANES)
    values = [[1.0, *(p.usual(share) for p in effect.parameters)] for share in shares]
    forward.predict(np.array(values))
    return lambda: forward.predict(np.array(values))


def seconds(call: Callable[[], object], times: int) -> float:
    """Time [s] of this process in a call, as a mean of so many."""
    started = time.process_time()
    for _ in range(times):
        call()
    return (time.process_time() - started) / times


if __name__ == "__main__":
    main()
