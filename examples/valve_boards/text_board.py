"""Valve boards that understand lines of text: over TCP, or over a serial line as an Arduino does.

    from the computer                   from the board
    17 valves 1:+1 3:-1 *19             nothing; outlets that are not named are closed
    18 pressures *7f                    18 17 1000.0 2000.0 3000.0 300000.0 *0c

A line begins with its number and ends with the exclusive or of all its characters before the `*`,
in hexadecimal. The answer holds the number of the question, that of the last line `valves` that the
board has taken, and gauge pressures [Pa] of all outlets and the supply, `nan` for a sensor that
cannot be read. A board ignores lines with another sum, and opens its outlets when it has taken no
line `valves` for 250 ms: `valve_board/valve_board.ino` does.

Needs Linux and numpy. In the hardware file, with this file's folder in PYTHONPATH of the driver:

    board: text_board:NetworkBoard                   board: text_board:SerialBoard
    settings: {host: 192.168.7.2, port: 4000}        settings: {path: /dev/ttyACM0}
"""

import contextlib
import functools
import operator
import os
import random
import select
import socket
import termios
import threading
import time
import tty

import numpy as np

ANSWER_LIMIT = 0.1  # for an answer, and for a connection [s]
START_LIMIT = 5.0  # for the first answer: opening its port makes an Arduino start anew [s]
SILENCE_LIMIT = 1.0  # without an answer, after which the connection is made anew [s]
LONGEST_LINE = 1000  # characters
MOST_NUMBER = 999_999_999  # of a line, from 1; an Arduino counts in 32 bits


def with_sum(text):
    """The line of a text, as bytes: with its check sum and the end of line.

    >>> with_sum("18 pressures")
    b'18 pressures *7f\\n'
    """
    return f"{text} *{_sum((text + ' ').encode()):02x}\n".encode()


def _sum(characters):
    return functools.reduce(operator.xor, characters, 0)


def words_of(line):
    """The words of a line; OSError if its check sum is not that of its characters."""
    text, star, given = line.partition(b"*")
    if not star or f"{_sum(text):02x}".encode() != given.strip().lower():
        raise OSError("the board sends lines without the right check sum")
    return text.decode("ascii", "replace").split()


class TextBoard:
    """A board that understands lines of text; it connects anew when the connection is lost.

    `set_valves` only sends, so it never waits for `read`, which alone waits for answers: that the
    board has not taken the valves is an error of the next `read`.

    Args:
        outlets: number of each channel's outlet, from 1 (n,).
        ambient: absolute ambient pressure [Pa].
        connect: returns a file descriptor that does not block.
        needs_answer: whether it is an error that the connected board gives no answer at first.

    Raises:
        OSError: the board does not answer, or there is no connection.
    """

    def __init__(self, outlets, ambient, connect, needs_answer=True):
        self.outlets, self.ambient, self.connect = outlets, ambient, connect
        self.lock = threading.Lock()  # of what both threads use: the connection and the numbers
        self.link = None
        self.number = random.randrange(MOST_NUMBER)  # hardly those of the driver before this one
        self.valves_number = None  # of the last line `valves`
        self.received, self.answered = b"", 0.0
        end = time.monotonic() + START_LIMIT
        while True:
            try:
                self.read()
                return
            except OSError:
                if time.monotonic() > end:
                    if needs_answer:
                        self.close()
                        raise
                    self.connect_anew(time.monotonic())
                    return
                time.sleep(0.02)

    def set_valves(self, valves):
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed."""
        pairs = zip(self.outlets, valves, strict=True)
        words = [f"{outlet}:{valve:+d}" for outlet, valve in pairs]
        self.send("valves " + " ".join(words), valves=True)

    def read(self):
        """Time [s] and absolute pressures: channels, then supply (n + 1,) [Pa]."""
        stamp = time.monotonic()
        self.connect_anew(stamp)
        try:
            question, expected = self.send("pressures")
        except OSError:
            self.close()
            raise
        taken, *gauge = self.answer(str(question), stamp + ANSWER_LIMIT)
        if expected is not None and taken != str(expected):
            raise OSError("the board has not taken the valves that were sent last")
        used = [outlet - 1 for outlet in self.outlets]
        try:
            gauge = np.array(gauge, dtype=float)
            return stamp, self.ambient + gauge[[*used, -1]]
        except (ValueError, IndexError) as error:
            raise OSError(f"expected a pressure for each outlet and the supply: {error}") from error

    def connect_anew(self, now):
        """Make the connection if there is none."""
        if self.link is None:
            link, self.received, self.answered = self.connect(), b"", now
            with self.lock:
                self.link = link

    def close(self):
        """Let the connection go; the next reading makes a new one."""
        with self.lock:
            link, self.link = self.link, None
        if link is None:
            return
        if os.isatty(link):  # else closing a line that is stuck waits until all has been sent
            with contextlib.suppress(termios.error):
                termios.tcflush(link, termios.TCIOFLUSH)
        os.close(link)  # without the lock: `set_valves` must not wait for it

    def send(self, text, valves=False):
        """Send a line; its number, and that of the last line `valves` before it."""
        with self.lock:
            if self.link is None:
                raise OSError("the board is not connected")
            self.number = self.number % MOST_NUMBER + 1
            line = with_sum(f"{self.number} {text}")
            try:
                written = os.write(self.link, line)
            except OSError as error:  # also when the board takes no more, so that all is full
                raise OSError("the connection to the board is lost") from error
            if written < len(line):
                raise OSError("the connection to the board is lost")
            if valves:
                self.valves_number = self.number
            return self.number, self.valves_number

    def answer(self, number, end):
        """Words of the answer to the line of this number, which comes before the time `end` [s]."""
        while True:
            line, newline, rest = self.received.partition(b"\n")
            if newline:
                self.received = rest
                first, *words = words_of(line) or [""]
                if first == number:
                    self.answered = time.monotonic()
                    return words or [""]
            else:
                self.receive(end)

    def receive(self, end):
        """Wait until more has come, until the time `end` [s] at most."""
        left = end - time.monotonic()
        if left <= 0 or not select.select([self.link], [], [], left)[0]:
            if time.monotonic() - self.answered > SILENCE_LIMIT:
                self.close()
            raise TimeoutError("the board does not answer")
        try:
            received = os.read(self.link, 4096)
        except OSError:
            received = b""
        if not received:
            self.close()
            raise OSError("the connection to the board is lost")
        self.received += received
        if len(self.received) > LONGEST_LINE and b"\n" not in self.received:
            self.received = b""
            raise OSError("the board sends no lines")


class NetworkBoard(TextBoard):
    """A board at `host` that listens on the TCP `port`."""

    def __init__(self, outlets, ambient, host, port, needs_answer=True):
        def connect():
            link = socket.create_connection((host, port), timeout=ANSWER_LIMIT)
            link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            link.setblocking(False)
            return link.detach()

        super().__init__(outlets, ambient, connect, needs_answer)


class SerialBoard(TextBoard):
    """A board on the serial line `path`, such as /dev/ttyACM0, of `baud` bits a second."""

    def __init__(self, outlets, ambient, path, baud=115200, needs_answer=True):
        speed = getattr(termios, f"B{baud}")

        def connect():
            link = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                tty.setraw(link)
                settings = termios.tcgetattr(link)
                settings[4] = settings[5] = speed  # in and out
                termios.tcsetattr(link, termios.TCSANOW, settings)
                termios.tcflush(link, termios.TCIOFLUSH)
            except (OSError, termios.error) as error:
                os.close(link)
                raise OSError(f"{path}: expected a serial line: {error}") from error
            return link

        super().__init__(outlets, ambient, connect, needs_answer)
