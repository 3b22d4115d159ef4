"""Server of a drive: its socket, its options, and its end by a signal.

A host that other machines can reach needs TLS and a token for drivers.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import functools
import gc
import signal
import socket
import threading
from collections.abc import Callable, Iterable, Iterator

import uvicorn

from cohelm.errors import ConfigError
from cohelm.live import Drive
from cohelm.live.messages import MAX_MESSAGE_SIZE, Role, ToPage
from cohelm.web.app import create_app
from cohelm.web.certificate import Tls
from cohelm.web.connections import HttpConnection, PageSocket
from cohelm.web.origins import is_loopback, origins_for
from cohelm.web.page_files import BuiltPage
from cohelm.web.server_context import ServerContext
from cohelm.web.signin import SignIns

_SEND_BUFFER = 65_536
"""Maximum number of bytes sent ahead of the reader of a connection; older states are useless."""
_ACCEPTED_AT_ONCE = 16
"""Maximum number of connections accepted before those already open are read again."""
_BACKLOG = 2048
"""Maximum number of connections that wait to be accepted; a client beyond it waits for a second."""
_HANDSHAKE_TIMEOUT = 5.0
"""Maximum time for a TLS handshake, s; before it a connection is not counted."""


def listening(host: str, port: int) -> socket.socket:
    """Return a socket bound to ``host``; port 0 takes any that is free.

    Raises:
        ConfigError: This machine has no such host, or the port is taken.
    """
    name = "127.0.0.1" if host.lower() == "localhost" else host.strip("[]")
    try:
        family, kind, _, _, where = socket.getaddrinfo(
            name, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except (OSError, UnicodeError):
        raise ConfigError("this machine has no such address", key=f"--host {host}") from None
    made = socket.socket(family, kind)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        made.bind(where)
    except OSError as cause:
        made.close()
        raise _unbound(host, port, cause) from None
    return made


def make_context(
    drive: Drive,
    page: BuiltPage,
    bound: socket.socket,
    *,
    host: str,
    tokens: dict[Role, str],
    tls: Tls | None = None,
    names: Iterable[str] = (),
    viewers: Iterable[str] = (),
) -> ServerContext:
    """Return the parts of a server of ``drive`` on a bound socket.

    Args:
        drive: Started and closed by the caller.
        page: Files of the page.
        bound: Result of :func:`listening`.
        host: Host of ``bound``.
        tokens: Token of each role; without one for the driver, every client may drive.
        tls: Certificate; None: plain HTTP.
        names: Further names of the server.
        viewers: Origins of viewers.

    Raises:
        ConfigError: Other machines can reach the host, and TLS or the driver's token is missing.
    """
    if not is_loopback(host) and (tls is None or "driver" not in tokens):
        raise ConfigError(
            "others can reach that host: it needs a certificate and a driver's token",
            key=f"--host {host}",
        )
    return ServerContext(
        drive=drive,
        page=page,
        origins=origins_for(host, tls=tls is not None, names=names, viewers=viewers),
        sign_ins=SignIns(tokens),
        port=int(bound.getsockname()[1]),
        open_to_drivers="driver" not in tokens,
    )


def serve(
    what: ServerContext,
    bound: socket.socket,
    tls: Tls | None = None,
    started: Callable[[], None] = lambda: None,
) -> None:
    """Serve until the process gets a signal to end, the drive has no world, or another storey.

    Args:
        what: Parts of the server.
        bound: Socket to listen on; closed at the end.
        tls: Certificate; None: plain HTTP.
        started: Called once the server listens.

    Raises:
        CohelmError: Certificate and key cannot be used, or the first world cannot be built.
    """
    if tls is not None:
        tls.context()
    served = server(what, tls, started)

    def end_with_drive(message: ToPage, client: str | None) -> None:
        if what.drive.failure is not None or what.drive.next_storey is not None:
            served.should_exit = True

    what.drive.listen(end_with_drive)
    if what.drive.failure is None:
        served.run(sockets=[bound])
    if what.drive.failure is not None:
        raise what.drive.failure


def server(
    what: ServerContext, tls: Tls | None = None, started: Callable[[], None] = lambda: None
) -> uvicorn.Server:
    """Return the server, which ends once ``should_exit`` is set."""
    config = uvicorn.Config(
        create_app(what),
        loop="asyncio",  # the same everywhere
        http=HttpConnection,  # the stricter reader
        ws=PageSocket,
        ws_max_size=MAX_MESSAGE_SIZE,
        ws_ping_interval=5.0,
        ws_ping_timeout=10.0,
        ws_per_message_deflate=False,
        lifespan="on",
        log_config=None,
        log_level="error",
        access_log=False,
        proxy_headers=False,
        server_header=False,
        backlog=_ACCEPTED_AT_ONCE,  # asyncio takes it for both; see startup
        timeout_keep_alive=15,
        timeout_graceful_shutdown=3,
        ssl_certfile=None if tls is None else str(tls.certificate),
        ssl_keyfile=None if tls is None else str(tls.key),
    )
    return Server(config, started)


class Server(uvicorn.Server):
    """Server that ends quietly: a signal is no failure."""

    def __init__(self, config: uvicorn.Config, started: Callable[[], None]) -> None:
        super().__init__(config)
        self._then = started

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen with the server's own backlog, and tell that it listens."""
        if self.config.is_ssl:  # uvicorn has no option for it
            loop = asyncio.get_running_loop()
            hasty = functools.partial(loop.create_server, ssl_handshake_timeout=_HANDSHAKE_TIMEOUT)
            setattr(loop, "create_server", hasty)  # noqa: B010  # to replace a method, which mypy refuses
        await super().startup(sockets)
        for each in sockets or ():
            each.listen(_BACKLOG)
        # A search for garbage among everything imported holds all messages for 0.1 to 0.3 s.
        gc.collect()
        gc.freeze()
        self._then()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Shut down, and let garbage be searched again."""
        await super().shutdown(sockets)
        gc.unfreeze()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """End the server by a signal, without raising it again afterwards."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {each: signal.signal(each, self.handle_exit) for each in _ENDING}
        try:
            yield
        finally:
            for each, handler in before.items():
                signal.signal(each, handler)


_ENDING = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Signals that end the server: interrupt, termination, closed terminal."""


def _unbound(host: str, port: int, cause: OSError) -> ConfigError:
    if cause.errno == errno.EADDRINUSE:
        return ConfigError("is taken; name another, or 0 for any", key=f"--port {port}")
    if cause.errno == errno.EACCES:
        return ConfigError(
            "may not be taken by this user; name one above 1023", key=f"--port {port}"
        )
    if cause.errno == errno.EADDRNOTAVAIL:
        return ConfigError("this machine has no such address", key=f"--host {host}")
    return ConfigError(f"cannot be listened on ({cause.strerror})", key=f"--host {host}")
