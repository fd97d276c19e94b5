"""Settings of Fast DDS and of the heap: quick discovery of late nodes, and freed memory returned.

By default Fast DDS keeps buffers of the size of the largest message so far, and glibc keeps freed
memory in its heaps.
"""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

PROFILE = Path(__file__).parent / "fast_dds.xml"
PROFILE_VARIABLES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
MMAP_THRESHOLD, ARENA_MAX = -3, -8  # of mallopt(3)
MAPPED_BLOCK = 128 * 1024  # [bytes]; larger blocks are mapped, and unmapped when they are freed


def set_up_middleware() -> None:
    """Set up this process; call it before rclpy.init. A Fast DDS profile of the user is kept."""
    if not any(name in os.environ for name in PROFILE_VARIABLES):
        os.environ[PROFILE_VARIABLES[-1]] = str(PROFILE)
        os.environ["RMW_FASTRTPS_USE_QOS_FROM_XML"] = "1"
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)  # of glibc
    if mallopt is not None:
        mallopt(MMAP_THRESHOLD, MAPPED_BLOCK)
        mallopt(ARENA_MAX, 1)
