"""Source archives and wheels of all packages: they install into an empty environment and run there.

Third-party libraries are lent from the environment of the tests; packages of the suite are not, as
those are installed there in place.
"""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.parent.name for path in (ROOT / "src").glob("*/setup.py"))
pytestmark = pytest.mark.timeout(600)


def run(*command, **options):
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "COLCON")}
    words = list(map(str, command))
    done = subprocess.run(words, env=clean, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """A wheel of each package, built from its source archive."""
    folder = tmp_path_factory.mktemp("dist")
    for name in PACKAGES:
        source = folder / "src" / name
        unwanted = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
        shutil.copytree(ROOT / "src" / name, source, ignore=unwanted)
        run(sys.executable, "setup.py", "-q", "sdist", "-d", folder / "sdist", cwd=source)
    archives = sorted((folder / "sdist").iterdir())
    options = ("--no-deps", "--no-build-isolation", "--no-index", "-q", "-w", folder / "wheels")
    run(sys.executable, "-m", "pip", "wheel", *options, *archives)
    return sorted((folder / "wheels").iterdir())


@pytest.fixture(scope="module")
def environment(wheels, tmp_path_factory):
    """The programs of a new environment with the wheels."""
    folder = tmp_path_factory.mktemp("empty")
    run(sys.executable, "-m", "venv", folder)
    bin = folder / "bin"
    options = ("--no-deps", "--no-index", "-q", "--disable-pip-version-check")
    run(bin / "python", "-m", "pip", "install", *options, *wheels)
    place = "import sysconfig; print(sysconfig.get_path('purelib'))"
    lent = Path(run(bin / "python", "-c", place).strip()) / "lent.pth"
    lent.write_text(sysconfig.get_path("purelib") + "\n")
    return bin


def test_every_package_has_a_wheel_of_its_own_version(wheels):
    assert sorted(path.name.split("-")[0] for path in wheels) == PACKAGES


def test_packages_come_from_the_new_environment(environment):
    imports = "; ".join(f"import {name}; print({name}.__file__)" for name in PACKAGES)
    for line in run(environment / "python", "-c", imports).splitlines():
        assert line.startswith(str(environment.parent)) or "pybullet" in line


def test_a_grasp_runs_from_the_wheels(environment, tmp_path):
    out = tmp_path / "trials.json"
    run(
        environment / "softhand",
        "trials",
        "--seeds",
        1,
        "--step",
        0.005,
        "--out",
        out,
        cwd=tmp_path,
    )
    assert json.loads(out.read_text())["count"] == 1


def test_the_lab_compares_from_the_wheels(environment, tmp_path):
    data = shutil.copytree(ROOT / "examples" / "measurements" / "finger", tmp_path / "finger")
    out = tmp_path / "compared.json"
    run(environment / "model-lab", "compare", data, "--model", "base", "--json", out, cwd=tmp_path)
    assert json.loads(out.read_text())
