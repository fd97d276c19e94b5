"""A message that is serialised once and then has its numbers written over.

A skin has thousands of points, and rclpy takes some 5 us to turn each into bytes; all that changes
from one message to the next are numbers, at the same places.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class SerialisedMessage:
    """The bytes of a message (CDR), with views of numbers in them."""

    def __init__(self, data: bytes) -> None:
        self._data = bytearray(data)

    def view(self, numbers: NDArray[Any]) -> NDArray[Any]:
        """What stands where these numbers are now; writing to it changes the message.

        Raises ValueError unless the numbers are in the message exactly once.

        >>> message = SerialisedMessage(np.arange(4.0).tobytes())
        >>> message.view(np.array([[1.0, 2.0]]))[:] = 7.0
        >>> np.frombuffer(message.data).tolist()
        [0.0, 7.0, 7.0, 3.0]
        """
        wanted = numbers.tobytes()
        count = self._data.count(wanted)
        if count != 1:
            raise ValueError(f"numbers: expected once in the message, got {count} times")
        start = self._data.find(wanted)
        found = np.frombuffer(self._data, numbers.dtype, numbers.size, start)
        return found.reshape(numbers.shape)

    @property
    def data(self) -> bytes:
        """The message now."""
        return bytes(self._data)
