"""Settings of Fast DDS and of the heap, and what killed processes left of shared memory.

By default Fast DDS keeps buffers of the size of the largest message so far, and glibc keeps freed
memory in its heaps.
"""

from __future__ import annotations

import contextlib
import ctypes
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
INITIALIZATION_LIMIT = 5.0  # a living process is done in less than a millisecond [s]


def set_up_middleware() -> None:
    """Set up this process; call it before rclpy.init. A Fast DDS profile of the user is kept.

    Removes segments of shared memory whose creators were killed while they initialised them.
    """
    if not any(name in os.environ for name in PROFILE_VARIABLES):
        os.environ[PROFILE_VARIABLES[-1]] = str(PROFILE)
        os.environ["RMW_FASTRTPS_USE_QOS_FROM_XML"] = "1"
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # of glibc
    if mallopt is not None:
        mallopt(MMAP_THRESHOLD, MAPPED_BLOCK)
        mallopt(ARENA_MAX, 1)
    remove_unfinished_segments()


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
