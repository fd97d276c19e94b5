"""A simulated valve board, a process of its own: chambers with gas physics, a line, faults.

It understands the lines of examples/valve_boards/text_board.py, over TCP or a pseudo terminal, and
shares no code with the suite. What comes on the standard input switches its fault: a name of
FAULTS, or `none`. It prints `ready` and its port, then a line an event, with the monotonic time:

    12.345678 fault hang
    12.350000 told 1:-1 2:-1  valves that have come, when they are others than before
    12.600000 watchdog        opens the outlets, as no valves were taken for 250 ms
    12.700000 up              takes connections again after a restart

Bytes are noted as soon as they arrive, whatever the firmware does: `told` is when the board was
told, not when it obeyed.
"""

import argparse
import contextlib
import functools
import math
import operator
import os
import pty
import random
import selectors
import socket
import sys
import time
import tty

FAULTS = (
    "hang",  # the firmware does nothing any more
    "restart",  # the connection drops, and comes back DOWN later; the valves are closed by then
    "garbage",  # answers of random bytes
    "nan",
    "frozen",  # sensors repeat their reading
    "huge",  # readings of 1e300
    "refuse",  # no valves are taken
    "half",  # answers break off in their midst, some with an end of line
    "late",  # answers come after LATE
    "silent",  # valves are taken, questions not answered
)
DOWN, LATE, WATCHDOG = 0.5, 0.3, 0.25  # [s]
STEP = 1e-3  # of the physics [s]
GAS, TEMPERATURE, AMBIENT, SUPPLY = 287.05, 293.15, 101_325.0, 300e3  # J/(kg K), K, Pa, Pa gauge
RATIO = 1.4  # of specific heats
INLET, OUTLET, LEAK = 0.79 * 3.14e-8, 0.65 * 2.83e-7, 1e-13  # effective areas [m2]
DELAY = 0.03  # of a valve [s]
NOISE, SUPPLY_NOISE = 150.0, 500.0  # one sigma [Pa]


def flow(area, up, down):
    """Mass flow through an orifice from `up` to `down` [Pa absolute]: isentropic, choked [kg/s]."""
    if down > up:
        return -flow(area, down, up)
    critical = (2 / (RATIO + 1)) ** (RATIO / (RATIO - 1))
    r = max(down / up, critical)
    psi = r ** (2 / RATIO) - r ** ((RATIO + 1) / RATIO)
    return area * up * math.sqrt(2 * RATIO / ((RATIO - 1) * GAS * TEMPERATURE) * psi)


class Chamber:
    """Isothermal air behind a 5/3 valve; its volume grows by `swelling` [1/Pa]."""

    def __init__(self, volume, swelling):
        self.volume, self.swelling = volume, swelling
        self.pressure = AMBIENT
        self.mass = AMBIENT * volume / (GAS * TEMPERATURE)
        self.valve, self.commands = 0, []  # where it stands, and where it goes when

    def command(self, now, valve):
        self.commands.append((now + DELAY, valve))

    def step(self, now, dt):
        while self.commands and self.commands[0][0] <= now:
            self.valve = self.commands.pop(0)[1]
        valve = self.valve
        inflow = flow(INLET, AMBIENT + SUPPLY, self.pressure) if valve > 0 else 0.0
        outflow = flow(OUTLET if valve < 0 else LEAK, self.pressure, AMBIENT)
        self.mass += dt * (inflow - outflow)
        # p V0 (1 + swelling (p - ambient)) = m R T, solved for p
        a, b = self.swelling, 1 - self.swelling * AMBIENT
        c = -self.mass * GAS * TEMPERATURE / self.volume
        self.pressure = -c / b if a == 0 else (-b + math.sqrt(b * b - 4 * a * c)) / (2 * a)


class Firmware:
    """Takes lines and answers them; knows nothing of how they come."""

    def __init__(self, volumes, swelling):
        self.chambers = [Chamber(volume, swelling) for volume in volumes]
        self.time = self.heard = time.monotonic()
        self.fault, self.taken = "none", 0
        self.watched = False  # whether the watchdog waits for the next valves
        self.readings = None  # the last, for sensors that are frozen

    def run(self, now):
        """Let the time pass until now; whether the watchdog has opened the outlets."""
        while self.time < now:
            self.time += STEP
            for chamber in self.chambers:
                chamber.step(self.time, STEP)
        barks = self.watched and now - self.heard > WATCHDOG
        if barks:
            self.watched = False
            self.switch(dict.fromkeys(range(1, len(self.chambers) + 1), -1))
        return barks

    def restart(self):
        self.taken, self.watched = 0, False
        self.switch({})

    def switch(self, valves):
        for number, chamber in enumerate(self.chambers, 1):
            chamber.command(self.time, valves.get(number, 0))

    def take(self, words):
        """Answer the words of a line; None for no answer."""
        number, what, *rest = words
        if what == "valves" and self.fault != "refuse":
            self.taken, self.heard, self.watched = int(number), time.monotonic(), True
            self.switch(valves_of(rest))
        if what != "pressures" or self.fault == "silent":
            return None
        values = [f"{value:.1f}" for value in self.read()]
        if self.fault == "nan":
            values[0] = "nan"
        if self.fault == "huge":
            values[0] = "1e300"
        answer = with_sum(" ".join([number, str(self.taken), *values]))
        if self.fault == "garbage":
            return random.randbytes(40) + b"\n"
        if self.fault == "half":
            return answer[: len(answer) // 2] + random.choice([b"", b"\n"])
        return answer

    def read(self):
        if self.fault != "frozen" or self.readings is None:
            channels = [c.pressure - AMBIENT + random.gauss(0, NOISE) for c in self.chambers]
            self.readings = [*channels, SUPPLY + random.gauss(0, SUPPLY_NOISE)]
        return self.readings


def with_sum(text):
    characters = f"{text} ".encode()
    return characters + b"*%02x\n" % functools.reduce(operator.xor, characters)


def words_of(line):
    """Words of a line; none where its sum is wrong."""
    text, _, given = line.partition(b"*")
    right = b"%02x" % functools.reduce(operator.xor, text, 0) == given.strip()
    return text.decode().split() if right else []


def valves_of(words):
    return {int(outlet): int(valve) for outlet, valve in (word.split(":") for word in words)}


class TcpLine:
    """Listens on a port of the loopback, and serves the connection that came last."""

    def __init__(self, port=0):
        self.connection = None
        self.listener = socket.create_server(("127.0.0.1", port))
        self.address = self.listener.getsockname()[1]

    def files(self):
        return [f for f in (self.listener, self.connection) if f is not None]

    def receive(self, ready):
        """Bytes that have come, of the file that is `ready`."""
        if ready is self.listener:
            self._drop()
            self.connection = self.listener.accept()[0]
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        try:
            received = self.connection.recv(4096)
        except ConnectionError:
            received = b""
        if not received:
            self._drop()
        return received

    def send(self, answer):
        if self.connection is not None:
            with contextlib.suppress(ConnectionError):  # the driver has gone
                self.connection.sendall(answer)

    def _drop(self):
        if self.connection is not None:
            self.connection.close()
            self.connection = None

    def down(self):
        self._drop()
        self.listener.close()

    def up(self):
        return TcpLine(self.address)


class SerialLine:
    """A pseudo terminal that `path` leads to."""

    def __init__(self, path):
        self.address = path
        self.board, self.computer = pty.openpty()  # the second stays open: no end when one leaves
        tty.setraw(self.computer)
        os.set_blocking(self.board, False)
        os.symlink(os.ttyname(self.computer), path)

    def files(self):
        return [self.board]

    def receive(self, ready):
        return os.read(ready, 4096)

    def send(self, answer):
        with contextlib.suppress(BlockingIOError):  # nobody reads, as on a real line
            os.write(self.board, answer)

    def down(self):
        os.unlink(self.address)
        os.close(self.computer)
        os.close(self.board)

    def up(self):
        return SerialLine(self.address)


class Board:
    """Line, firmware and faults, in one loop."""

    def __init__(self, line, firmware):
        self.line, self.firmware = line, firmware
        self.received, self.controls, self.told = b"", b"", None
        self.waiting = []  # lines that a firmware that hangs has not seen
        self.answers = []  # when to send what
        self.back = None  # monotonic time at which a restart is over [s]
        self.ended = False

    def log(self, *words):
        print(f"{time.monotonic():.6f}", *words, flush=True)

    def run(self):
        while not self.ended:
            now = time.monotonic()
            if self.back is not None and now >= self.back:
                self.line, self.back = self.line.up(), None
                self.log("up")
            files = [] if self.back is not None else self.line.files()
            with selectors.DefaultSelector() as selector:
                for file in (sys.stdin, *files):
                    selector.register(file, selectors.EVENT_READ)
                ready = [key.fileobj for key, _ in selector.select(0.002)]
            if sys.stdin in ready:
                self.control()
            elif ready:
                self.arrive(b"".join(self.line.receive(file) for file in ready))
            self.work(time.monotonic())

    def control(self):
        received = os.read(sys.stdin.fileno(), 100)
        self.ended = not received
        *names, self.controls = (self.controls + received).split(b"\n")
        for name in names:
            self.firmware.fault = name.decode()
            self.log("fault", self.firmware.fault)
            if self.firmware.fault == "restart":
                self.line.down()
                self.firmware.restart()
                self.received, self.waiting, self.answers = b"", [], []
                self.back = time.monotonic() + DOWN

    def arrive(self, received):
        *lines, self.received = (self.received + received).split(b"\n")
        for words in filter(None, map(words_of, lines)):
            self.waiting.append(words)
            if words[1] == "valves" and (told := valves_of(words[2:])) != self.told:
                self.told = told
                self.log("told", *(f"{outlet}:{valve}" for outlet, valve in told.items()))

    def work(self, now):
        if self.firmware.fault == "hang":
            self.firmware.heard = now  # its watchdog hangs with it
            self.firmware.run(now)
            return
        if self.firmware.run(now):
            self.log("watchdog")
        delay = LATE if self.firmware.fault == "late" else 0.0
        self.answers += [(now + delay, self.firmware.take(words)) for words in self.waiting]
        self.waiting = []
        while self.answers and self.answers[0][0] <= now and self.back is None:
            answer = self.answers.pop(0)[1]
            if answer is not None:
                self.line.send(answer)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--serial", help="path of the serial line; none: TCP")
    parser.add_argument("--volumes", type=float, nargs="+", default=[30e-6] * 2, help="[m3]")
    parser.add_argument("--swelling", type=float, default=0.0, help="of the volumes [1/Pa]")
    arguments = parser.parse_args()
    line = SerialLine(arguments.serial) if arguments.serial else TcpLine()
    print("ready", line.address, flush=True)
    Board(line, Firmware(arguments.volumes, arguments.swelling)).run()
    if arguments.serial and os.path.islink(arguments.serial):
        os.unlink(arguments.serial)


if __name__ == "__main__":
    main()
