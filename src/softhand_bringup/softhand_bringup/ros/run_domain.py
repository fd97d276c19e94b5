"""The ROS domain of a run: without nodes that others have started."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from softhand_bringup.processes.domain import DomainTaken, held_domain
from softhand_bringup.processes.run_folder import Say
from softhand_ros.client_link import ClientLink
from softhand_ros.single import DISCOVERY_TIME

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"
MOST_NAMED = 3  # nodes named in a message


@contextlib.contextmanager
def run_domain(say: Say) -> Iterator[int]:
    """Number of the ROS domain in which a run's nodes meet, as a context manager.

    If ROS_DOMAIN_ID is set, it is that number. Otherwise a free domain is reserved until the
    context ends, and `say` prints its number. Sets ROS_AUTOMATIC_DISCOVERY_RANGE to this machine if
    it is not set.

    Raises:
        DomainTaken: other nodes of the suite already run in that domain.
        ValueError: ROS_DOMAIN_ID is not a number.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with contextlib.ExitStack() as stack:
        if given := os.environ.get(DOMAIN_VARIABLE):
            if not given.isdecimal():
                raise ValueError(f"{DOMAIN_VARIABLE}: expected a number, got {given!r}")
            domain = int(given)
        else:
            domain = stack.enter_context(held_domain())
            say(f"ROS domain {domain} (in another terminal: {DOMAIN_VARIABLE}={domain})")
        _refuse_used(domain)
        yield domain


def _refuse_used(domain: int) -> None:
    """Raise DomainTaken if nodes of a suite are discovered within DISCOVERY_TIME."""
    with ClientLink("softhand_look", domain) as link:
        if link.wait(link.strangers, DISCOVERY_TIME):
            link.spin(0.2)  # to discover the other nodes, too
        refuse_strangers(link)


def refuse_strangers(link: ClientLink) -> None:
    """Check that all nodes of the suite in the domain belong to the enclave of `link`.

    Raises:
        DomainTaken: there are nodes that do not.
    """
    if others := link.strangers():
        named = ", ".join(others[:MOST_NAMED]) + (", ..." if len(others) > MOST_NAMED else "")
        raise DomainTaken(
            f"ROS domain {link.domain} has nodes that this run did not start ({named}): "
            f"end them, or unset {DOMAIN_VARIABLE} to run in a free domain"
        )


def run_enclave(domain: int) -> str:
    """ROS enclave of the nodes of a run, which distinguishes them from other nodes."""
    return f"/softhand_run_{domain}_{os.getpid()}"
