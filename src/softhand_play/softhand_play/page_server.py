"""The page's server: viser's server, with a check of each request and message from a browser.

This is the only module that uses private parts of viser. They are those of viser 1.1.1, to which
`setup.py` and VISER_VERSION pin it; if an installed viser lacks them, the server does not start.
"""

from __future__ import annotations

import contextlib
import errno
import io
import math
import socket
import threading
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from dataclasses import replace
from http import HTTPStatus
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import viser
import websockets
import websockets.asyncio.server
import websockets.exceptions
from viser import _messages as messages
from viser.infra import _infra
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from softhand_common.documents.quoted import quoted, shortened
from softhand_play.access import Access
from softhand_play.widgets import refusal as widget_refusal

VISER_VERSION = "1.1."  # start of the version
GUI_API_NAMES = ("_gui_input_handle_from_uuid", "_current_file_upload_states")  # of viser's GuiApi
LARGEST_MESSAGE = 2**22  # [bytes]; viser's client sends files in parts of 2**19
LARGEST_UPLOAD = 500_000_000  # [bytes] of all files in transfer
SMALLEST_PART = 2**10  # [bytes] of a file, on average
LONGEST_FILE_NAME = 255  # characters
WRIST_REACH = 2.0  # of the wrist's target along each axis [m], as in the simulator's node
HANDLE_LENGTH_ERROR = 1e-3  # by which the length of a quaternion may differ from 1
POLICY_VIOLATION = 1008  # websocket close code
MALFORMED = (  # what viser raises for malformed messages
    AssertionError,
    AttributeError,
    LookupError,
    RuntimeError,
    TypeError,
    ValueError,
    msgspec.MsgspecError,
)
_starting = threading.Lock()
Handler = Callable[[ServerConnection], Awaitable[None]]
Answer = Callable[[ServerConnection, Request], Response | None]


class PageServer(viser.ViserServer):
    """A viser server that accepts only requests which `Access` allows, and checks all messages.

    Args:
        host, port: address and port on which it listens; port 0: any free port.
        label: title of the panel.
        refused: called with a sentence on what was expected and what a browser sent.
        accepted: called when a browser has set a widget to an allowed value.

    Raises ValueError for an address on which it cannot listen, RuntimeError for another version of
    viser.
    """

    def __init__(
        self,
        host: str,
        port: int,
        label: str,
        refused: Callable[[str], None],
        accepted: Callable[[], None],
    ) -> None:
        _check_viser()
        self.access = Access(host)
        self._refused, self._accepted = refused, accepted
        self.uploaded: Callable[[viser.UploadedFile], object] = _nothing  # called for each file
        listening = _listen(host, port)
        with _hooked(self._serve, listening), contextlib.redirect_stdout(io.StringIO()):
            super().__init__(host, port, label=label, verbose=False)
        missing = [name for name in GUI_API_NAMES if not hasattr(self.gui, name)]
        if missing:
            raise RuntimeError(f"viser {viser.__version__}: expected GuiApi.{missing[0]}, got none")
        server = self._websock_server
        self._pass_on = server._handle_incoming_message
        server._handle_incoming_message = self._check_message  # type: ignore[method-assign]

    @property
    def address(self) -> str:
        """The address to open in the browser, with the token of this start."""
        return self.access.address(self.get_port())

    def run_script(self, source: str) -> None:
        """Run a script in each browser."""
        self._websock_server.queue_message(messages.RunJavascriptMessage(source=source))

    # ---------------------------------------------------------------- requests
    def _serve(
        self, listening: socket.socket, handler: Handler, answer: Answer, options: dict[str, Any]
    ) -> Any:
        """Serve viser's handlers by `websockets`, with our checks, on a listening socket."""

        async def handle(connection: ServerConnection) -> None:
            try:
                await handler(connection)
            except MALFORMED as error:  # ends only this connection
                got = f"{type(error).__name__}: {shortened(str(error))}"
                self._refused(f"browser: expected a message of viser's client, got {got}")
                await connection.close(POLICY_VIOLATION)

        def respond(connection: ServerConnection, request: Request) -> Response | None:
            reason = self.access.refusal(request)
            if reason:
                return connection.respond(HTTPStatus.FORBIDDEN, f"{reason}\n")
            inner = self.access.inner_path(request.path)
            response = answer(connection, replace(request, path=inner or ""))
            if response is not None:
                response.headers["Referrer-Policy"] = "no-referrer"  # a referrer has the token
                response.headers["X-Frame-Options"] = "DENY"
            return response

        options |= {"max_size": LARGEST_MESSAGE, "process_request": respond}
        return websockets.asyncio.server.serve(handle, sock=listening, **options)

    # ---------------------------------------------------------------- messages
    def _check_message(self, client_id: Any, message: Any) -> Coroutine[Any, Any, None]:
        """Check that the fields of a message have their types, before viser makes tasks for it:
        what is raised here ends the connection.
        """
        msgspec.convert(vars(message), type(message))
        return self._pass_message(client_id, message)

    async def _pass_message(self, client_id: Any, message: Any) -> None:
        """Pass a message on to viser, or say why not."""
        reason = self._refusal(message)
        if reason:
            self._refused(reason)
            return
        if isinstance(message, messages.GuiUpdateMessage):
            self._accepted()
        uploads = isinstance(message, messages.FileTransferStartUpload | messages.FileTransferPart)
        begins = isinstance(message, messages.FileTransferStartUpload)
        was_open = begins or (uploads and message.transfer_uuid in self._uploads())
        await self._pass_on(client_id, message)
        if was_open and message.transfer_uuid not in self._uploads():  # it is complete
            button = self.gui._gui_input_handle_from_uuid.get(message.source_component_uuid)
            if isinstance(button, viser.GuiUploadButtonHandle):
                self.uploaded(button.value)

    def _refusal(self, message: Any) -> str:
        """Why a message is refused; "" for an accepted one."""
        checks: dict[type, Callable[[Any], str]] = {
            messages.GuiUpdateMessage: self._refused_update,
            messages.FileTransferStartUpload: self._refused_upload,
            messages.FileTransferPart: self._refused_part,
            messages.TransformControlsUpdateMessage: _refused_pose,
            messages.TransformControlsDragStartMessage: _nothing,
            messages.TransformControlsDragEndMessage: _nothing,
            messages.SceneNodeClickMessage: _nothing,
            messages.ViewerCameraMessage: _nothing,
        }
        check = checks.get(type(message))
        if check is None:
            return f"browser: expected a message of a widget, got {type(message).__name__}"
        return check(message)

    def _refused_update(self, message: Any) -> str:
        widget = self.gui._gui_input_handle_from_uuid.get(message.uuid)
        if widget is None:  # it has been removed
            return ""
        if not isinstance(message.updates, dict) or list(message.updates) != ["value"]:
            return f"{widget.label}: expected a value alone, got {quoted(message.updates)}"
        return widget_refusal(widget, message.updates["value"])

    def _refused_upload(self, message: Any) -> str:
        name, size, parts = message.filename, message.size_bytes, message.part_count
        button = self.gui._gui_input_handle_from_uuid.get(message.source_component_uuid)
        if not isinstance(button, viser.GuiUploadButtonHandle):
            return "file: expected an upload to the button that opens files, got another"
        if not isinstance(name, str) or len(name) > LONGEST_FILE_NAME:
            most = f"at most {LONGEST_FILE_NAME} characters"
            return f"file: expected a name of {most}, got {quoted(name)}"
        coming = sum(each["total_bytes"] for each in self._uploads().values())
        if not 0 <= size <= LARGEST_UPLOAD - coming:
            most = f"at most {LARGEST_UPLOAD / 1e6:g} MB at a time"
            return f"{shortened(name)}: expected {most}, got {size / 1e6:g} MB"
        if not 0 <= parts <= 1 + size // SMALLEST_PART or message.transfer_uuid in self._uploads():
            return f"{shortened(name)}: expected a new file in large parts, got {parts} parts"
        return ""

    def _refused_part(self, message: Any) -> str:
        upload = self._uploads().get(message.transfer_uuid)
        if upload is None:  # it was refused before
            return ""
        content, name = message.content, shortened(upload["filename"])
        if not isinstance(content, bytes):
            return f"{name}: expected bytes, got {type(content).__name__}"
        if upload["transferred_bytes"] + len(content) > upload["total_bytes"]:
            del self._uploads()[message.transfer_uuid]
            return f"{name}: expected {upload['total_bytes']} bytes, got more"
        return ""

    def _uploads(self) -> dict[str, Any]:
        """Files in transfer."""
        return self.gui._current_file_upload_states


def _nothing(_: Any) -> str:
    return ""


def _refused_pose(message: Any) -> str:
    try:
        place, turn = np.array(message.position, float), np.array(message.wxyz, float)
    except (TypeError, ValueError):
        return "handle: expected numbers, got something else"
    if place.shape != (3,) or not (np.abs(place) <= WRIST_REACH).all():
        return f"handle: expected a place within {WRIST_REACH:g} m of 0 along x, y, z, got {place}"
    if turn.shape != (4,) or not abs(math.hypot(*turn) - 1.0) <= HANDLE_LENGTH_ERROR:
        return f"handle: expected a quaternion of length 1, got {turn}"
    return ""


def _listen(host: str, port: int) -> socket.socket:
    """A socket that listens on an address."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        found = socket.socket(family, kind, protocol)
    except OSError as reason:
        raise ValueError(
            f"host: expected an address or a name of this machine, got {quoted(host)}: "
            f"{reason.strerror}"
        ) from reason
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen()
    except OSError as reason:
        found.close()
        if reason.errno == errno.EADDRINUSE:
            raise ValueError(f"port: expected a free port, got {port}, which is in use") from reason
        raise ValueError(
            f"host, port: expected an address to listen on, got {quoted(host)}, {port}: "
            f"{reason.strerror}"
        ) from reason
    return found


@contextlib.contextmanager
def _hooked(serve: Callable[..., Any], listening: socket.socket) -> Iterator[None]:
    """While viser starts, have it call `serve`, as it has no public way to check requests: only
    viser's module gets a `websockets` with another `serve`.
    """
    called = False

    def instead(handler: Handler, host: str, port: int, **options: Any) -> Any:
        nonlocal called
        called = True
        return serve(listening, handler, options["process_request"], options)

    ours = SimpleNamespace(**vars(websockets.asyncio.server) | {"serve": instead})
    seen = SimpleNamespace(**vars(websockets) | {"asyncio": SimpleNamespace(server=ours)})
    with _starting:
        before, _infra.websockets = _infra.websockets, seen  # type: ignore[assignment]
        try:
            yield
        finally:
            _infra.websockets = before
    if not called:
        raise RuntimeError(f"viser {viser.__version__}: expected a server that uses websockets")


def _check_viser() -> None:
    """Raise RuntimeError unless the installed viser has the supported version."""
    if not viser.__version__.startswith(VISER_VERSION):
        raise RuntimeError(f"viser: expected version {VISER_VERSION}x, got {viser.__version__}")
