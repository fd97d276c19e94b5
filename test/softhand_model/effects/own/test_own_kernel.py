"""A kernel in a user's effect file: compared with the methods on loading, watched in the loops."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from softhand_model.bending.whole_runs import Runs, stress_in_runs
from softhand_model.effects import effects_in_file
from softhand_model.effects.own.guard import EffectError
from softhand_model.effects.stages import SectionShape

EXAMPLE = Path(__file__).parents[4] / "examples" / "effect_with_memory.py"
FILE = """
import numpy as np
from softhand_model.effects import ElasticEffect, Kernel, Parameter, compiled

@compiled
def _act(stress, trial, values, state):
    for lane in range(len(stress)):
        moved = trial.stretch[lane] - state[0, lane]
        if trial.accepted:
            state[0, lane] = trial.stretch[lane]
        stress[lane] += values[0, lane] * moved
        BODY

class Own(ElasticEffect):
    name = "own"
    experiments = frozenset({"uniaxial"})
    parameters = (Parameter("size", "", 0.0, 2.0),)
    has_memory = True
    kernel = KERNEL

    def stress(self, stress, strain, shape, memory, dt):
        return stress + self.values["size"] * (strain.stretch - memory.get("before", 1.0))

    def remember(self, stress, strain, shape, memory, dt):
        memory["before"] = strain.stretch
"""
KERNEL = "Kernel(_act, rest=(1.0,))"


def written(folder, body="pass", kernel=KERNEL):
    path = folder / "own.py"
    path.write_text(FILE.replace("BODY", body).replace("KERNEL", kernel))
    return path


@pytest.mark.parametrize(
    ("body", "kernel", "expected"),
    [
        ("stress[lane] += 1e-3", KERNEL, "class without its kernel, .* in step 1 of"),
        ("pass", "Kernel(_act, rest=(2.0,))", "the stress of the class without its kernel"),
        ("state[1, lane] = 0.0", KERNEL, "IndexError: index 1 is out of bounds"),
        ("str(open)", KERNEL, "expected code that numba can compile"),
        ("pass", "Kernel(_act.py_func)", "act: expected a function with the decorator @compiled"),
    ],
)
def test_what_a_kernel_does_wrong_is_told_before_it_takes_part(tmp_path, body, kernel, expected):
    path = written(tmp_path, body, kernel)
    with pytest.raises(EffectError, match=expected) as told:
        effects_in_file(path)
    assert str(path) in str(told.value) and "\n" not in str(told.value)


def in_runs(effect, stretch):
    """Elastic side [-] of one run of imposed stretches."""
    rows, size = len(stretch), np.zeros((1, 1, 1))
    one = Runs(np.array([0, rows]), np.zeros(rows), np.zeros(1, bool), np.array([-1]))
    shape = SectionShape(size, size, size, size, size, size)
    return stress_in_runs([effect], stretch[None, :, None], shape, one, "uniaxial")[0, :, 0]


def test_numbers_that_become_infinite_in_the_loops_are_told(tmp_path):
    body = "stress[lane] /= 1.0 if trial.stretch[lane] < 2.0 else 0.0"
    effect = effects_in_file(written(tmp_path, body))["own"](size=1.0)
    stretch = np.array([1.0, 1.5, 1.8])
    assert in_runs(effect, stretch) == pytest.approx(
        stretch - stretch**-2.0 + np.diff(stretch, prepend=1.0)
    )
    with pytest.raises(EffectError, match=r"own\.py: Own\.kernel: expected finite numbers"):
        in_runs(effect, np.array([1.0, 2.5]))


def test_a_kernel_that_was_compiled_as_a_module_is_found_again_as_an_effect_file(tmp_path):
    """Numba imports a cached kernel's module by name: there is none of the first name later."""
    shutil.copy(EXAMPLE, tmp_path / "own.py")
    code = "import own; own.FillerFriction.kernel.addresses"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True)
    load = "from softhand_model.effects import effects_in_file as f; f('own.py')"
    for _ in range(2):
        subprocess.run([sys.executable, "-P", "-c", load], cwd=tmp_path, check=True)
