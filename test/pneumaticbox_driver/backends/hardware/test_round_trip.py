"""The box on the plant through wires: lines that only remember and files in place of sysfs."""

import numpy as np
import pytest
from bottle_rig import BottleRig
from wired_box import AnalogTree, RememberedLines, hardware_file

from pneumaticbox_driver.backends.hardware.hardware_file import read_hardware
from pneumaticbox_driver.backends.hardware.opening import open_board
from pneumaticbox_driver.backends.hardware.rig import HardwareRig
from softhand_model.gas import AMBIENT_PRESSURE

MG = 1e-6
DIVIDER = 10 / 28


def counts(pressures):
    """What 12 bit over 1.8 V count for the sensors of Table 4.1, by their data sheets (n + 1,)."""
    kpa = (np.asarray(pressures) - AMBIENT_PRESSURE) / 1e3
    slope = np.append(np.full(len(kpa) - 1, 0.00369), 0.0012858)
    return np.round(5 * (slope * kpa + 0.04) * DIVIDER / 1.8 * 4096).astype(int)


class WiredRig(BottleRig):
    """The plant's sensors stand in files, its valves follow coils; the box knows but the bench."""

    def __init__(self, folder, **keywords):
        super().__init__(**keywords)
        self.tree = AnalogTree(folder / "sysfs")
        n = len(self.names)
        path = hardware_file(folder, self.tree.root)
        # without the bench, whose limits are of real time
        self.board = open_board(read_hardware(path), range(1, n + 1), make_lines=self._connect)
        self.cut = False  # whether the wire of the first sensor is cut

    def _connect(self, coils):
        self.lines = RememberedLines(coils)
        return self.lines

    def sample(self, dt):
        self.plant.step(dt, self.lines.valves(len(self.names)), self.volumes())
        readings = counts(self.plant.read())
        for number, raw in zip((*range(len(self.names)), 6), readings, strict=True):
            self.tree.put(number, 0 if self.cut and number == 0 else raw)
        _, pressures = self.board.read()
        self.board.set_valves(self.box.on_sample(self.plant.time, pressures))


@pytest.fixture
def rig(tmp_path):
    rig = WiredRig(tmp_path, channels=2, compliance=0.8, seed=4)
    yield rig.started()
    rig.board.close()


def test_targets_of_mass_are_reached_up_and_down(rig):
    for target in (20 * MG, 6 * MG):
        rig.command(target, target)
        rig.run(2.5)
        assert (np.abs(rig.mass - target) < rig.smallest_pulses()).all()
    assert not rig.lines.both_on()
    assert not any(any(state[4:]) for state in rig.lines.history)  # outlets that nobody uses


def test_a_wire_that_is_cut_vents_everything_and_says_which(rig):
    rig.command(20 * MG, 20 * MG)
    rig.run(2.0)
    rig.cut = True
    rig.run(2.0)
    assert rig.box.latch.reasons == ["sensor a: not a number"]
    assert rig.lines.valves(2) == [-1, -1]
    np.testing.assert_allclose(rig.mass, 0.0, atol=1 * MG)


def test_when_the_driver_ends_the_bottles_are_left_venting(rig):
    rig.command(20 * MG, 20 * MG)
    rig.run(2.0)
    HardwareRig(rig.board, 2, vent_time=0.0).close()
    assert rig.lines.valves(2) == [-1, -1] and rig.lines.released
