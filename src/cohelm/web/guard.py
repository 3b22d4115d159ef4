"""Outermost checks of requests and sockets: host, origin, size and time.

It also adds the headers of every answer that forbid a page to load, or be loaded by, other sites.
"""

from __future__ import annotations

import asyncio
from collections.abc import MutableMapping
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from cohelm.web.origins import Origins, Refusal, name_of

MAX_BODY_SIZE = 16_384
"""Maximum size of the body of a request, bytes."""
STOP_PATH = "/api/stop"
"""Path of the request that takes no turn."""
MAX_WAITING = 64
"""Maximum number of requests that wait for their turn; more are refused, but for STOP."""
BODY_TIMEOUT = 10.0
"""Maximum time for the body of a request to arrive, s."""
_TOO_LARGE = Refusal(status=413, code="too_large", text="the request is too large")
BUSY = Refusal(status=503, code="busy", text="too many requests at once; try again")
_GONE = bytes(bytearray(b"gone"))
"""Body of a request whose client has gone; compared by identity."""
_TOO_SLOW = Refusal(status=408, code="too_slow", text="the request did not come in time")
_SAFE = (
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    (
        "permissions-policy",
        "camera=(), geolocation=(), microphone=(), payment=(), usb=(), gamepad=(self)",
    ),
)


def content_policy(host: str, *, tls: bool) -> str:
    """Content security policy: own files only, no inline script, nothing from other sites.

    Args:
        host: Host header of the request; an invalid one is left out.
        tls: True for HTTPS.
    """
    socket = f" {'wss' if tls else 'ws'}://{host}" if name_of(host) else ""
    return "; ".join(
        (
            "default-src 'none'",
            "script-src 'self'",
            "style-src 'self'",
            "img-src 'self' data: blob:",
            "font-src 'self'",
            "manifest-src 'self'",
            f"connect-src 'self'{socket}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    )


class Guard:
    """Outermost layer of the server."""

    def __init__(self, app: ASGIApp, origins: Origins) -> None:
        self._app = app
        self._origins = origins
        self._turn = asyncio.Lock()
        self._waiting = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse a request or pass it on."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        guarded = self._with_headers(scope, send)
        refusal = self._origins.refusal(
            scope["headers"],
            method=scope.get("method", "GET"),
            path=scope["path"],
            is_socket=scope["type"] == "websocket",
            local=(scope.get("server") or ("",))[0],
        )
        if refusal is not None:
            await deny(scope, guarded, refusal)
            return
        if scope["type"] == "websocket":
            await self._app(scope, receive, guarded)
            return
        try:
            async with asyncio.timeout(BODY_TIMEOUT):
                body = await _body(receive)
        except TimeoutError:
            await deny(scope, guarded, _TOO_SLOW)
            return
        if body is None:
            await deny(scope, guarded, _TOO_LARGE)
        elif body is _GONE:
            pass
        elif scope["path"] == STOP_PATH or await self._takes_turn():
            await self._app(scope, _once(body, receive), guarded)
        else:
            await deny(scope, guarded, BUSY)

    async def _takes_turn(self) -> bool:
        """Wait for the turn of a request; False if too many wait.

        One answer begins in each round of the loop, however many requests have come: a request for
        STOP among them is read soon, and answered at once.
        """
        if self._waiting >= MAX_WAITING:
            return False
        self._waiting += 1
        try:
            async with self._turn:
                await asyncio.sleep(0)
        finally:
            self._waiting -= 1
        return True

    def _with_headers(self, scope: Scope, send: Send) -> Send:
        host = next((text for name, text in scope["headers"] if name == b"host"), b"")
        policy = content_policy(host.decode("latin-1"), tls=self._origins.tls)

        async def guarded(message: Message) -> None:
            if message["type"] in {"http.response.start", "websocket.http.response.start"}:
                _add(message, [*_SAFE, ("content-security-policy", policy)])
                _add(message, [("cache-control", "no-store")])
            await send(message)

        return guarded


async def deny(scope: Scope, send: Send, refusal: Refusal) -> None:
    """Answer with a refusal; a socket is refused before it is open."""
    body = refusal.body
    prefix = "websocket." if scope["type"] == "websocket" else ""
    headers = [
        (b"content-type", b"application/json"),
        (b"content-length", str(len(body)).encode()),
        (b"connection", b"close"),
    ]
    await send(
        {"type": f"{prefix}http.response.start", "status": refusal.status, "headers": headers}
    )
    await send({"type": f"{prefix}http.response.body", "body": body})


def _add(message: MutableMapping[str, Any], headers: list[tuple[str, str]]) -> None:
    """Add headers that the answer does not have yet."""
    present = {name.lower() for name, _ in message.get("headers", ())}
    fresh = [(k.encode(), v.encode("latin-1")) for k, v in headers if k.encode() not in present]
    message["headers"] = [*message.get("headers", ()), *fresh]


async def _body(receive: Receive) -> bytes | None:
    """Return the body of a request; None: it is too large, ``_GONE``: the client has gone."""
    parts: list[bytes] = []
    size = 0
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            return _GONE
        part = message.get("body", b"")
        size += len(part)
        if size > MAX_BODY_SIZE:
            return None
        parts.append(part)
        if not message.get("more_body", False):
            return b"".join(parts)


def _once(body: bytes, receive: Receive) -> Receive:
    """Return a receiver that yields the body, and then the messages after it."""
    given = False

    async def _receive() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return _receive
