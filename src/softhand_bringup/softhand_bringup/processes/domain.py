"""Finds a ROS domain that is unused on this machine."""

from __future__ import annotations

import contextlib
import fcntl
import tempfile
from collections.abc import Iterator
from pathlib import Path

DOMAINS = range(1, 102)  # the ports of higher ones reach into the ephemeral range
FIRST_PORT, PORTS = 7400, 250  # UDP ports by the RTPS standard: of domain 0, and of each domain
SOCKETS = (Path("/proc/net/udp"), Path("/proc/net/udp6"))


class DomainTaken(RuntimeError):
    """The ROS domain has nodes that this run did not start; the message names them and says what to
    do.
    """


@contextlib.contextmanager
def held_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID without nodes of this machine, reserved by a lock file during the context.

    Raises:
        RuntimeError: no domain is free.
    """
    for number in DOMAINS:
        path = Path(tempfile.gettempdir()) / f"softhand-domain-{number}.lock"
        with contextlib.ExitStack() as stack:
            try:
                file = stack.enter_context(path.open("w"))
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:  # held, or the file of another user
                continue
            if is_used(number):
                continue
            yield number
            return
    raise RuntimeError(
        "ROS_DOMAIN_ID: expected a free domain on this machine, got none; end nodes that still run"
    )


def is_used(domain: int) -> bool:
    """Whether a process of any user of this machine has opened a UDP port of a ROS domain."""
    first = FIRST_PORT + PORTS * domain
    return any(port in range(first, first + PORTS) for port in _open_ports())


def _open_ports() -> Iterator[int]:
    for table in SOCKETS:
        if not table.exists():  # without IPv6
            continue
        for line in table.read_text().splitlines()[1:]:
            yield int(line.split()[1].rpartition(":")[2], 16)
