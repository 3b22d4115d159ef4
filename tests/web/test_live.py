"""The whole of it with a real drive: a page says something, and the wheels of the chair turn."""

import asyncio
import json
import time

import pytest

from cohelm.live import Drive, DriveSetup
from cohelm.live.sessions.measuring import MeasuringPostponed
from cohelm.scenarios import load_scenario
from cohelm.web.page_connections import CloseCode


def postponed(*_):
    """Measuring takes its time."""
    raise MeasuringPostponed


@pytest.fixture(scope="module")
def live(tmp_path_factory):
    folder = tmp_path_factory.mktemp("live")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cohelm.live.sessions.store.measure_in_subprocess", postponed)
        drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=folder))
        drive.start()
        limit = time.monotonic() + 240.0
        while not drive.health.ready:
            assert time.monotonic() < limit
            time.sleep(0.1)
        yield drive
        drive.close()


@pytest.fixture
def server(live, served):
    with served(live, tokens={"therapist": served.tokens["therapist"]}) as running:
        yield running


class Pilot:
    """Beats on a page's socket, ten times a second, with a stick that the test holds."""

    def __init__(self, page):
        self.page = page
        self.seq = 0
        self.forward = 0.0
        self.state = {}
        self.beating = True

    async def __aenter__(self):
        self._tasks = [asyncio.create_task(self._listen()), asyncio.create_task(self._beat())]
        return self

    async def __aexit__(self, *_):
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def beat(self, seq, forward):
        return json.dumps(
            {
                "type": "heartbeat", "seq": seq, "sent": 1e3 * time.monotonic(),
                "forward": forward, "device": "keys" if forward else "none",
            }
        )  # fmt: skip

    async def say(self, kind, **more):
        await self.page.send(json.dumps({"type": kind, **more}))

    async def _beat(self):
        while True:
            if self.beating:
                self.seq += 1
                await self.page.send(self.beat(self.seq, self.forward))
            await asyncio.sleep(0.1)

    async def _listen(self):
        async for text in self.page:
            message = json.loads(text)
            if message["type"] == "state":
                self.state = message

    async def until(self, law, within=10.0):
        """Wait until a state fulfils a law; returns how long that took, s."""
        began = time.monotonic()
        async with asyncio.timeout(within):
            while not (self.state and law(self.state)):
                await asyncio.sleep(0.005)
        return time.monotonic() - began

    async def ready(self):
        """Take the chair with the stick let go, in the mode that follows the stick alone."""
        await self.say("take_control")
        await self.say("set_mode", mode="assisted")
        await self.until(lambda state: state["link"] in {"confirm", "ready"})
        await self.say("resume")
        await self.until(lambda state: state["link"] == "ready")

    async def drive(self):
        await self.ready()
        self.forward = 0.6
        await self.until(lambda state: state["speed"] > 0.1)


def stands(state):
    return state["command"] == [0.0, 0.0]


def ride(server, story):
    """``story`` with a pilot at a page of the server."""

    async def told():
        async with server.ws() as page, Pilot(page) as pilot:
            result = await story(pilot)
            if page.close_code is None:
                pilot.beating = True
                pilot.forward = 0.0
                await pilot.say("release_control")
                await pilot.until(lambda state: abs(state["speed"]) < 1e-3)
            return result

    return asyncio.run(asyncio.wait_for(told(), 60.0))


def test_the_stick_turns_the_wheels_and_stop_stops_them(server):
    async def story(pilot):
        await pilot.drive()
        await pilot.say("stop")
        await pilot.until(stands, within=1.0)
        await asyncio.sleep(0.5)  # the stick is still held
        assert stands(pilot.state)
        assert pilot.state["link"] == "stick_held"

    ride(server, story)


def test_who_has_not_taken_the_chair_moves_nothing(server):
    async def story(pilot):
        await pilot.until(lambda state: state["driver"] is None)
        pilot.forward = 1.0
        for _ in range(20):
            await asyncio.sleep(0.05)
            assert stands(pilot.state)

    ride(server, story)


def test_silence_stops_the_chair(server):
    """300 ms of silence, a beat's period before it and a step of the chair: 0.4 s."""

    async def story(pilot):
        await pilot.drive()
        pilot.beating = False
        return await pilot.until(stands, within=2.0)

    assert ride(server, story) < 0.45


def test_a_socket_that_is_cut_stops_the_chair(server, live):
    async def cut():
        async with server.ws() as page, Pilot(page) as pilot:
            await pilot.drive()
            page.transport.abort()

    asyncio.run(asyncio.wait_for(cut(), 30.0))

    async def story(pilot):
        return await pilot.until(lambda state: stands(state) and state["driver"] is None, 2.0)

    assert ride(server, story) < 0.4


def test_replayed_and_reordered_commands_move_nothing(server):
    """Beats of before, sent again with the stick at full, count neither as alive nor as command."""

    async def story(pilot):
        await pilot.drive()
        pilot.forward = 0.0
        await asyncio.sleep(0.3)
        last = pilot.seq
        pilot.beating = False
        for old in range(last, last - 10, -1):
            await pilot.page.send(pilot.beat(old, 1.0))
            await asyncio.sleep(0.05)
            assert pilot.state["heartbeat"] <= last
            assert pilot.state["command"][0] < 0.3
        await pilot.until(stands, within=2.0)
        assert pilot.state["link"] in {"no_heartbeat", "centre_stick", "confirm"}

    ride(server, story)


def test_an_attacker_beside_does_not_disturb_who_drives(server):
    async def story(pilot):
        await pilot.drive()
        async with server.ws() as page:
            for k in range(500):
                await page.send(pilot.beat(k, -1.0))
            assert await server.closed(page) == CloseCode.TOO_MANY
        await asyncio.sleep(0.3)
        assert pilot.state["link"] == "ready"
        assert pilot.state["driver"] is not None

    ride(server, story)


def test_limits_do_not_rise_while_the_chair_moves(server, live):
    """They fall at once, and the therapist is told why they do not rise."""
    with server.signed_in("therapist") as client:
        before = client.get("/api/limits").json()
        lower = {**before, "max_speed": 0.5}

        async def story(pilot):
            await pilot.drive()
            fallen = await asyncio.to_thread(client.put, "/api/limits", json=lower)
            risen = await asyncio.to_thread(client.put, "/api/limits", json=before)
            return fallen.status_code, risen.status_code, risen.json()["code"]

        assert ride(server, story) == (200, 409, "limits_loosened")
        assert client.get("/api/limits").json() == lower
        assert client.put("/api/limits", json=before).json() == before
        log = [entry["event"] for entry in client.get("/api/audit").json()]
    assert {"limits_changed", "limits_rejected", "control_taken", "signed_in"} <= set(log)
