"""A ROS domain of a test's own: as of a demo, but also where the user has set ROS_DOMAIN_ID."""

from softhand_bringup.processes.domain import held_domain

__all__ = ["held_domain"]
