"""Viewers by the Foxglove WebSocket protocol: they see the ride, and nothing else gets in."""

import asyncio
import contextlib
import io
import json
import struct

import numpy as np
import pytest
from PIL import Image
from rosbags.typesys import Stores, get_typestore
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from cohelm.live.messages import PersonInfo, RouteUpdate

from .conftest import TOKENS, Still

VIEWER = "https://app.foxglove.dev"
ROS = get_typestore(Stores.ROS2_HUMBLE)
NONSENSE = (
    "",
    "{",
    "[]",
    '{"op": "subscribe"}',
    '{"type": "stop"}',
    '{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}',
    '{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99}]}',
    '{"op": "advertise", "channels": [{"id": 1, "topic": "/cmd_vel"}]}',
)
PERSON = PersonInfo(id=7, x=1.0, y=2.0, vx=0.5, vy=0.0, radius=0.3, axis=0.0, front=1.0, side=0.5,
                    rear=0.5)  # fmt: skip


class Shown(Still):
    """A drive with a map of 2 × 2 cells: free and unknown above, occupied and free below."""

    def floor_png(self):
        out = io.BytesIO()
        Image.fromarray(np.array([[255, 128], [0, 255]], dtype=np.uint8)).save(out, "PNG")
        return out.getvalue()


@pytest.fixture
def shown(served):
    def made(**options):
        tokens = {"therapist": TOKENS["therapist"]}  # on loopback a driver needs none
        return served(Shown(), viewers=(VIEWER,), **{"tokens": tokens, **options})

    return made


def open_viewer(server, *, origin=VIEWER, protocol="foxglove.websocket.v1", query=""):
    address = f"{server.origin.replace('http', 'ws')}/foxglove{query}"
    return connect(address, origin=origin, subprotocols=[protocol], compression=None)


async def greeted(viewer):
    """Channel by topic."""
    async with asyncio.timeout(5.0):
        info, offer = json.loads(await viewer.recv()), json.loads(await viewer.recv())
    assert (info["op"], info["capabilities"], offer["op"]) == ("serverInfo", [], "advertise")
    return {each["topic"]: each for each in offer["channels"]}


async def subscribe(viewer, channels, *topics):
    wanted = [{"id": 100 + channels[t]["id"], "channelId": channels[t]["id"]} for t in topics]
    await viewer.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))


async def message(viewer, channels, topic, within=5.0):
    """The next message of a topic, decoded by its own schema's type."""
    async with asyncio.timeout(within):
        while True:
            frame = await viewer.recv()
            opcode, number, time = struct.unpack_from("<BIQ", frame)
            assert opcode == 1
            assert time > 1.6e18
            if number == 100 + channels[topic]["id"]:
                kind = channels[topic]["schemaName"]
                return ROS.deserialize_cdr(frame[13:], kind)


def test_a_viewer_sees_map_route_chair_people_and_reason(shown):
    async def watch(server):
        drive = server.drive
        drive.told(RouteUpdate(version=1, points=((0.0, 0.0), (1.0, 2.0))), None)
        async with open_viewer(server) as viewer:
            channels = await greeted(viewer)
            assert channels["/tf"]["encoding"] == "cdr"
            assert "geometry_msgs/TransformStamped" in channels["/tf"]["schema"]
            topics = ("/map", "/route", "/odom", "/tf", "/people", "/status")
            await subscribe(viewer, channels, *topics)
            grid = await message(viewer, channels, "/map")
            assert grid.data.tolist() == [100, 0, 0, -1]  # from below, as ROS has it
            route = await message(viewer, channels, "/route")
            assert [pose.pose.position.x for pose in route.poses] == [0.0, 1.0]
            drive.told(drive.state(seq=4, people=(PERSON,)), None)
            odometry = await message(viewer, channels, "/odom")
            assert odometry.child_frame_id == "base_footprint"
            people = await message(viewer, channels, "/people")
            assert any(m.pose.position.x == 1.0 for m in people.markers)
            status = await message(viewer, channels, "/status")
            assert status.status[0].message == "no limitation"

    with shown() as server:
        asyncio.run(watch(server))


def test_only_what_is_subscribed_comes_and_it_ends_with_the_subscription(shown):
    async def watch(server):
        async with open_viewer(server, protocol="foxglove.sdk.v1") as viewer:
            assert viewer.subprotocol == "foxglove.sdk.v1"
            channels = await greeted(viewer)
            await subscribe(viewer, channels, "/odom")
            await asyncio.sleep(0.1)
            for seq in range(3):
                server.drive.told(server.drive.state(seq=seq), None)
                await message(viewer, channels, "/odom")
            ids = [100 + channels["/odom"]["id"]]
            await viewer.send(json.dumps({"op": "unsubscribe", "subscriptionIds": ids}))
            await asyncio.sleep(0.1)
            server.drive.told(server.drive.state(seq=4), None)
            with pytest.raises(TimeoutError):
                await message(viewer, channels, "/odom", within=0.3)

    with shown() as server:
        asyncio.run(watch(server))


def test_a_viewer_changes_nothing_whatever_it_sends(shown):
    async def watch(server):
        async with open_viewer(server) as viewer:
            channels = await greeted(viewer)
            for text in NONSENSE:
                await viewer.send(text)
            await viewer.send(b"\x01\x01\x00\x00\x00stop")
            await subscribe(viewer, channels, "/odom")
            await asyncio.sleep(0.1)
            server.drive.told(server.drive.state(), None)
            await message(viewer, channels, "/odom")
        assert server.drive.said == []
        assert server.drive.joined_as == {}

    with shown() as server:
        asyncio.run(watch(server))


def status_of_refusal(server, **options):
    async def refused():
        with pytest.raises(InvalidStatus) as found:
            async with open_viewer(server, **options):
                pass
        return found.value.response.status_code

    return asyncio.run(refused())


@pytest.mark.parametrize("origin", ["https://evil.example", None, "null"])
def test_a_site_that_was_not_named_may_not_watch(shown, origin):
    with shown() as server:
        assert status_of_refusal(server, origin=origin) == 403


def test_without_the_option_there_are_no_viewers(served):
    with served(Shown()) as server:
        assert status_of_refusal(server, origin=VIEWER) == 403
        assert status_of_refusal(server, origin=server.origin) == 404


def test_a_viewer_of_an_allowed_site_cannot_be_a_page(shown):
    async def refused(server):
        with pytest.raises(InvalidStatus) as found:
            async with server.ws(origin=VIEWER):
                pass
        return found.value.response.status_code

    with shown() as server:
        assert asyncio.run(refused(server)) == 403


def test_a_flood_closes_the_viewer_only(shown):
    async def flood(server):
        async with open_viewer(server) as viewer:
            await greeted(viewer)
            with contextlib.suppress(ConnectionClosed):
                for _ in range(2000):
                    await viewer.send("{}")
                    await asyncio.sleep(0)
            with pytest.raises(ConnectionClosed):
                await viewer.recv()
        async with open_viewer(server) as viewer:
            await greeted(viewer)

    with shown() as server:
        asyncio.run(flood(server))


def test_another_protocol_is_refused(shown):
    with shown() as server:
        assert status_of_refusal(server, protocol="chat") == 403


def test_where_drivers_need_a_token_viewers_do_too(shown):
    async def watch(server, token):
        async with open_viewer(server, query=f"?token={token}") as viewer:
            return await greeted(viewer)

    with shown(tokens=TOKENS) as server:
        assert status_of_refusal(server) == 401
        assert status_of_refusal(server, query="?token=wrong") == 401
        assert "/map" in asyncio.run(watch(server, TOKENS["driver"]))
