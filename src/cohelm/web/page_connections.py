"""Open pages: one socket each, with the messages that wait for it and the limits of its own.

Messages of a page go to the drive after they have been checked and counted. Messages of the drive
come from its threads and are handed over to the server's thread. States are never queued: a page
that does not read in time misses some, and gets the newest.
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
from cohelm.web.rate_limits import (
    MAX_FAULT_RATE,
    MAX_FAULTS,
    MAX_HEARTBEAT_RATE,
    MAX_MESSAGE_RATE,
    RateLimit,
)
from cohelm.web.signin import Session

MAX_PAGES = 16
"""Maximum number of open pages."""
MAX_PAGES_PER_ADDRESS = 8
"""Maximum number of open pages from one address."""
MAX_PAGE_RATE = 20.0
"""Maximum rate of new pages, 1/s."""
MAX_QUEUED_MESSAGES = 256
"""Maximum number of messages other than states that wait for a page; beyond it, it is closed."""
SEND_TIMEOUT = 5.0
"""Maximum time for a page to take one message, s."""


class CloseCode(enum.IntEnum):
    """Reason to close a socket; uvicorn adds 1009 (message too long) and 1012 (server ends)."""

    FAULT = 1011
    """The server has failed."""
    MALFORMED = 4400
    """The page has sent too many malformed messages."""
    SIGNED_OUT = 4401
    """The session has ended."""
    SLOW = 4408
    """The page does not read its messages."""
    TOO_MANY = 4429
    """The page sends too many messages."""


class PageConnection:
    """Socket of one page, in both directions. Belongs to the server's thread."""

    def __init__(self, socket: WebSocket, session: Session, now: float) -> None:
        self.client = f"page-{secrets.token_hex(4)}"
        self.session = session
        self._socket = socket
        self._heartbeats = RateLimit(MAX_HEARTBEAT_RATE, now)
        self._all = RateLimit(MAX_MESSAGE_RATE, now)
        self._faults = RateLimit(MAX_FAULT_RATE, now, MAX_FAULTS)
        self._waiting: deque[str] = deque()
        self._state: str | None = None
        self._wake = asyncio.Event()
        self.over: asyncio.Future[CloseCode | None] = asyncio.get_running_loop().create_future()

    def queue(self, text: str, *, state: bool = False) -> None:
        """Queue a message; a state replaces one that still waits."""
        if state:
            self._state = text
        elif len(self._waiting) < MAX_QUEUED_MESSAGES:
            self._waiting.append(text)
        else:
            self.end(CloseCode.SLOW)
        self._wake.set()

    def end(self, code: CloseCode | None) -> None:
        """Close the socket; None: the page has closed it already."""
        if not self.over.done():
            self.over.set_result(code)

    async def send(self) -> None:
        """Send queued messages until cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while (text := self._next()) is not None:
                try:
                    async with asyncio.timeout(SEND_TIMEOUT):
                        await self._socket.send_text(text)
                except TimeoutError:
                    self.end(CloseCode.SLOW)
                    return
                except RuntimeError:  # it was closed meanwhile
                    self.end(None)
                    return

    async def listen(self, drive: Drive) -> None:
        """Pass messages of the page to the drive until the page is closed."""
        while not self.over.done():
            event = await self._socket.receive()
            now = time.monotonic()
            if event["type"] != "websocket.receive":
                self.end(None)
            elif now >= self.session.ends:
                self.end(CloseCode.SIGNED_OUT)
            elif not self._all.take(now):
                self.end(CloseCode.TOO_MANY)
            elif (message := self._parsed(event.get("text"), now)) is None:
                pass
            elif isinstance(message, Heartbeat) and not self._heartbeats.take(now):
                self.end(CloseCode.TOO_MANY)
            else:
                drive.receive(self.client, message, now)

    def _parsed(self, text: str | None, now: float) -> FromPage | None:
        try:
            return FROM_PAGE.validate_json(text or "", strict=True)
        except ValidationError as fault:
            refused = Rejected(code="malformed", text=_first(fault))
        self.queue(refused.model_dump_json())
        if not self._faults.take(now):
            self.end(CloseCode.MALFORMED)
        return None

    def _next(self) -> str | None:
        if self._waiting:
            return self._waiting.popleft()
        text, self._state = self._state, None
        return text


class PageConnections:
    """All open pages of a drive. Belongs to the server's thread; see :meth:`_receive`."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._pages: dict[str, PageConnection] = {}
        self._addresses: Counter[str] = Counter()
        self._arrivals = RateLimit(MAX_PAGE_RATE, time.monotonic())
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._lock = threading.Lock()
        self._newest: ChairState | None = None
        drive.listen(self._receive)

    def refusal(self, address: str, now: float) -> Refusal | None:
        """Return the reason to refuse one more page from an address; None: it is accepted."""
        if (
            self._addresses.total() >= MAX_PAGES
            or self._addresses[address] >= MAX_PAGES_PER_ADDRESS
        ):
            return Refusal(status=503, code="full", text="too many pages are open; close one")
        if not self._arrivals.take(now):
            return Refusal(status=429, code="too_many", text="too many pages at once; try again")
        return None

    async def serve(self, socket: WebSocket, session: Session, address: str) -> None:
        """Serve a page until it is closed."""
        self._addresses[address] += 1
        try:
            await socket.accept()
            await self._serve(socket, PageConnection(socket, session, time.monotonic()))
        finally:
            self._addresses[address] -= 1
            self._addresses += Counter()  # removes addresses without a page

    async def _serve(self, socket: WebSocket, page: PageConnection) -> None:
        self._pages[page.client] = page
        self._drive.connect(page.client, page.session.role)
        tasks = [asyncio.create_task(page.send()), asyncio.create_task(page.listen(self._drive))]
        try:
            both: list[asyncio.Future[Any]] = [page.over, *tasks]
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done() and (fault := task.exception()) is not None:
                    page.end(None if isinstance(fault, WebSocketDisconnect) else CloseCode.FAULT)
                    if not isinstance(fault, WebSocketDisconnect):
                        raise fault
            page.end(None)
        finally:
            del self._pages[page.client]
            self._drive.disconnect(page.client)
            for task in tasks:
                task.cancel()
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

    def _receive(self, message: ToPage, client: str | None) -> None:
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
                page.queue(text, state=isinstance(message, ChairState))


def _first(fault: ValidationError) -> str:
    """First error in a message, without repeating its content."""
    first = fault.errors(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(str(part) for part in first["loc"])[:80]
    detail = f"{where}: {first['msg']}" if where else str(first["msg"])
    return f"The request is not understood: {detail[:200]}."
