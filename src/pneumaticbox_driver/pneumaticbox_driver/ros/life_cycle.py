"""Life cycle of the driver, for `ros2 lifecycle` and launch files.

unconfigured: no board; inactive: sensors are read, valves are closed; active: commands are taken.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy._rclpy_pybind11 import RCLError
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from pneumaticbox_driver.safety import one_line

MADE, NOT_MADE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class ManagedNode(LifecycleNode):
    """A lifecycle node whose transitions are functions that raise to refuse.

    A subclass has `connect`, `switch_on`, `switch_off` and `disconnect`.
    """

    connect: Callable[[], object]
    switch_on: Callable[[], object]
    switch_off: Callable[[], object]
    disconnect: Callable[[], object]

    def __init__(self, name: str) -> None:
        super().__init__(name)
        # rclpy raises for a transition that the present state does not have
        service = self._service_change_state
        change = service.callback

        def answer(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except RCLError:
                response.success = False
                self.get_logger().warning(
                    f"change_state: {self.life} has no transition {request.transition.id}"
                )
                return response

        service.callback = answer

    @property
    def life(self) -> str:
        """Name of the present state."""
        return str(self._state_machine.current_state[1])

    def refuse_unconfigured(self) -> None:
        """Raise ValueError when there is no board to switch on."""
        if self.life not in ("inactive", "active"):
            raise ValueError(
                f"the driver is {self.life}: change_state to configure must come first"
            )

    def follow(self, on: bool) -> None:
        """Bring the state up to date after the node was switched `on` or off without a
        transition.
        """
        if on and self.life == "inactive":
            self.trigger_activate()
        elif not on and self.life == "active":
            self.trigger_deactivate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Connect the board."""
        return self._do("configure", self.connect)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Accept commands from now on."""
        return self._do("activate", self.switch_on)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop accepting commands."""
        return self._do("deactivate", self.switch_off)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release the board."""
        return self._do("cleanup", self.disconnect)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release the board; the node cannot be configured again."""
        return self._do("shutdown", self.disconnect)

    def _do(self, what: str, step: Callable[[], object]) -> TransitionCallbackReturn:
        try:
            step()
        except Exception as error:  # noqa: BLE001 boards are not ours, and rclpy tells of no error
            self.get_logger().error(f"{what}: {one_line(error)}")
            return NOT_MADE
        return MADE
