"""Boards: valves and sensors that the driver's process uses directly, and their opening."""

from collections.abc import Callable
from typing import Any, Protocol

from pneumaticbox_driver.arrays import Floats, Valves
from pneumaticbox_driver.settings import BoxSettings, outlet_numbers

Value = Callable[[str], Any]


class Board(Protocol):
    """Valves and sensors of n channels, which the driver's loop reads and commands in turn.

    For a missing device the constructor raises ValueError or OSError with a message that names the
    device, before any valve is switched.
    """

    @property
    def time(self) -> float:
        """Time of the last reading on a monotonic clock [s]; NaN before the first."""
        ...

    def read(self) -> Floats:
        """Read absolute pressures of the channels, then of the supply (n + 1,) [Pa]; NaN for a
        sensor that cannot be read.

        Raises:
            ValueError, OSError: the board has failed.
        """
        ...

    def command(self, valves: Valves) -> None:
        """Switch the valves (n,): +1 inflate, -1 deflate, 0 closed; raises as `read` does."""
        ...

    def close(self) -> None:
        """Open the outlets and release the devices."""
        ...


def open_board(backend: str, settings: BoxSettings, value: Value) -> Board | None:
    """Open the board of a backend.

    Args:
        backend: value of the parameter `backend`.
        settings: settings of the box.
        value: returns a parameter's value by its name.

    Returns:
        The board; None for the backend topic, whose plant is another node.

    Raises:
        ValueError, OSError: parameters or files cannot be used, or a device is missing; no valve
            has been switched then.
    """
    opener = OPENERS.get(backend)
    return None if opener is None else opener(settings, value)


def _open_embedded(settings: BoxSettings, value: Value) -> Board:
    """The simulated box, with bottles of the rest volumes or with the actuators of the hand."""
    from pneumaticbox_driver.backends.embedded import EmbeddedBoard, EmbeddedRig
    from softhand_model.chain.volumes import FreeActuators
    from softhand_model.hand.hand import load_hand
    from softhand_model.pneumatics import load_pneumatics

    plant = value("embedded_plant")
    parameters = load_pneumatics(plant) if plant else None
    of_hand = settings.volume_model == "hand"
    volumes = FreeActuators(load_hand(settings.hand)) if of_hand else settings.rest_volumes
    seed = value("embedded_seed")
    board = EmbeddedBoard(EmbeddedRig(settings.channels, volumes, parameters, seed))
    if value("embedded_supply") > 0:
        board.set_supply(value("embedded_supply"))
    return board


def _open_hardware(settings: BoxSettings, value: Value) -> Board:
    """The box of the file in the parameter hardware_file."""
    from pneumaticbox_driver.backends.hardware.opening import open_rig

    path = value("hardware_file")
    if not path:
        raise ValueError("hardware_file must be the path of a hardware file, got none")
    outlets = outlet_numbers(value("outlets"), len(settings.channels))
    allowed = value("allow_board_module")
    return open_rig(path, outlets, settings.ambient, allow_board_module=allowed)


OPENERS: dict[str, Callable[[BoxSettings, Value], Board]] = {
    "embedded": _open_embedded,
    "hardware": _open_hardware,
}
