"""What `make setup` refuses."""

import shutil
import subprocess
from pathlib import Path

SETUP = Path(__file__).parents[2] / "scripts" / "setup.sh"


def test_an_environment_that_is_a_link_is_refused_and_stays_as_it_was(tmp_path):
    """A second clone that links the first one's .venv would install its own packages there."""
    (tmp_path / "scripts").mkdir()
    shutil.copy(SETUP, tmp_path / "scripts")
    (tmp_path / "other").mkdir()
    (tmp_path / ".venv").symlink_to(tmp_path / "other")
    done = subprocess.run(
        ["bash", tmp_path / "scripts" / "setup.sh"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1 and "expected a folder of this project, got a link" in done.stderr
    assert list((tmp_path / "other").iterdir()) == []
