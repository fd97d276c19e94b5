"""Set-up of Fast DDS and of the heap: late joiners are found soon, and memory is given back.

Fast DDS keeps buffers as large as the largest message there was, and glibc keeps what was freed
from its heaps, unless they are told otherwise.
"""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

PROFILE = Path(__file__).parent / "fast_dds.xml"
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
MMAP_THRESHOLD, ARENA_MAX = -3, -8  # of mallopt(3)
LARGE = 128 * 1024  # [bytes]; larger blocks are mapped, and unmapped when they are freed


def set_up_middleware() -> None:
    """Set up this process before rclpy.init; a profile of Fast DDS that the user has set stands."""
    if not any(name in os.environ for name in PROFILES):
        os.environ[PROFILES[-1]] = str(PROFILE)
        os.environ["RMW_FASTRTPS_USE_QOS_FROM_XML"] = "1"
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # of glibc
    if mallopt is not None:
        mallopt(MMAP_THRESHOLD, LARGE)
        mallopt(ARENA_MAX, 1)
