"""Access control: a request needs the token of this start and must come from this page.

Any web page in the user's browser can send requests to servers of this machine. Three checks keep
them out: the header `Host` must name this server (against DNS rebinding), the header `Origin` must
be that of the page itself, and the path must begin with a token that is random for each start.
viser's unmodified client opens its websocket below the path of the page and so sends the token.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
import socket
from dataclasses import dataclass, field

from websockets.http11 import Request

from softhand_common.documents.quoted import quoted

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
HOST_HEADER = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:[0-9]{1,5})?", re.IGNORECASE)
TOKEN_LENGTH = 24  # [bytes]


@dataclass(frozen=True)
class Access:
    """Checks requests to a server; `host` is the address or name on which it listens."""

    host: str
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_LENGTH), repr=False)

    @property
    def is_local(self) -> bool:
        """Whether the server can be reached from this machine only."""
        return _is_loopback(self.host)

    def address(self, port: int) -> str:
        """The address to open in the browser."""
        name = f"[{self.host}]" if ":" in self.host else self.host
        if _is_wildcard(self.host):
            name = "127.0.0.1"
        return f"http://{name}:{port}/{self.token}/"

    def inner_path(self, path: str) -> str | None:
        """A request's path without token and query; None when the token is missing or wrong."""
        _, _, below = path.partition("?")[0].partition("/")
        given, _, rest = below.partition("/")
        same = secrets.compare_digest(given.encode(errors="surrogateescape"), self.token.encode())
        return f"/{rest}" if same else None

    def refusal(self, request: Request) -> str:
        """Why a request is refused; "" if it is accepted."""
        hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return f"Host: expected the address of this page, got {quoted(' '.join(hosts))}"
        own = [f"{scheme}://{hosts[0]}".lower() for scheme in ("http", "https")]
        opens_websocket = "Upgrade" in request.headers
        if (origins or opens_websocket) and (len(origins) != 1 or origins[0].lower() not in own):
            return f"Origin: expected {own[0]}, got {quoted(' '.join(origins))}"
        if self.inner_path(request.path) is None:
            return "token: expected the address that softhand-play printed, got another"
        return ""

    def _is_own(self, given: str) -> bool:
        """Whether a header `Host` names this server. If other machines can reach it, any IP address
        is accepted, as DNS rebinding works only with names.
        """
        found = HOST_HEADER.fullmatch(given)
        if found is None:
            return False
        name = found[1].lower()
        if name in LOOPBACK or name.strip("[]") == self.host.lower():
            return True
        return not self.is_local and (_is_address(name) or name == socket.gethostname().lower())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def _is_loopback(host: str) -> bool:
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_wildcard(host: str) -> bool:
    return _is_address(host) and ipaddress.ip_address(host).is_unspecified
