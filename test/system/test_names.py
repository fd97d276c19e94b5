"""A hand or an object that does not exist: the node says which do, and ends."""

from dataclasses import replace

import pytest

from softhand_bringup.processes import suite


@pytest.mark.parametrize(
    ("start", "wrong", "existing"),
    [
        (suite.simulator, {"hand": "rbo_hand_9"}, ("rbo_hand_2", "rbo_hand_1", "single_finger")),
        (suite.simulator, {"object": "teapot"}, ("cylinder",)),
        (suite.simulator, {"scene": "moon"}, ("table",)),
        (suite.driver, {"hand": "rbo_hand_9"}, ("rbo_hand_2", "single_finger")),
        (suite.sequencer, {"hand": "rbo_hand_9"}, ("rbo_hand_2", "single_finger")),
    ],
    ids=["simulator hand", "simulator object", "simulator scene", "driver hand", "sequencer hand"],
)
def test_a_wrong_name_ends_the_node_with_the_names_that_exist(
    launcher, options, start, wrong, existing
):
    process = launcher.start(start(replace(options, **wrong)))
    assert process.wait(30.0) not in (None, 0), process.output()
    line = process.last_words()
    assert next(iter(wrong.values())) in line
    for name in existing:
        assert name in line
    assert "Traceback" not in process.output()
