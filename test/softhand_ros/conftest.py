"""A ROS domain of the tests' own."""

import pytest
from ros_domain import held_domain


@pytest.fixture(scope="module")
def domain():
    """A ROS_DOMAIN_ID that no other test uses."""
    with held_domain() as domain:
        yield domain
