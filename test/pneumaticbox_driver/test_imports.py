"""What the driver may import: observer and controllers never see the plant, only nodes see ROS."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import pneumaticbox_driver

PACKAGE = Path(pneumaticbox_driver.__file__).parent
ALLOWED_PACKAGES = {"softhand_model", "pneumaticbox_driver"}  # and softhand_ros in the room ros
OWN = {"pneuflex_sim", "grasp_strategies", "softhand_bringup", "model_lab"} | ALLOWED_PACKAGES
MODULES = sorted(PACKAGE.rglob("*.py"))
PLANT = "softhand_model.pneumatics"
BLIND = [
    ".".join(("pneumaticbox_driver", *path.relative_to(PACKAGE).with_suffix("").parts))
    for path in MODULES
    if path.parent.name in ("box", "calibration", "control", "faults", "observer")
    and path.name not in ("__init__.py", "command.py")
]


def imported(path):
    """Dotted names that a module imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def all_imports(module, seen):
    """Names that a module of the driver imports, itself or through its siblings."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    if module in seen or not path.exists():
        return
    seen.add(module)
    for name in imported(path):
        if name.startswith("pneumaticbox_driver."):
            all_imports(name, seen)
        seen.add(name)


@pytest.mark.parametrize("name", BLIND)
def test_observer_and_controllers_do_not_know_the_plant_nor_through_others(name):
    seen = set()
    all_imports(name, seen)
    assert "softhand_model.gas" in seen or "numpy" in seen
    assert not [found for found in seen if found.startswith(PLANT)]


def test_the_search_does_find_the_plant_where_it_is():
    seen = set()
    all_imports("pneumaticbox_driver.backends.embedded", seen)
    assert any(found.startswith(PLANT) for found in seen)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_only_the_room_ros_knows_ros_and_only_the_model_is_imported(path):
    roots = {name.split(".")[0] for name in imported(path)}
    assert roots & OWN <= ALLOWED_PACKAGES
    if path.parent.name != "ros":
        assert not [root for root in roots if root == "rclpy" or root.endswith(("_msgs", "_srvs"))]


def test_backends_are_loaded_only_when_they_are_asked_for():
    program = (
        "import sys, pneumaticbox_driver.ros.node; print([name for name in sys.modules if "
        "name.startswith('softhand_model.pneumatics') or '.backends.hardware' in name "
        "or '.backends.embedded' in name or name == 'gpiod'])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
