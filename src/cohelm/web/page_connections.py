"""The open pages: one socket each, what waits to be told to it, and what it may say.

What a page says goes to the drive, checked and counted; what the drive tells comes from threads of
its own and is handed over to the server's. States are never queued: a page that does not read in
time misses some, and gets the newest.
"""

from __future__ import annotations

import asyncio
import contextlib
import enum
import secrets
import threading
import time
from collections import Counter, deque
from typing import Any

from pydantic import ValidationError
from starlette.websockets import WebSocket, WebSocketDisconnect

from cohelm.live import Drive
from cohelm.live.messages import FROM_PAGE, ChairState, FromPage, Heartbeat, Rejected, ToPage
from cohelm.web.origins import Refusal
from cohelm.web.rate_limits import HEARTBEATS, MESSAGES, FaultLimit, RateLimit
from cohelm.web.signin import Session

MAX = 16
"""Pages at once."""
MAX_EACH = 8
"""Of them from one address."""
ARRIVALS = 20.0
"""New pages a second."""
MAX_WAITING = 256
"""Messages other than states that wait for a page."""
READ_WITHIN = 5.0
"""A page takes what is sent to it, s."""


class CloseCode(enum.IntEnum):
    """Why the server closed a page's socket; 1009 is a message too long, 1012 the server's end."""

    FAULT = 1011
    """A fault of the server's own."""
    MALFORMED = 4400
    """One message after another that is none."""
    SIGNED_OUT = 4401
    """The session has ended."""
    SLOW = 4408
    """It does not read what it is told."""
    TOO_MANY = 4429
    """It says too much."""


class PageConnection:
    """One socket, and its two ways. Belongs to the server's thread."""

    def __init__(self, socket: WebSocket, session: Session, now: float) -> None:
        self.client = f"page-{secrets.token_hex(4)}"
        self.session = session
        self._socket = socket
        self._heartbeats, self._all = RateLimit(HEARTBEATS, now), RateLimit(MESSAGES, now)
        self._faults = FaultLimit(now)
        self._waiting: deque[str] = deque()
        self._state: str | None = None
        self._wake = asyncio.Event()
        self.over: asyncio.Future[CloseCode | None] = asyncio.get_running_loop().create_future()

    def tell(self, text: str, *, state: bool = False) -> None:
        """Send when the page takes it; a state takes the place of one that still waits."""
        if state:
            self._state = text
        elif len(self._waiting) < MAX_WAITING:
            self._waiting.append(text)
        else:
            self.end(CloseCode.SLOW)
        self._wake.set()

    def end(self, code: CloseCode | None) -> None:
        """Close the socket, with a code where it is still open."""
        if not self.over.done():
            self.over.set_result(code)

    async def send(self) -> None:
        """Tell what is to be told, until cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while (text := self._next()) is not None:
                try:
                    async with asyncio.timeout(READ_WITHIN):
                        await self._socket.send_text(text)
                except TimeoutError:
                    self.end(CloseCode.SLOW)
                    return

    async def listen(self, drive: Drive) -> None:
        """Hand what the page says to the drive, until it may not any more or is gone."""
        while not self.over.done():
            event = await self._socket.receive()
            now = time.monotonic()
            if event["type"] != "websocket.receive":
                self.end(None)
            elif now >= self.session.ends:
                self.end(CloseCode.SIGNED_OUT)
            elif not self._all.take(now):
                self.end(CloseCode.TOO_MANY)
            elif (message := self._understood(event.get("text"), now)) is None:
                pass
            elif isinstance(message, Heartbeat) and not self._heartbeats.take(now):
                self.end(CloseCode.TOO_MANY)
            else:
                drive.receive(self.client, message, now)

    def _understood(self, text: str | None, now: float) -> FromPage | None:
        try:
            return FROM_PAGE.validate_json(text or "", strict=True)
        except ValidationError as fault:
            refused = Rejected(code="malformed", text=_first(fault))
        self.tell(refused.model_dump_json())
        if not self._faults.add(now):
            self.end(CloseCode.MALFORMED)
        return None

    def _next(self) -> str | None:
        if self._waiting:
            return self._waiting.popleft()
        text, self._state = self._state, None
        return text


class PageConnections:
    """All open pages of a drive. Belongs to the server's thread, but for what the drive calls."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._pages: dict[str, PageConnection] = {}
        self._addresses: Counter[str] = Counter()
        self._arrivals = RateLimit(ARRIVALS, time.monotonic())
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._lock = threading.Lock()
        self._newest: ChairState | None = None
        drive.listen(self._told)

    def refusal(self, address: str, now: float) -> Refusal | None:
        """Why there is no room for one more page from here; None: there is."""
        if self._addresses.total() >= MAX or self._addresses[address] >= MAX_EACH:
            return Refusal(status=503, code="full", text="too many pages are open; close one")
        if not self._arrivals.take(now):
            return Refusal(status=429, code="too_many", text="too many pages at once; try again")
        return None

    async def serve(self, socket: WebSocket, session: Session, address: str) -> None:
        """One page from its beginning to its end."""
        self._addresses[address] += 1
        try:
            await socket.accept()
            await self._serve(socket, PageConnection(socket, session, time.monotonic()))
        finally:
            self._addresses[address] -= 1
            self._addresses += Counter()  # forgets who has none

    async def _serve(self, socket: WebSocket, page: PageConnection) -> None:
        self._pages[page.client] = page
        self._drive.connect(page.client, page.session.role)
        ways = [asyncio.create_task(page.send()), asyncio.create_task(page.listen(self._drive))]
        try:
            both: list[asyncio.Future[Any]] = [page.over, *ways]
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                if way.done() and (fault := way.exception()) is not None:
                    page.end(None if isinstance(fault, WebSocketDisconnect) else CloseCode.FAULT)
                    if not isinstance(fault, WebSocketDisconnect):
                        raise fault
            page.end(None)
        finally:
            del self._pages[page.client]
            self._drive.disconnect(page.client)
            for way in ways:
                way.cancel()
            code = page.over.result() if page.over.done() else CloseCode.FAULT
            if code is not None:
                self._drive.audit.log_event(page.client, "rejected", closed=code.name.lower())
                with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                    await socket.close(code, code.name.lower())

    def end(self, session: Session) -> None:
        """Close all pages of a session."""
        for page in self._pages.values():
            if page.session is session:
                page.end(CloseCode.SIGNED_OUT)

    def _told(self, message: ToPage, client: str | None) -> None:
        """Deliver a message of the drive, called in any thread."""
        if threading.get_ident() == self._thread:
            self._deliver(message, client)
            return
        with contextlib.suppress(RuntimeError):  # the server has ended
            if not isinstance(message, ChairState) or client is not None:
                self._loop.call_soon_threadsafe(self._deliver, message, client)
                return
            with self._lock:
                waits, self._newest = self._newest is not None, message
            if not waits:
                self._loop.call_soon_threadsafe(self._deliver_newest)

    def _deliver_newest(self) -> None:
        with self._lock:
            message, self._newest = self._newest, None
        if message is not None:
            self._deliver(message, None)

    def _deliver(self, message: ToPage, client: str | None) -> None:
        if client is None:
            to = list(self._pages.values())
        else:
            to = [self._pages[client]] if client in self._pages else []
        if to:
            text = message.model_dump_json()
            for page in to:
                page.tell(text, state=isinstance(message, ChairState))


def _first(fault: ValidationError) -> str:
    """The first thing wrong with a message, without repeating what was sent."""
    first = fault.errors(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(str(part) for part in first["loc"])[:80]
    return f"{where}: {first['msg']}"[:200] if where else str(first["msg"])[:200]
