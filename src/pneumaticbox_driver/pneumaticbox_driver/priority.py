"""Real-time priority for the control loop, where the system grants it (section 4.3)."""

import os


def set_priority(priority: int) -> bool:
    """Run this process with a fixed real-time priority, ahead of all ordinary ones.

    Args:
        priority: of SCHED_FIFO, 1 to 99; 0 goes back to ordinary scheduling.

    Returns:
        Whether the system granted it; on Linux that needs root or a limit `rtprio`.

    >>> set_priority(0)
    True
    """
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except PermissionError:
        return False
    return True
