"""A ROS domain of a test's own."""

import contextlib
import fcntl
import tempfile
from pathlib import Path

DOMAINS = range(1, 102)  # the ports of higher ones reach into the ephemeral range


@contextlib.contextmanager
def held_domain():
    """A ROS_DOMAIN_ID held by a lock file, so that test runs beside each other do not meet."""
    for number in DOMAINS:
        path = Path(tempfile.gettempdir()) / f"softhand-domain-{number}.lock"
        with path.open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    raise RuntimeError("no free ROS domain")
