"""Nodes of a suite that another user has started: a command would move their hand as well."""

from __future__ import annotations

import re

from rclpy.node import Node, NodeNameNonExistentError

# topics and services of the suite, in any namespace
SUITE = re.compile(r"/clock|(/\w+)*/(pneumaticbox|hand|wrist|scene|grasp|sim)/\w+")


def strangers(node: Node, enclave: str) -> list[str]:
    """Nodes in the ROS domain of `node`, outside of an enclave, that publish a topic or offer a
    service of the suite: for each a phrase with its name and its first topic or service.
    """
    found = []
    for name, namespace, theirs in node.get_node_names_and_namespaces_with_enclaves():
        if theirs == enclave:
            continue
        try:
            published = node.get_publisher_names_and_types_by_node(name, namespace)
            offered = node.get_service_names_and_types_by_node(name, namespace)
        except NodeNameNonExistentError:  # it has ended meanwhile
            continue
        for verb, names in (("publishes", published), ("offers", offered)):
            of_suite = sorted(one for one, _ in names if SUITE.fullmatch(one))
            if of_suite:
                found.append(f"{namespace.rstrip('/')}/{name} {verb} {of_suite[0]}")
                break
    return found
