"""One version for all packages."""

import importlib.util
import shutil
from pathlib import Path

ROOT = Path(__file__).parents[2]
SPEC = importlib.util.spec_from_file_location("set_version", ROOT / "scripts" / "set_version.py")
set_version = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(set_version)


def test_all_packages_and_the_citation_have_the_same_version():
    found = set_version.versions()
    packages = {path.name for path in (ROOT / "src").iterdir() if (path / "setup.py").exists()}
    assert {path.parent.name for path in found if path.name == "package.xml"} == packages
    assert {path.parent.name for path in found if path.name == "setup.py"} == packages
    assert len(set(found.values())) == 1


def test_a_new_version_is_written_everywhere_and_nothing_else_changes(tmp_path):
    for path, _ in set_version.files():
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    old = set(set_version.versions(tmp_path).values()).pop()
    set_version.set_version("7.8.9", tmp_path)
    assert set(set_version.versions(tmp_path).values()) == {"7.8.9"}
    for path, _ in set_version.files():
        copy = tmp_path / path.relative_to(ROOT)
        assert copy.read_text().replace("7.8.9", old) == path.read_text()
