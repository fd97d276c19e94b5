"""A command that cannot be used is refused whole, named in /diagnostics, and changes nothing."""

import math

import pytest
from forked_nodes import ForkingLauncher
from suite_peer import SuitePeer

from softhand_bringup.processes import suite

GOOD = 2.0e-5  # [kg]


@pytest.fixture(scope="module")
def connected(domain, tmp_path_factory):
    """The test's own node beside the three that all tests here share; the driver does not mind how
    long a test takes from one command to the next.
    """
    folder, options = tmp_path_factory.mktemp("log"), suite.SuiteOptions()
    with ForkingLauncher(folder, suite.node_environment(folder, domain)) as launcher:
        for command in (suite.simulator(options), suite.driver(options), suite.sequencer(options)):
            launcher.start(command)
        peer = SuitePeer(domain, folder)
        peer.wait_for_driver()
        yield peer
        peer.close()


@pytest.fixture
def filled(connected):
    """The peer, once channel a alone holds the mass that was commanded."""
    connected.command([GOOD, 0.0, 0.0, 0.0])

    def alone():
        first, *others = connected.state().position
        return abs(first - GOOD) < 0.15 * GOOD and max(others) < 0.15 * GOOD

    connected.wait(alone, "channel a to be filled")
    return connected


@pytest.mark.parametrize(
    ("masses", "channels", "field"),
    [
        ([math.nan, 5e-5, 0.0, 0.0], None, "positions"),
        ([5e-5, 5e-5, 5e-5], None, "positions"),
        ([5e-5, 5e-5], ["a", "z"], "joint_names"),
    ],
    ids=["NaN", "wrong length", "unknown channel"],
)
def test_an_unusable_command_is_refused_whole_and_named_in_diagnostics(
    filled, masses, channels, field
):
    filled.command(masses, channels)
    assert "pneumaticbox/command" in filled.diagnosis("pneumaticbox", field)
    filled.pass_time(0.5)
    mass = list(filled.state().position)
    assert mass[0] == pytest.approx(GOOD, rel=0.2)
    assert mass[1:] == pytest.approx([0.0] * 3, abs=0.2 * GOOD)


def test_a_good_command_after_a_bad_one_is_obeyed(filled):
    filled.command([math.nan] * 4)
    filled.diagnosis("pneumaticbox", "positions")
    filled.command([0.0, GOOD, 0.0, 0.0])
    filled.wait(
        lambda: (
            filled.state().position[0] < 0.3 * GOOD and filled.state().position[1] > 0.85 * GOOD
        ),
        "channel b to be filled and a emptied",
    )
