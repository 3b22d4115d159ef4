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

from cohelm.driving import Drive
from cohelm.driving.messages import FROM_PAGE, Beat, FromPage, Refused, State, ToPage
from cohelm.web.origins import Refusal
from cohelm.web.rates import BEATS, MESSAGES, Bucket, Faults
from cohelm.web.signin import Session

MOST = 16
"""Pages at once."""
MOST_EACH = 8
"""Of them from one address."""
ARRIVALS = 20.0
"""New pages a second."""
WAITING = 256
"""Messages other than states that wait for a page."""
READ_WITHIN = 5.0
"""A page takes what is sent to it, s."""


class Closed(enum.IntEnum):
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


class Page:
    """One socket, and its two ways. Belongs to the server's thread."""

    def __init__(self, socket: WebSocket, session: Session, now: float) -> None:
        self.client = f"page-{secrets.token_hex(4)}"
        self.session = session
        self._socket = socket
        self._beats, self._all = Bucket(BEATS, now), Bucket(MESSAGES, now)
        self._faults = Faults(now)
        self._waiting: deque[str] = deque()
        self._state: str | None = None
        self._wake = asyncio.Event()
        self.over: asyncio.Future[Closed | None] = asyncio.get_running_loop().create_future()

    def tell(self, text: str, *, state: bool = False) -> None:
        """Send when the page takes it; a state takes the place of one that still waits."""
        if state:
            self._state = text
        elif len(self._waiting) < WAITING:
            self._waiting.append(text)
        else:
            self.end(Closed.SLOW)
        self._wake.set()

    def end(self, code: Closed | None) -> None:
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
                    self.end(Closed.SLOW)
                    return

    async def listen(self, drive: Drive) -> None:
        """Hand what the page says to the drive, until it may not any more or is gone."""
        while not self.over.done():
            event = await self._socket.receive()
            now = time.monotonic()
            if event["type"] != "websocket.receive":
                self.end(None)
            elif now >= self.session.ends:
                self.end(Closed.SIGNED_OUT)
            elif not self._all.take(now):
                self.end(Closed.TOO_MANY)
            elif (message := self._understood(event.get("text"), now)) is None:
                pass
            elif isinstance(message, Beat) and not self._beats.take(now):
                self.end(Closed.TOO_MANY)
            else:
                drive.heard(self.client, message, now)

    def _understood(self, text: str | None, now: float) -> FromPage | None:
        try:
            return FROM_PAGE.validate_json(text or "", strict=True)
        except ValidationError as fault:
            refused = Refused(code="malformed", text=_first(fault))
        self.tell(refused.model_dump_json())
        if not self._faults.add(now):
            self.end(Closed.MALFORMED)
        return None

    def _next(self) -> str | None:
        if self._waiting:
            return self._waiting.popleft()
        text, self._state = self._state, None
        return text


class Pages:
    """All open pages of a drive. Belongs to the server's thread, but for what the drive calls."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._pages: dict[str, Page] = {}
        self._addresses: Counter[str] = Counter()
        self._arrivals = Bucket(ARRIVALS, time.monotonic())
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._lock = threading.Lock()
        self._newest: State | None = None
        drive.listen(self._told)

    def refusal(self, address: str, now: float) -> Refusal | None:
        """Why there is no room for one more page from here; None: there is."""
        if self._addresses.total() >= MOST or self._addresses[address] >= MOST_EACH:
            return Refusal(status=503, code="full", text="too many pages are open; close one")
        if not self._arrivals.take(now):
            return Refusal(status=429, code="too_many", text="too many pages at once; try again")
        return None

    async def serve(self, socket: WebSocket, session: Session, address: str) -> None:
        """One page from its beginning to its end."""
        self._addresses[address] += 1
        try:
            await socket.accept()
            await self._serve(socket, Page(socket, session, time.monotonic()))
        finally:
            self._addresses[address] -= 1
            self._addresses += Counter()  # forgets who has none

    async def _serve(self, socket: WebSocket, page: Page) -> None:
        self._pages[page.client] = page
        self._drive.joined(page.client, page.session.role)
        ways = [asyncio.create_task(page.send()), asyncio.create_task(page.listen(self._drive))]
        try:
            both: list[asyncio.Future[Any]] = [page.over, *ways]
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                if way.done() and (fault := way.exception()) is not None:
                    page.end(None if isinstance(fault, WebSocketDisconnect) else Closed.FAULT)
                    if not isinstance(fault, WebSocketDisconnect):
                        raise fault
            page.end(None)
        finally:
            del self._pages[page.client]
            self._drive.left(page.client)
            for way in ways:
                way.cancel()
            code = page.over.result() if page.over.done() else Closed.FAULT
            if code is not None:
                self._drive.audit.note(page.client, "refused", closed=code.name.lower())
                with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                    await socket.close(code, code.name.lower())

    def end(self, session: Session) -> None:
        """Close all pages of a session."""
        for page in self._pages.values():
            if page.session is session:
                page.end(Closed.SIGNED_OUT)

    def _told(self, message: ToPage, client: str | None) -> None:
        """What the drive tells, in whatever thread."""
        if threading.get_ident() == self._thread:
            self._deliver(message, client)
            return
        with contextlib.suppress(RuntimeError):  # the server has ended
            if not isinstance(message, State) or client is not None:
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
                page.tell(text, state=isinstance(message, State))


def _first(fault: ValidationError) -> str:
    """The first thing wrong with a message, without repeating what was sent."""
    first = fault.errors(include_url=False, include_context=False, include_input=False)[0]
    where = ".".join(str(part) for part in first["loc"])[:80]
    return f"{where}: {first['msg']}"[:200] if where else str(first["msg"])[:200]
