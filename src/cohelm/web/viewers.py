"""Foxglove WebSocket at ``/foxglove``: viewers watch a ride, and can do nothing else.

It is a socket of the page's own server, with its certificate, sign-in and limits. A viewer is a
page of another site, so that its origin must be allowed by name.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import time
from collections.abc import Mapping
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from cohelm.live import Drive
from cohelm.live.messages import ToPage
from cohelm.live.page.display_messages import TYPES, displays, floor_of_scene
from cohelm.recordings.rides import ros_messages as ros
from cohelm.web.rate_limits import MAX_MESSAGE_RATE, RateLimit

PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Names of the protocol; what is spoken here is the same in both."""
MAX_VIEWERS = 4
"""Maximum number of open viewers."""
MAX_SUBSCRIPTIONS = 64
"""Maximum number of subscriptions of a viewer."""
SEND_TIMEOUT = 5.0
"""Maximum time for a viewer to take one message, s."""
TOPICS = {
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/tf": TYPES["transform"],
    "/odom": TYPES["odometry"],
    **{f"/{name}": TYPES[name] for name in TYPES if name not in {"transform", "odometry"}},
}
_NAMES = {"transform": "/tf", "odometry": "/odom"}
_IDS = {topic: number for number, topic in enumerate(TOPICS, start=1)}
_KEPT = frozenset({"/map", "/route"})
"""Topics whose newest message a new subscriber gets."""
_DATA = struct.Struct("<BIQ")
"""Opcode 1, subscription, time in ns."""


class Viewer:
    """Socket of one viewer; belongs to the server's thread.

    Of each topic only the newest message waits, so that a slow viewer misses some.
    """

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self.subscriptions: dict[int, str] = {}
        self._waiting: dict[int, bytes] = {}
        self._wake = asyncio.Event()

    def put(self, topic: str, data: bytes, now: float) -> None:
        """Queue a message for the viewer's subscription of its topic, if there is one."""
        for number, wanted in self.subscriptions.items():
            if wanted == topic:
                self._waiting[number] = _DATA.pack(1, number, ros.nanoseconds(now)) + data
                self._wake.set()

    async def greet(self, name: str) -> None:
        """Send what the server is, and its topics."""
        await self._socket.send_json({"op": "serverInfo", "name": name, "capabilities": []})
        channels = [
            {
                "id": _IDS[topic],
                "topic": topic,
                "encoding": "cdr",
                "schemaName": type_,
                "schema": ros.schema(type_).decode(),
                "schemaEncoding": "ros2msg",
            }
            for topic, type_ in TOPICS.items()
        ]
        await self._socket.send_json({"op": "advertise", "channels": channels})

    async def send(self) -> None:
        """Send queued messages until cancelled; raises TimeoutError if the viewer does not read."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            waiting, self._waiting = self._waiting, {}
            for frame in waiting.values():
                async with asyncio.timeout(SEND_TIMEOUT):
                    await self._socket.send_bytes(frame)

    async def listen(self, kept: Mapping[str, bytes]) -> None:
        """Take subscriptions until the viewer leaves, or sends anything else too often."""
        limit = RateLimit(MAX_MESSAGE_RATE, time.monotonic())
        while True:
            event = await self._socket.receive()
            if event["type"] != "websocket.receive" or not limit.take(time.monotonic()):
                return
            for topic in self._subscribe(event.get("text")):
                if topic in kept:
                    self.put(topic, kept[topic], time.time())

    def _subscribe(self, text: str | None) -> list[str]:
        """Change the subscriptions as a message says; returns the new topics."""
        try:
            message: Any = json.loads(text or "")
            if message["op"] == "unsubscribe":
                for number in message["subscriptionIds"]:
                    self.subscriptions.pop(int(number), None)
                    self._waiting.pop(int(number), None)
            if message["op"] != "subscribe":
                return []
            wanted = {int(e["id"]): int(e["channelId"]) for e in message["subscriptions"]}
        except (ValueError, TypeError, KeyError, OverflowError):
            return []
        topics = {number: topic for topic, number in _IDS.items()}
        new = {
            number: topics[channel]
            for number, channel in wanted.items()
            if channel in topics and 0 <= number < 2**32
        }
        if len(self.subscriptions | new) > MAX_SUBSCRIPTIONS:
            return []
        self.subscriptions |= new
        return list(new.values())


class Viewers:
    """All viewers of a drive; belongs to the server's thread."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._open: list[Viewer] = []
        self._loop = asyncio.get_running_loop()
        self._kept: dict[str, bytes] = {}
        drive.listen(self._receive)

    @property
    def full(self) -> bool:
        """True if no more viewers are accepted."""
        return len(self._open) >= MAX_VIEWERS

    async def serve(self, socket: WebSocket) -> None:
        """Serve a viewer until it leaves; it must offer the protocol."""
        offered = socket.scope.get("subprotocols", [])
        protocol = next((name for name in PROTOCOLS if name in offered), None)
        if protocol is None:
            await socket.close()
            return
        if "/map" not in self._kept:
            grid = floor_of_scene(self._drive.scene(), self._drive.floor_png())
            self._kept["/map"] = ros.serialised(ros.grid(time.time(), "map", grid))
        await socket.accept(subprotocol=protocol)
        viewer = Viewer(socket)
        self._open.append(viewer)
        tasks: list[asyncio.Task[None]] = []
        try:
            await viewer.greet(f"cohelm: {self._drive.scene().name}")
            tasks = [
                asyncio.create_task(viewer.send()),
                asyncio.create_task(viewer.listen(self._kept)),
            ]
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done():
                    with contextlib.suppress(WebSocketDisconnect, TimeoutError, RuntimeError):
                        task.result()
        finally:
            self._open.remove(viewer)
            for task in tasks:
                task.cancel()
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await socket.close()

    def _receive(self, message: ToPage, client: str | None) -> None:
        """Take a message of the drive, called in any thread."""
        if client is None and (self._open or message.type == "route"):
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._deliver, message)

    def _deliver(self, message: ToPage) -> None:
        now = time.time()
        wanted = {topic for viewer in self._open for topic in viewer.subscriptions.values()}
        for name, converted in displays(message, now):
            topic = _NAMES.get(name, f"/{name}")
            if topic not in wanted and topic not in _KEPT:
                continue
            data = ros.serialised(converted)
            if topic in _KEPT:
                self._kept[topic] = data
            for viewer in self._open:
                viewer.put(topic, data, now)


def token_of(socket: WebSocket) -> str:
    """Return the token in a viewer's address; viewers cannot send headers."""
    return socket.query_params.get("token", "")
