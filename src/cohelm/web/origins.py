"""Host and origin checks of requests, and the names and addresses of the server.

A foreign site may point its own name at this machine (DNS rebinding): the ``Host`` is wrong then. A
foreign page may call this machine by its right name: the ``Origin`` is wrong then. Both are checked
in every request and at the beginning of every socket.
"""

from __future__ import annotations

import ipaddress
import json
import socket
import urllib.parse
from collections.abc import Iterable

from cohelm.arrays import value
from cohelm.errors import ConfigError

LOOPBACK = ("localhost", "127.0.0.1", "::1")
_CHANGING = frozenset({"POST", "PUT", "PATCH", "DELETE"})
_OWN_SITES = frozenset({"same-origin", "none"})
_PAGES = frozenset({"/", "/therapist"})
"""Paths to which a link on another site may lead."""

VIEWER_PATH = "/foxglove"
"""Path of the socket of viewers."""

Headers = Iterable[tuple[bytes, bytes]]


@value
class Refusal:
    """Refusal of a request: HTTP status, stable code, and text."""

    status: int
    code: str
    text: str

    @property
    def body(self) -> bytes:
        """Answer as JSON."""
        return json.dumps({"code": self.code, "text": self.text}).encode()


@value
class Origins:
    """Names of the server."""

    names: frozenset[str]
    """In lower case, without brackets and port."""
    tls: bool = False
    viewers: frozenset[str] = frozenset()
    """Origins of viewers, as ``https://app.foxglove.dev``; empty: there are none."""
    any_address: bool = False
    """True if the server listens on all addresses of the machine: then each is a name as well."""

    def refusal(
        self,
        headers: Headers,
        *,
        method: str = "GET",
        path: str = "/",
        is_socket: bool = False,
        local: str = "",
    ) -> Refusal | None:
        """Return the reason to refuse a request; None: it is accepted.

        Args:
            headers: ASGI headers, names in lower case.
            method: HTTP method.
            path: Path of the request.
            is_socket: True for the beginning of a WebSocket.
            local: Address of this machine to which the request was sent.
        """
        given = _by_name(headers)
        hosts = given.get("host", [])
        if len(hosts) != 1:
            return Refusal(status=400, code="host", text="a request names one host")
        if not self._is_own(hosts[0], local):
            text = "this server does not go by that name; use the address that it printed"
            return Refusal(status=421, code="host", text=text)
        foreign = Refusal(status=403, code="origin", text="only the chair's own page may do this")
        origins = given.get("origin", [])
        if path == VIEWER_PATH and self.viewers:
            known = len(origins) == 1 and origins[0].lower() in self.viewers
            return None if is_socket and known else foreign
        changes = is_socket or method in _CHANGING
        if len(origins) > 1 or (not origins and changes):
            return foreign
        scheme = "https" if self.tls else "http"
        elsewhere = origins and origins[0].lower() != f"{scheme}://{hosts[0].lower()}"
        site = given.get("sec-fetch-site", ["none"])
        linked = site[0] not in _OWN_SITES and path not in _PAGES
        return foreign if elsewhere or linked else None

    def _is_own(self, host: str, local: str) -> bool:
        name = name_of(host)
        return name in self.names or (self.any_address and bool(name) and name == plain(local))


def origins_for(
    host: str, *, tls: bool, names: Iterable[str] = (), viewers: Iterable[str] = ()
) -> Origins:
    """Return the names of a server that listens on ``host``, and of ``names``.

    Args:
        host: Host to listen on.
        tls: True for HTTPS.
        names: Further names.
        viewers: Origins of viewers.

    Raises:
        ConfigError: One of the viewers is no origin.
    """
    viewers = [_origin(each) for each in viewers]
    everywhere = is_everywhere(host)
    own = {*LOOPBACK, *(name.lower() for name in names)}
    if not everywhere:
        own.add(plain(host))
    return Origins(
        names=frozenset(own),
        tls=tls,
        viewers=frozenset(viewers),
        any_address=everywhere,
    )


def _origin(given: str) -> str:
    """An origin of a viewer as a browser writes it."""
    parts = urllib.parse.urlsplit(given.lower())
    if not (parts.scheme and parts.netloc) or parts.path.strip("/") or parts.query:
        problem = f"{given} is no address of a site, as https://app.foxglove.dev"
        raise ConfigError(problem, key="--viewer")
    return f"{parts.scheme}://{parts.netloc}"


def is_loopback(host: str) -> bool:
    """Check that a host to listen on is a loopback address."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(plain(host)).is_loopback
    except ValueError:
        return False


def is_everywhere(host: str) -> bool:
    """Check that a host to listen on stands for every address of the machine."""
    try:
        return ipaddress.ip_address(plain(host)).is_unspecified
    except ValueError:
        return False


def plain(host: str) -> str:
    """Return a name in lower case without brackets; an IPv4 address in IPv6 form becomes IPv4."""
    bare = host.strip("[]").lower()
    try:
        address = ipaddress.ip_address(bare)
    except ValueError:
        return bare
    mapped = getattr(address, "ipv4_mapped", None)
    return str(mapped or address)


def name_of(host: str) -> str:
    """Return the name in a ``Host`` header; empty if there is none or its port is no number."""
    if host.startswith("["):
        name, bracket, rest = host[1:].partition("]")
        colon, port = rest[:1], rest[1:]
        if not bracket or (rest and colon != ":"):
            return ""
    else:
        name, colon, port = host.partition(":")
    if colon and not (port.isascii() and port.isdigit()):
        return ""
    return plain(name)


def _by_name(headers: Headers) -> dict[str, list[str]]:
    given: dict[str, list[str]] = {}
    for name, text in headers:
        given.setdefault(name.decode("latin-1").lower(), []).append(text.decode("latin-1"))
    return given


_EXAMPLE_ADDRESS = ("192.0.2.1", 9)
"""Address reserved for documentation; connecting a UDP socket to it sends nothing."""


def names_of(host: str) -> tuple[str, ...]:
    """Return the names and addresses for which a certificate of a server on ``host`` must be valid.

    The first is the one to print.
    """
    if is_loopback(host):
        first = "127.0.0.1" if host.lower() == "localhost" else plain(host)
        return tuple(dict.fromkeys((first, *LOOPBACK)))
    if not is_everywhere(host):
        return (plain(host),)
    found = (own_address(), socket.gethostname().lower(), *LOOPBACK)
    return tuple(dict.fromkeys(name for name in found if name))


def own_address() -> str:
    """Return the address of this machine in its network; empty if it has none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        try:
            asked.connect(_EXAMPLE_ADDRESS)
        except OSError:
            return ""
        return str(asked.getsockname()[0])


def address(name: str, port: int, *, tls: bool) -> str:
    """Return the URL for a browser, without a trailing slash."""
    scheme, usual = ("https", 443) if tls else ("http", 80)
    try:
        bare = f"[{name}]" if ipaddress.ip_address(name).version == 6 else name
    except ValueError:
        bare = name
    return f"{scheme}://{bare}" + ("" if port == usual else f":{port}")
