"""The environment in which the suite's processes run."""

from __future__ import annotations

import os
from importlib.resources import files
from pathlib import Path


def discovery_profile() -> Path:
    """Fast DDS profile with which late joiners are found within 0.3 s."""
    return Path(str(files("softhand_bringup") / "data" / "fastdds.xml"))


def node_environment(log_folder: Path, domain: int | None = None) -> dict[str, str]:
    """Environment variables for a node; what the user has set stands.

    Args:
        log_folder: where ROS writes its log files.
        domain: ROS_DOMAIN_ID; None keeps the user's.

    >>> node_environment(Path("log"), domain=7)["ROS_DOMAIN_ID"]
    '7'
    """
    environment = dict(os.environ)
    environment.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    environment.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(discovery_profile()))
    environment["ROS_LOG_DIR"] = str(log_folder)
    environment["PYTHONUNBUFFERED"] = "1"
    # several processes share the cores: numpy must not start one thread per core in each
    environment.setdefault("OMP_NUM_THREADS", "1")
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    if domain is not None:
        environment["ROS_DOMAIN_ID"] = str(domain)
    return environment
