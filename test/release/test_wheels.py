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
import tarfile
from pathlib import Path

import pytest
from ros_domain import held_domain

from bench.hidden import make_set

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.parent.name for path in (ROOT / "src").glob("*/setup.py"))
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")

# The hooks by which pip builds, without a new process for each.
BUILD = """
import os, sys
from setuptools.build_meta import __legacy__ as setuptools
hook, out, *sources = sys.argv[1:]
for source in sources:
    os.chdir(source)
    getattr(setuptools, hook)(out)
"""

FIRST_STEP = """
import time
import numpy as np
import rclpy
from pneuflex_sim.ros.node import HandSim
rclpy.init()
simulation = HandSim().simulation
begin = time.process_time()
simulation.read_sensors()
simulation.step(np.ones(4))
print("first step:", time.process_time() - begin, flush=True)
rclpy.shutdown()
"""


def run(*command, variables=(), **options):
    """Standard output and standard error of a command that succeeds."""
    unwanted = ("PYTHONPATH", "COLCON", "NUMBA_CACHE_DIR")
    clean = {k: v for k, v in os.environ.items() if k not in unwanted} | dict(variables)
    words = list(map(str, command))
    done = subprocess.run(words, env=clean, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout, done.stderr


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """A wheel of each package, built from its source archive."""
    folder = tmp_path_factory.mktemp("dist")
    unwanted = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
    for name in PACKAGES:
        shutil.copytree(ROOT / "src" / name, folder / "src" / name, ignore=unwanted)
    sources = [folder / "src" / name for name in PACKAGES]
    run(sys.executable, "-c", BUILD, "build_sdist", folder / "sdist", *sources)
    for archive in (folder / "sdist").iterdir():
        with tarfile.open(archive) as packed:
            packed.extractall(folder / "unpacked", filter="data")
    unpacked = sorted((folder / "unpacked").iterdir())
    run(sys.executable, "-c", BUILD, "build_wheel", folder / "wheels", *unpacked)
    return sorted((folder / "wheels").glob("*.whl"))


@pytest.fixture(scope="module")
def environment(wheels, tmp_path_factory):
    """The programs of a new environment with the wheels."""
    folder = tmp_path_factory.mktemp("empty")
    run(sys.executable, "-m", "venv", "--without-pip", folder)
    bin = folder / "bin"
    options = ("--no-deps", "--no-index", "-q", "--no-compile")
    run(*PIP, "--python", bin / "python", "install", *options, *wheels)
    place = "import sysconfig; print(sysconfig.get_path('purelib'))"
    lent = Path(run(bin / "python", "-c", place)[0].strip()) / "lent.pth"
    lent.write_text(sysconfig.get_path("purelib") + "\n")
    return bin


def test_every_package_has_a_wheel_of_its_own_version(wheels):
    assert sorted(path.name.split("-")[0] for path in wheels) == PACKAGES


def test_packages_come_from_the_new_environment(environment):
    imports = "; ".join(f"import {name}; print({name}.__file__)" for name in PACKAGES)
    for line in run(environment / "python", "-c", imports)[0].splitlines():
        assert line.startswith(str(environment.parent)) or "pybullet" in line


# The next tests use the kernels that the first of them compiles.
def test_a_first_start_compiles_before_the_first_sample(environment, tmp_path):
    """A pause of seconds between two samples looks like a dead simulator, and the driver vents."""
    before = set(environment.parent.rglob("*.nbi"))
    assert not before, "kernels had been compiled before the first start"
    with held_domain() as domain:
        of_ros = {"ROS_DOMAIN_ID": str(domain), "ROS_LOG_DIR": str(tmp_path)}
        out, err = run(environment / "python", "-c", FIRST_STEP, variables=of_ros)
    assert list(environment.parent.rglob("*.nbi")), "nothing had to be compiled"
    assert "compiling the numerical kernels" in err
    assert float(out.split("first step:")[1].split()[0]) < 0.2


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
    make_set(tmp_path / "strips", "uniaxial", [], seed=0)  # with one kernel
    out = tmp_path / "compared.json"
    words = ("compare", tmp_path / "strips", "--model", "base", "--json", out)
    run(environment / "model-lab", *words, cwd=tmp_path)
    assert json.loads(out.read_text())
