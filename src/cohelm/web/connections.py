"""Bounds on connections before sign-in: number, time and frames.

A silent or very slow client must not block others, who may want to press STOP; nor may a page that
floods the server with frames that are no messages. Beyond the maximum number of connections, the
one that owes its request for the longest time makes room for the new one: whoever sends a request
at once is served, however many connections are half open. The newest ones are spared, since their
requests may have come and not been read yet. While as many requests are answered as may wait for
their turn, new ones are refused unread, but for STOP and sockets: reading costs most of the time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from cohelm.web.guard import BUSY, MAX_WAITING, STOP_PATH
from cohelm.web.rate_limits import RateLimit

MAX_CONNECTIONS = 200
"""Maximum number of connections."""
MAX_CONNECTIONS_PER_ADDRESS = 64
"""Maximum number of connections from one address: eight pages, and what a browser opens besides."""
SPARED = 48
"""Newest connections without a request that are not dropped: three times as many as are accepted
before those already open are read."""
REQUEST_TIMEOUT = 20.0
"""Maximum time from the beginning of a connection, or from an answer, to a whole request, s."""
ANSWER_TIMEOUT = 60.0
"""Maximum time from the same to the end of the answer, s."""
MAX_FRAME_RATE = 50.0
"""Maximum rate of frames that are no message by themselves, pings and parts, per socket, 1/s."""
_CHECK_PERIOD = 2.0
"""Time between two checks of a connection, s."""
_ALWAYS_READ = (f"POST {STOP_PATH} ".encode(), b"GET /ws")
_UNREAD = (
    b"HTTP/1.1 503 Service Unavailable\r\nconnection: close\r\ncache-control: no-store\r\n"
    b"content-type: application/json\r\ncontent-length: %d\r\n\r\n%s"
) % (len(BUSY.body), BUSY.body)
"""Answer to a request that is refused unread."""


class HttpConnection(H11Protocol):
    """Connection that speaks HTTP, or begins a socket."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # uvicorn narrows it, too
        """Accept it; if there are too many, abort the one that has owed its request for longest.

        While all others are new or get answers, there may be twice as many.
        """
        super().connection_made(transport)
        self._since, self._is_read = self.loop.time(), False
        all_ = [each for each in self.connections if not each.transport.is_closing()]
        here = [each for each in all_ if _host(each) == _host(self)]
        crowd = here if len(here) > MAX_CONNECTIONS_PER_ADDRESS else all_
        late = _late(crowd) if crowd is here or len(all_) > MAX_CONNECTIONS else []
        if late:
            late[0].drop()
        elif len(all_) > 2 * MAX_CONNECTIONS:
            _owing(all_)[0].drop()
        self.loop.call_later(_CHECK_PERIOD, self._check)

    def data_received(self, data: bytes) -> None:
        """Read a request, or refuse the first one of a connection unread."""
        if self._is_read or len(self.tasks) < MAX_WAITING or data.startswith(_ALWAYS_READ):
            self._is_read = True
            super().data_received(data)
        elif not self.transport.is_closing():
            self.transport.write(_UNREAD)
            self.transport.close()

    @property
    def owes_request(self) -> bool:
        """True until a whole request has come, and after its answer."""
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is None or cycle.response_complete or cycle.more_body

    def drop(self) -> None:
        """Make room: an answer that is on its way arrives, all else is aborted."""
        cycle: RequestResponseCycle | None = self.cycle
        if cycle is not None and not self.transport.get_write_buffer_size():
            self.transport.close()
        else:
            self.transport.abort()

    def on_response_complete(self) -> None:
        """Begin the time of the next request."""
        self._since = self.loop.time()
        super().on_response_complete()

    def _check(self) -> None:
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return  # gone, or a socket by now
        cycle: RequestResponseCycle | None = self.cycle
        answering = cycle is not None and not cycle.response_complete
        if self.loop.time() - self._since > (ANSWER_TIMEOUT if answering else REQUEST_TIMEOUT):
            self.transport.abort()
            return
        self.loop.call_later(_CHECK_PERIOD, self._check)


class PageSocket(WebSocketsSansIOProtocol):
    """Socket that a page has opened."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._frames = RateLimit(MAX_FRAME_RATE, self.loop.time())

    def handle_ping(self) -> None:
        """Answer a ping, within the rate limit."""
        if self._accepts():
            super().handle_ping()

    def handle_pong(self, event: Frame) -> None:
        """Take a pong, within the rate limit."""
        if self._accepts():
            super().handle_pong(event)

    def handle_cont(self, event: Frame) -> None:
        """Take a part of a message, within the rate limit."""
        if self._accepts():
            super().handle_cont(event)

    def _accepts(self) -> bool:
        if self._frames.take(self.loop.time()):
            return True
        self.transport.abort()
        return False


def _owing(connections: Iterable[Any]) -> list[HttpConnection]:
    """Connections that owe a request, the oldest first."""
    owing = (each for each in connections if isinstance(each, HttpConnection) and each.owes_request)
    return sorted(owing, key=lambda each: each._since)


def _late(connections: Iterable[Any]) -> list[HttpConnection]:
    """Connections that owe a request, but for the newest ones, the oldest first."""
    return _owing(connections)[:-SPARED]


def _host(connection: Any) -> str:
    client: tuple[str, int] | None = connection.client
    return client[0] if client else ""
