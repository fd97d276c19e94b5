"""Whatever goes wrong in answering a sample opens the outlets, is named, and can be reset."""

import numpy as np
import pytest
from bottle_rig import BottleRig

from pneumaticbox_driver.control import channels

MG = 1e-6


class Moody:
    """A controller that fails as long as `anger` is set."""

    anger = None

    def update(self, view):
        if Moody.anger:
            raise Moody.anger
        return np.zeros(len(view.setpoints), dtype=np.int8)


@pytest.fixture
def rig(monkeypatch):
    """Three filled channels, b of them in the hands of a controller that can fail."""
    monkeypatch.setitem(channels.CONTROLLERS, "pressure", Moody)
    monkeypatch.setattr(Moody, "anger", None)
    rig = BottleRig(channels=3).started()
    rig.command(15 * MG, 15 * MG, 15 * MG)
    rig.run(1.5)
    rig.box.set_modes(["mass", "pressure", "mass"])
    return rig


def test_a_controller_that_raises_vents_and_names_channel_mode_and_error(rig):
    Moody.anger = IndexError("index 9 is out of bounds")
    rig.run(0.01)
    assert rig.box.valves.tolist() == [-1, -1, -1]
    assert rig.box.latch.reasons == [
        "channels b, mode pressure: IndexError: index 9 is out of bounds"
    ]
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.05 * MG)


def test_its_traceback_is_noted_once_and_long_words_are_cut(rig):
    Moody.anger = RuntimeError("x" * 10_000)
    rig.run(0.5)
    (note,) = [note for note in rig.box.notes if "control step failed" in note]
    assert "in update\n    raise Moody.anger" in note
    assert len(rig.box.latch.reasons[0]) < 300 and max(map(len, note.splitlines())) < 400


def test_after_a_reset_it_works_again_and_a_lasting_fault_vents_again(rig):
    Moody.anger = ZeroDivisionError("division by zero")
    rig.run(2.0)
    rig.box.reset()
    rig.box.command(["b"], [point(20e3)], 0.0, rig.box.time)
    rig.run(0.5)
    assert rig.box.valves.tolist() == [-1, -1, -1] and rig.box.latch
    Moody.anger = None
    rig.run(1.0)
    rig.box.reset()
    rig.run(0.5)
    rig.box.command(["a", "c"], [point(20 * MG, 20 * MG)], 0.0, rig.box.time)
    rig.run(2.0)
    assert not rig.box.latch
    np.testing.assert_allclose(rig.mass[[0, 2]], 20 * MG, atol=2 * MG)


def point(*values):
    from pneumaticbox_driver.box.commands import TrajectoryPoint

    return TrajectoryPoint(0.0, positions=values, effort=values)


@pytest.mark.parametrize("part", ["observer.advance", "faults.look", "guard.apply"])
def test_any_part_of_the_control_step_may_fail(rig, monkeypatch, part):
    owner, method = part.split(".")

    def fail(*_):
        raise TypeError("broken")

    with monkeypatch.context() as broken:
        broken.setattr(getattr(rig.box, owner), method, fail)
        broken.setattr(rig.box.faults, "due", lambda *_: True)
        rig.run(0.05)
    assert rig.box.latch.reasons[0] == "control step: TypeError: broken"
    assert rig.box.valves.tolist() == [-1, -1, -1]
    rig.run(2.0)
    np.testing.assert_allclose(rig.mass, 0.0, atol=0.1 * MG)
    rig.box.reset()
    assert not rig.box.latch


@pytest.mark.parametrize("reading", [-1.0, 0.0, 1e308, np.inf])
def test_a_reading_that_is_no_pressure_vents_and_leaves_the_estimates_sound(rig, reading):
    readings = rig.plant.read()
    readings[1] = reading
    rig.answer(readings)
    assert rig.box.latch.reasons[0].startswith("sensor b: no absolute pressure is")
    rig.run(1.0)
    rig.box.reset()
    assert np.isfinite(rig.box.observer.mass).all()
