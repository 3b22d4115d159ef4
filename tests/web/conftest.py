import asyncio
import contextlib
import json
import threading

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from cohelm.errors import StoreError
from cohelm.live import DriveHealth, LimitsLoosened
from cohelm.live.control.limits import ChairMoves
from cohelm.live.floor_model import FloorSolids, SolidShape
from cohelm.live.messages import (
    ChairInfo,
    ChairState,
    Echo,
    FloorInfo,
    Limits,
    RiderSettings,
    SceneInfo,
    Welcome,
)
from cohelm.web.page_files import Asset
from cohelm.web.server import listening, make_context, server

TOKENS = {"driver": "drive-drive-drive-drive", "therapist": "thera-thera-thera-thera"}
PAGE = {
    "": Asset(body=b"<!doctype html>", zipped=None, kind="text/html", tag='"1"', lasting=False),
    "assets/a.js": Asset(
        body=b"1;" * 500, zipped=b"\x1f\x8b", kind="text/javascript", tag='"2"', lasting=True
    ),
}


class Store:
    def list(self):
        return ()

    def summary(self, session):
        raise StoreError(f"there is no session {session}")

    html = csv = png = summary

    def delete_all(self):
        return 3


class Log:
    def __init__(self):
        self.noted = []

    def log_event(self, who, what, **said):
        self.noted.append((who, what, said))

    def entries(self):
        return ()


class Still:
    """Stands in for a drive where only what carries the messages is tested: it tells and hears."""

    def __init__(self):
        self.limits = Limits(max_speed=0.8, max_acceleration=0.5, min_distance=0.3)
        self.rider = RiderSettings()
        self.moving = False
        self.next_storey = None
        self.told = lambda message, client: None
        self.joined_as = {}
        self.gone = []
        self.said = []
        self.sessions, self.audit = Store(), Log()
        self.health = DriveHealth(
            status="ok",
            problem="",
            ready=True,
            ticks=7,
            missed=2,
            longest_streak=1,
            stops=0,
            restarts=0,
        )

    def listen(self, callback):
        self.told = callback

    def scene(self):
        floor = FloorInfo(
            image="/api/floor/abc.png", width=2, height=2, resolution=0.1, x=0.0, y=0.0
        )
        chair = ChairInfo(
            name="chair",
            outline=((0.0, 0.0),),
            max_speed=1.0,
            max_acceleration=1.0,
            max_turn_rate=1.0,
            sees_floor=True,
        )
        return SceneInfo(
            name="empty", description="", simulation=True, seed=0, floor=floor, places=(),
            doors=(), chair=chair, modes=("shared",),
        )  # fmt: skip

    def floor_png(self):
        return b"\x89PNG"

    @property
    def solids(self):
        square = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1))
        box = SolidShape(outline=square, height=0.5)
        return FloorSolids(wall_height=2.5, ceiling=True, solids=(box,), wet=())

    def connect(self, client, role):
        self.joined_as[client] = role
        welcome = Welcome(
            client=client, role=role, scene=self.scene(), limits=self.limits, rider=self.rider
        )
        self.told(welcome, client)

    def disconnect(self, client):
        self.gone.append(client)

    def receive(self, client, message, at):
        self.said.append((client, message, at))
        if isinstance(message, Echo):
            self.told(message, client)

    def set_limits(self, limits, who):
        if self.moving and limits.max_speed > self.limits.max_speed:
            raise LimitsLoosened("the chair moves")
        self.limits = limits
        self.audit.log_event(who, "limits")

    def allow_edges(self, who, now):
        if self.moving:
            raise ChairMoves("Edges can be allowed only while the chair stands.")
        self.audit.log_event(who, "edges_allowed")

    def set_rider(self, rider, who):
        self.rider = rider

    def state(self, seq=0, people=()):
        return ChairState(
            seq=seq, time=0.0, pose=(0.0, 0.0, 0.0), speed=0.0, turn_rate=0.0, command=(0.0, 0.0),
            mode="shared", pace="normal", rider_authority=0.0, people=people,
        )  # fmt: skip


class Served:
    """A drive behind a server on a port of its own."""

    tokens = TOKENS

    def __init__(self, drive, host="127.0.0.1", tokens=None, page=PAGE, **options):
        self.drive = drive
        self._bound = listening(host, 0)
        self._what = make_context(
            drive, page, self._bound, host=host, tokens=tokens or TOKENS, **options
        )
        self.tls = options.get("tls")
        self.port = self._what.port
        self.name = f"127.0.0.1:{self.port}"
        scheme = "https" if self.tls else "http"
        self.origin = f"{scheme}://{self.name}"

    def __enter__(self):
        ready = threading.Event()
        self._server = server(self._what, self.tls, ready.set)
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [self._bound]}, daemon=True
        )
        self._thread.start()
        assert ready.wait(10.0)
        return self

    def __exit__(self, *_):
        self._server.should_exit = True
        self._thread.join(10.0)
        assert not self._thread.is_alive()

    def http(self, **options):
        options = {"headers": {"Origin": self.origin}, "verify": False, **options}
        return httpx.Client(base_url=self.origin, **options)

    @contextlib.contextmanager
    def signed_in(self, role):
        with self.http() as client:
            answer = client.post("/api/sign-in", json={"token": TOKENS[role]})
            assert answer.status_code == 200
            yield client

    @staticmethod
    async def told(page, kind, within=5.0):
        """The next message of a kind."""
        async with asyncio.timeout(within):
            while True:
                message = json.loads(await page.recv())
                if message["type"] == kind:
                    return message

    @staticmethod
    async def closed(page, within=5.0):
        """The code with which the server closes a page's socket."""
        async with asyncio.timeout(within):
            with contextlib.suppress(ConnectionClosed):
                while True:
                    await page.recv()
        return page.close_code

    def ws(self, **options):
        """A page's socket; Host and Origin are its own where nothing else is said."""
        options = {"origin": self.origin, "compression": None, **options}
        return connect(f"{self.origin.replace('http', 'ws')}/ws", **options)


@pytest.fixture
def drive():
    return Still()


@pytest.fixture
def served():
    """Makes servers; to be used with ``with``."""
    return Served


@pytest.fixture
def open_server(drive):
    """On this machine alone: nobody needs a token to drive."""
    with Served(drive, tokens={"therapist": TOKENS["therapist"]}) as served:
        yield served


@pytest.fixture
def closed_server(drive):
    """Drivers need a token."""
    with Served(drive) as served:
        yield served
