"""Settings of Fast DDS and of the heap, and what killed processes left of shared memory.

By default Fast DDS keeps buffers of the size of the largest message so far, and glibc keeps freed
memory in its heaps.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import time
from pathlib import Path

PROFILE = Path(__file__).parent / "fast_dds.xml"
PROFILE_VARIABLES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
MMAP_THRESHOLD, ARENA_MAX = -3, -8  # of mallopt(3)
MAPPED_BLOCK = 128 * 1024  # [bytes]; larger blocks are mapped, and unmapped when they are freed
SHARED_MEMORY = Path("/dev/shm")
PORT_SEGMENTS = "fastrtps_port*[0-9]"  # segments of Fast DDS; locks end in letters
INITIALIZED = 2  # first word of a segment, of boost::interprocess; less: not yet
READER_LOCKS = "fastrtps_port*_el"  # locked by the process that reads the port, until it ends
NODE_OF_PORT = b"port_node_abi5"  # name of the structure in which the two below are
NUMBER_TO_FLAGS = 24  # bytes from the port's number to its flags
PORT_OK, ALL_FLAGS = 1, 7  # who writes to the port looks for a new one when PORT_OK is not set
LOCKING_LIMIT = 2.0  # between making a file and locking it [s]
INITIALIZATION_LIMIT = 5.0  # a living process is done in less than a millisecond [s]


def set_up_middleware() -> None:
    """Set up this process; call it before rclpy.init. A Fast DDS profile of the user is kept.

    Removes what killed processes left of shared memory: segments that they did not finish, and
    ports that they read.
    """
    if not any(name in os.environ for name in PROFILE_VARIABLES):
        os.environ[PROFILE_VARIABLES[-1]] = str(PROFILE)
        os.environ["RMW_FASTRTPS_USE_QOS_FROM_XML"] = "1"
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # of glibc
    if mallopt is not None:
        mallopt(MMAP_THRESHOLD, MAPPED_BLOCK)
        mallopt(ARENA_MAX, 1)
    remove_unfinished_segments()
    remove_ports_without_reader()


def remove_unfinished_segments() -> None:
    """Remove ports of Fast DDS in shared memory whose initialisation will never end.

    A process that is killed between creating and initialising such a port leaves it behind, and
    every later participant of the domain that uses this port waits for it for ever.
    """
    for path in SHARED_MEMORY.glob(PORT_SEGMENTS):
        with contextlib.suppress(FileNotFoundError, PermissionError):  # gone, or another user's
            while _is_unfinished(path):
                if time.time() - path.stat().st_mtime > INITIALIZATION_LIMIT:
                    path.unlink()
                time.sleep(0.1)


def _is_unfinished(path: Path) -> bool:
    with path.open("rb") as file:
        return int.from_bytes(file.read(4), "little") < INITIALIZED


def remove_ports_without_reader() -> None:
    """Remove ports of Fast DDS in shared memory whose reader was killed, and tell their writers.

    Fast DDS 2.14 removes such a port when its number is taken again, but does not tell the writers,
    which may go on to write into what was removed: what is started anew never hears them
    (eProsima/Fast-DDS, pull request 4728). Ports of another layout are left alone, and so are ports
    whose lock was made within LOCKING_LIMIT.
    """
    for lock in SHARED_MEMORY.glob(READER_LOCKS):
        # gone, another user's, or locked by its reader
        with (
            contextlib.suppress(FileNotFoundError, PermissionError, BlockingIOError),
            lock.open("rb") as file,
        ):
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _may_have_a_reader(lock, os.fstat(file.fileno())):
                continue
            port = lock.with_name(lock.name.removesuffix("_el"))
            if _mark_as_not_ok(port):
                port.unlink()
                lock.unlink()


def _may_have_a_reader(lock: Path, held: os.stat_result) -> bool:
    """Whether the file at `lock` may belong to a living reader: it is no longer the file that is
    `held`, as a reader has taken the number of the port again, or it was made so lately that its
    reader may not have locked it yet.
    """
    return lock.stat().st_ino != held.st_ino or time.time() - held.st_mtime < LOCKING_LIMIT


def _mark_as_not_ok(port: Path) -> bool:
    """Clear the flag PORT_OK; whether the flag was found."""
    content = port.read_bytes()
    number = int(port.name.removeprefix("fastrtps_port")).to_bytes(4, "little")
    at = content.find(number) + NUMBER_TO_FLAGS
    if NODE_OF_PORT not in content or number not in content or content[at] > ALL_FLAGS:
        return False
    file = os.open(port, os.O_RDWR)
    try:
        os.pwrite(file, bytes([content[at] & ~PORT_OK]), at)
    finally:
        os.close(file)
    return True
