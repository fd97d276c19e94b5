"""Compiled kernels go with the sources, also with those of the kernels that they call."""

import os
import resource
import subprocess
import sys

INNER = """from softhand_common.numerics.compiled import compiled

@compiled
def inner(x):
    return {}
"""
OUTER = """from inner import inner
from softhand_common.numerics.compiled import compiled

@compiled
def outer(x):
    return inner(x)

if __name__ == "__main__":
    import outer as module
    print(module.outer(1.0))
"""


def run(folder):
    done = subprocess.run(
        [sys.executable, "outer.py"], cwd=folder, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def test_a_kernel_is_compiled_anew_when_one_that_it_calls_has_changed(tmp_path):
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format("x + 1.0"))
    assert run(tmp_path) == 2.0
    (tmp_path / "inner.py").write_text(INNER.format("x + 10.0"))
    assert run(tmp_path) == 11.0


TOLD = """from softhand_common.numerics.compiled import compilation_announced
import outer

said = []
with compilation_announced(said.append):
    outer.outer(1.0)
    outer.outer(2)
print(said)
"""


def test_it_is_told_once_before_what_is_not_cached_is_compiled(tmp_path):
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format("x + 1.0"))
    (tmp_path / "told.py").write_text(TOLD)
    said = [
        subprocess.run(
            [sys.executable, "told.py"], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout.strip()
        for _ in range(2)
    ]
    assert said[0].count("compiling the numerical kernels") == 1
    assert said[1] == "[]"


def test_kernels_that_cannot_be_kept_are_computed_with_and_their_folder_is_named(tmp_path):
    (tmp_path / "outer.py").write_text(OUTER)
    (tmp_path / "inner.py").write_text(INNER.format("x + 1.0"))
    done = subprocess.run(
        [sys.executable, "outer.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)),
    )
    assert (done.returncode, done.stdout) == (0, "2.0\n")
    assert done.stderr.count("expected room for compiled kernels, got File too large") == 1
    assert f"{tmp_path}/__pycache__: " in done.stderr and "NUMBA_CACHE_DIR" in done.stderr
    assert not list(tmp_path.glob("__pycache__/*.nb*"))


OF_TYPE = """from {module} import Pair
from softhand_common.numerics.compiled import compiled

@compiled
def outer(pair):
    return pair.a

if __name__ == "__main__":
    import outer as module
    print(module.outer(Pair({value})))
"""


def test_a_kernel_kept_for_a_type_that_has_been_moved_is_compiled_anew(tmp_path):
    source = "from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    a: float\n"
    for module, value in (("first", 1.0), ("second", 2.0)):
        (tmp_path / f"{module}.py").write_text(source)
        (tmp_path / "outer.py").write_text(OF_TYPE.format(module=module, value=value))
        assert run(tmp_path) == value
        (tmp_path / f"{module}.py").unlink()
