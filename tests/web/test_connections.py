"""Who only takes room or time does not keep anybody else out."""

import asyncio
import contextlib
import io
import socket
import time

import pytest
from PIL import Image
from websockets.exceptions import ConnectionClosed

from cohelm.live.messages import StopCommand
from cohelm.web import connections

PIXELS = io.BytesIO()
Image.new("L", (2, 2)).save(PIXELS, "png")
FLOOR = PIXELS.getvalue()


@pytest.fixture
def hasty(monkeypatch):
    """Whoever says nothing is let go soon."""
    monkeypatch.setattr(connections, "REQUEST_TIMEOUT", 0.3)
    monkeypatch.setattr(connections, "_CHECK_PERIOD", 0.1)


def connected(server, stack):
    made = stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
    made.settimeout(5.0)
    return made


def ended(connection):
    """Wait for the other end to close."""
    try:
        return connection.recv(1) == b""
    except ConnectionError:
        return True


def test_silent_connections_keep_nobody_out(open_server, hasty):
    """From one address no more come in than may, and those that say nothing do not stay."""
    with contextlib.ExitStack() as stack:
        silent = [
            connected(open_server, stack)
            for _ in range(2 * connections.MAX_CONNECTIONS_PER_ADDRESS)
        ]
        began = time.monotonic()
        assert all(ended(each) for each in silent)
        assert time.monotonic() - began < 4.0
        with open_server.http() as client:
            assert client.get("/api/health").status_code == 200


def test_to_say_it_a_letter_at_a_time_does_not_help(open_server, hasty):
    with contextlib.ExitStack() as stack:
        slow = connected(open_server, stack)
        with contextlib.suppress(ConnectionError):
            for letter in b"GET / HTTP/1.1\r\n" * 8:
                slow.send(bytes([letter]))
                time.sleep(0.01)
        assert ended(slow)


def test_while_many_wait_only_stop_is_read(open_server, monkeypatch):
    """Also a STOP that comes in two pieces; the others are told that the server is busy."""
    monkeypatch.setattr(connections, "MAX_WAITING", 4)
    host = f"Host: {open_server.name}\r\nOrigin: {open_server.origin}\r\n"
    with contextlib.ExitStack() as stack:
        for _ in range(4):  # their bodies never come
            waiting = connected(open_server, stack)
            waiting.sendall(
                f"POST /api/limits HTTP/1.1\r\n{host}Content-Length: 9\r\n\r\n".encode()
            )
        time.sleep(0.2)
        refused = connected(open_server, stack)
        refused.sendall(f"GET /api/health HTTP/1.1\r\n{host}\r\n".encode())
        answer = refused.recv(1000)
        assert answer.startswith(b"HTTP/1.1 503")
        assert b'"busy"' in answer
        assert ended(refused)
        stop = connected(open_server, stack)
        stop.sendall(b"POST /api/stop HTTP/1.1\r\n")
        time.sleep(0.1)
        stop.sendall(f"{host}Content-Length: 0\r\n\r\n".encode())
        assert stop.recv(1000).startswith(b"HTTP/1.1 204")
    assert any(isinstance(said, StopCommand) for _, said, _ in open_server.drive.said)


async def empty_parts():
    for _ in range(1000):
        yield ""
    yield '{"type": "stop"}'


@pytest.mark.parametrize("of", ["pings", "parts"])
def test_a_flood_of_what_is_no_message_ends_the_socket(open_server, drive, of):
    async def attack():
        async with open_server.ws() as page:
            await open_server.told(page, "welcome")
            with contextlib.suppress(ConnectionClosed):
                if of == "parts":
                    await page.send(empty_parts())
                for _ in range(1000):
                    await page.ping()
            await asyncio.wait_for(page.wait_closed(), 5.0)

    asyncio.run(attack())
    assert drive.said == []


def test_stop_needs_no_socket(closed_server, drive):
    with closed_server.http(headers={"Origin": closed_server.origin}) as client:
        assert client.post("/api/stop").status_code == 401
    with closed_server.signed_in("driver") as client:
        assert client.post("/api/stop").status_code == 204
        evil = {"Origin": "http://evil.example"}
        assert client.post("/api/stop", headers=evil).status_code == 403
    assert [type(message) for _, message, _ in drive.said] == [StopCommand]


@pytest.mark.parametrize("viewer", [False, True])
@pytest.mark.parametrize("way", ["reset", "half closed", "before the answer"])
def test_a_page_that_goes_in_any_way_leaves_no_traceback(served, drive, caplog, way, viewer):
    """While states stream to it, twenty times over."""
    drive.floor_png = lambda: FLOOR
    site = "https://viewer.example"
    path, origin = ("/foxglove", site) if viewer else ("/ws", None)
    with served(drive, tokens={"therapist": "x"}, viewers=[site]) as server:
        for _ in range(20):
            page = socket.create_connection(("127.0.0.1", server.port))
            page.sendall(
                f"GET {path} HTTP/1.1\r\nHost: {server.name}\r\n"
                f"Origin: {origin or server.origin}\r\n"
                "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n".encode()
            )
            if way != "before the answer":
                page.recv(100)
            for seq in range(30):
                drive.told(drive.state(seq), None)
                if seq == 10 and way == "half closed":
                    page.shutdown(socket.SHUT_WR)
                if seq == 10 and way != "half closed":
                    page.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
                    page.close()
            page.close()
            time.sleep(0.02)
    assert [record for record in caplog.records if record.exc_info] == []
