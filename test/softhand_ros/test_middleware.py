"""Set-up of the middleware: the profile that is shipped, unless the user has one."""

import os
import xml.etree.ElementTree as ElementTree

import pytest

from softhand_ros.middleware import PROFILE, PROFILE_VARIABLES, set_up_middleware

SWITCH = "RMW_FASTRTPS_USE_QOS_FROM_XML"


@pytest.fixture
def unset(monkeypatch):
    """An environment without profiles, as it was before afterwards."""
    for name in (*PROFILE_VARIABLES, SWITCH):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)


def test_without_a_profile_of_the_users_the_shipped_one_is_taken(unset):
    set_up_middleware()
    assert os.environ[PROFILE_VARIABLES[-1]] == str(PROFILE)
    assert os.environ[SWITCH] == "1"
    ElementTree.parse(PROFILE)


@pytest.mark.parametrize("name", PROFILE_VARIABLES)
def test_a_profile_of_the_users_stands(unset, monkeypatch, name):
    monkeypatch.setenv(name, "mine.xml")
    set_up_middleware()
    assert os.environ[name] == "mine.xml"
    assert SWITCH not in os.environ
