"""Every package that `make setup` installs is locked by a hash, as the hand-written inputs say."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
INPUTS, LOCKS = ROOT / "requirements", ROOT / "requirements" / "lock"
PYTHONS = ("3.11", "3.12", "3.13")
MADE_FROM = {**dict.fromkeys(PYTHONS, "develop"), "build": "build", "oldest": "oldest"}
THIS_PYTHON = "{}.{}.txt".format(*sys.version_info[:2])


def pinned(file, python):
    """Name and version of each requirement of an input for a version of Python, and of those that
    it includes.
    """
    versions = {}
    for line in file.read_text().splitlines():
        if line.startswith("-r "):
            versions |= pinned(file.parent / line[3:], python)
        elif line and not line.startswith("#"):
            requirement = Requirement(line)
            if requirement.marker and not requirement.marker.evaluate({"python_version": python}):
                continue
            (version,) = requirement.specifier
            assert version.operator == "=="
            versions[canonicalize_name(requirement.name)] = version.version
    return versions


def locked(file):
    """Version and hashes of each package of a lock; nothing else may stand there."""
    text = re.sub(r" \\\n +", " ", file.read_text())
    packages = {}
    for line in text.splitlines():
        if not line.startswith("#"):
            whole = re.fullmatch(
                r"([a-z0-9-]+)(?:\[\S+\])?==(\S+)((?: --hash=sha256:\w{64})+)", line
            )
            assert whole, f"expected name==version and hashes, got {line[:100]}"
            packages[whole[1]] = (whole[2], whole[3].split())
    return packages


@pytest.mark.parametrize("name", MADE_FROM)
def test_a_lock_has_every_version_of_its_input_with_a_hash(name):
    packages = locked(LOCKS / f"{name}.txt")
    python = name if name in PYTHONS else "3.11"
    wanted = pinned(INPUTS / f"{MADE_FROM[name]}.txt", python)
    found = {package: packages[package][0] for package in wanted if package in packages}
    assert found == wanted, "run `make lock`"


def test_there_is_no_lock_that_nothing_makes():
    assert {file.stem for file in LOCKS.iterdir()} == set(MADE_FROM)


@pytest.fixture
def setup(tmp_path):
    """A copy of setup.sh whose one package is a wheel on this disk, locked with a hash: its last
    line, and the wheel's hash.
    """
    folder, name = tmp_path / "clone", "softhand_probe-1.0"
    lock = folder / "requirements" / "lock"
    lock.mkdir(parents=True)
    (folder / "scripts").mkdir()
    shutil.copy(ROOT / "scripts" / "setup.sh", folder / "scripts")
    wheel = tmp_path / f"{name}-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        metadata = "Metadata-Version: 2.1\nName: softhand-probe\nVersion: 1.0\n"
        archive.writestr("softhand_probe.py", "")
        archive.writestr(f"{name}.dist-info/METADATA", metadata)
        archive.writestr(f"{name}.dist-info/WHEEL", "Wheel-Version: 1.0\nTag: py3-none-any\n")
        archive.writestr(f"{name}.dist-info/RECORD", "")

    def run(digest, python=THIS_PYTHON):
        (lock / "build.txt").write_text(f"softhand-probe==1.0 --hash=sha256:{digest}\n")
        (lock / python).write_text("softhand-missing==1.0 --hash=sha256:" + 64 * "0" + "\n")
        environment = os.environ | {
            "PYTHON": sys.executable,
            "PIP_NO_INDEX": "1",
            "PIP_FIND_LINKS": str(tmp_path),
        }
        script = folder / "scripts" / "setup.sh"
        done = subprocess.run([script], env=environment, capture_output=True, text=True)
        assert done.returncode == 1
        return done.stderr.splitlines()[-1]

    return run, hashlib.sha256(wheel.read_bytes()).hexdigest()


def test_setup_refuses_a_package_with_another_hash_and_says_which(setup):
    run, digest = setup
    refused = "setup: refused: expected a hash of requirements/lock for softhand-probe==1.0: "
    assert run(64 * "0").startswith(f"{refused}got sha256 {digest} (log: ")
    assert "softhand-missing" in run(digest)  # the wheel was installed, the next step failed


def test_setup_refuses_a_python_without_lock(setup):
    run, digest = setup
    expected = f"expected a version that has a requirements/lock/{THIS_PYTHON}"
    assert run(digest, python="2.7.txt").endswith(expected)


# make setup installs what the lock names and nothing else.
def test_no_package_of_the_environment_misses_another():
    check = subprocess.run(
        [sys.executable, "-m", "pip", "--disable-pip-version-check", "check"],
        capture_output=True,
        text=True,
    )
    assert check.returncode == 0, check.stdout
