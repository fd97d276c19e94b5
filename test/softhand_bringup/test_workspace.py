"""The colcon workspace: packages build, what `ros2 run` and `ros2 launch` need is installed."""

import ast
import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.parent.name for path in (ROOT / "src").glob("*/package.xml"))
EXECUTABLES = {
    "pneuflex_sim": {"hand_sim", "hand"},
    "softhand_design": {"hand", "softhand-materials"},
    "pneumaticbox_driver": {"driver", "calibrate"},
    "grasp_strategies": {"sequencer"},
    "softhand_trials": {"trials", "softhand-sweep", "softhand-search"},
    "model_lab": {"model_lab", "model-lab", "monitor"},
    "softhand_play": {"softhand-play"},
    "softhand_bringup": {
        "softhand",
        "demo",
        "film",
        "hand_story",
        "hand_with_box",
        "lab_story",
        "recorder",
        "repair_bag",
    },
}


def run(command, folder, **environment):
    result = subprocess.run(
        command, cwd=folder, env=os.environ | environment, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module", params=[[], ["--symlink-install"]], ids=["plain", "symlink"])
def install(request, tmp_path_factory):
    """Install space of a `colcon build` of ros_ws."""
    folder = tmp_path_factory.mktemp("colcon")
    bases = [f"--{kind}-base={folder / kind}" for kind in ("build", "install")]
    colcon = str(Path(sys.executable).with_name("colcon"))
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    command = [colcon, f"--log-base={folder / 'log'}", "build", *bases, *request.param]
    run(command, ROOT / "ros_ws", PATH=path)
    return folder / "install"


def test_the_workspace_reaches_the_packages_through_its_link():
    assert (ROOT / "ros_ws" / "src").is_symlink()
    assert (ROOT / "ros_ws" / "src").resolve() == ROOT / "src"


def test_every_package_is_installed_with_its_marker_and_manifest(install):
    for name in PACKAGES:
        share = install / name / "share"
        assert (share / "ament_index/resource_index/packages" / name).is_file(), name
        assert (share / name / "package.xml").is_file(), name


def test_executables_are_where_ros2_run_looks(install):
    for package, names in EXECUTABLES.items():
        files = {p.name for p in (install / package / "lib" / package).iterdir()}
        assert names <= files, package


def test_every_config_and_launch_file_is_installed(install):
    for kind in ("config/*", "launch/*.launch.py"):
        for source in (ROOT / "src").glob(f"*/{kind}"):
            package = source.parents[1].name
            share = install / package / "share" / package
            assert (share / source.parent.name / source.name).exists()
    assert list(install.glob("grasp_strategies/share/grasp_strategies/launch/softhand.launch.py"))


def test_every_data_file_is_installed_beside_its_module(install):
    sources = [
        path
        for pattern in ("*.yaml", "*.xml")
        for path in (ROOT / "src").glob(f"*/*/data/**/{pattern}")
    ]
    assert len(sources) > 5
    script = "import importlib.util as u, sys; print(u.find_spec(sys.argv[1]).origin)"
    for package in PACKAGES:
        # outside the repository and with the workspace in front, as `. install/setup.bash` has it
        site = [str(p) for p in install.glob("*/lib/python3*/site-packages")]
        site += [str(p) for p in install.parent.glob("build/*") if p.is_dir()]
        where = run(
            [sys.executable, "-c", script, package], install, PYTHONPATH=os.pathsep.join(site)
        )
        folder = Path(where.strip()).parent
        assert ROOT / "src" not in folder.parents
        for source in sources:
            if source.is_relative_to(ROOT / "src" / package / package):
                assert (folder / source.relative_to(ROOT / "src" / package / package)).exists()


def test_an_installed_executable_starts(install):
    script = f". {install}/setup.sh && {install}/softhand_bringup/lib/softhand_bringup/demo --help"
    assert "--seed" in run(["sh", "-c", script], install)


@pytest.mark.parametrize("package", PACKAGES)
def test_the_manifest_agrees_with_the_package(package):
    manifest = ElementTree.parse(ROOT / "src" / package / "package.xml").getroot()
    assert manifest.findtext("name") == package
    assert manifest.findtext("export/build_type") == "ament_python"
    declared = {e.text for e in manifest.findall("exec_depend")}
    imported = imported_modules(ROOT / "src" / package / package)
    ours = (imported & set(PACKAGES)) - {package}
    messages = {name for name in imported if name.endswith("_msgs") or name == "rclpy"}
    assert ours | messages <= declared


def imported_modules(folder):
    """Names of the top-level packages that the modules below a folder import."""
    names = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.split(".")[0])
    return names
