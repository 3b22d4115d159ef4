"""Bounds on connections before sign-in: number, time and frames.

Who opens connections and says nothing, or says it a letter at a time, must not keep out whoever
wants to press STOP; nor may a page that floods the server with frames that are no messages.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from cohelm.web.rate_limits import RateLimit

MAX = 200
"""Connections at once …"""
MAX_EACH = 64
"""… and of them from one address: eight pages, and what a browser opens besides."""
SAID_WITHIN = 20.0
"""From the beginning of a connection, or from an answer, until a request is there, s."""
TAKEN_WITHIN = 60.0
"""The same until its answer has been taken, s."""
FRAMES = 50.0
"""A second and socket, of those that are no message by themselves: pings, and parts."""
_LOOKS = 2.0
"""Between two looks at a connection, s."""


class HttpConnection(H11Protocol):
    """One that speaks HTTP, or begins a socket."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as its own
        """Let it in where there is room."""
        super().connection_made(transport)
        self._since = self.loop.time()
        here = [_host(each) for each in self.connections].count(_host(self))
        if len(self.connections) > MAX or here > MAX_EACH:
            transport.abort()
            return
        self.loop.call_later(_LOOKS, self._look)

    def on_response_complete(self) -> None:
        """The next request has its own time."""
        self._since = self.loop.time()
        super().on_response_complete()

    def _look(self) -> None:
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return  # gone, or a socket by now
        cycle: RequestResponseCycle | None = self.cycle
        asks = cycle is not None and not cycle.response_complete
        if self.loop.time() - self._since > (TAKEN_WITHIN if asks else SAID_WITHIN):
            self.transport.abort()
            return
        self.loop.call_later(_LOOKS, self._look)


class PageSocket(WebSocketsSansIOProtocol):
    """One that a page has opened."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._frames = RateLimit(FRAMES, self.loop.time())

    def handle_ping(self) -> None:
        """Answer it; few are enough."""
        if self._accepts():
            super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """Take note of it."""
        if self._accepts():
            super().handle_pong(event)

    def handle_cont(self, event: Frame) -> None:
        """Put a message together, of few parts."""
        if self._accepts():
            super().handle_cont(event)

    def _accepts(self) -> bool:
        if self._frames.take(self.loop.time()):
            return True
        self.transport.abort()
        return False


def _host(connection: Any) -> str:
    client: tuple[str, int] | None = connection.client
    return client[0] if client else ""
