"""A box wired to a folder in place of sysfs and to lines that only remember."""

import os
from pathlib import Path

import yaml

SHIPPED = Path(__file__).parents[2] / "src/pneumaticbox_driver/config/hardware.yaml"
SCALE = 1800 / 4096  # of the am335x's converter: 1.8 V, 12 bit [mV per count]


class AnalogTree:
    """The IIO part of sysfs below a folder, with inputs 0 to 6 at `raw` counts."""

    def __init__(self, root, raw=400, scale=SCALE, name="TI-am335x-adc.0.auto"):
        self.root, self.device = root, root / "iio:device0"
        self.device.mkdir(parents=True)
        self.write("name", name)
        if scale is not None:
            self.write("in_voltage_scale", scale)
        for number in range(7):
            self.put(number, raw)

    def write(self, file, content):
        (self.device / file).write_text(f"{content}\n")

    def put(self, number, raw):
        # over the old number, of one length: truncated files are slow on some file systems
        file = os.open(self.device / f"in_voltage{number}_raw", os.O_WRONLY | os.O_CREAT)
        os.write(file, f"{raw:8}\n".encode())
        os.close(file)


class RememberedLines:
    """Lines that remember: `active` now, `history` after each switching, `released`."""

    def __init__(self, coils):
        self.coils = coils
        self.active = [False] * len(coils)
        self.history, self.released = [], False

    def switch(self, active):
        for index, on in active.items():
            self.active[index] = on
        self.history.append(list(self.active))

    def release(self):
        self.released = True

    def valves(self, channels):
        """What the coils of the first outlets do: +1 inflate, -1 deflate, 0 nothing."""
        return [
            int(self.active[2 * channel]) - int(self.active[2 * channel + 1])
            for channel in range(channels)
        ]

    def both_on(self):
        """Whether both coils of a valve have ever been on together."""
        return any(state[i] and state[i + 1] for state in self.history for i in range(0, 12, 2))


def hardware_file(folder, sysfs, change=None):
    """Write the shipped hardware file with another root of sysfs, after `change`(document)."""
    document = yaml.safe_load(SHIPPED.read_text())
    document["converter"]["sysfs"] = str(sysfs)
    document["vent_time"] = 0.0
    if change is not None:
        change(document)
    path = folder / "hardware.yaml"
    path.write_text(yaml.safe_dump(document))
    return path
