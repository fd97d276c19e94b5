"""A ROS domain that no other run on this machine uses, reserved for a test.

A demo keeps to ROS_DOMAIN_ID if the user has set it; tests never do, so that they hear no nodes but
their own.
"""

from softhand_bringup.processes.domain import held_domain

__all__ = ["held_domain"]
