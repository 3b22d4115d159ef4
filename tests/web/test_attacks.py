"""Attacks, one test each: none of them moves the chair, and none of them ends the server."""

import asyncio
import json
import time

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from websockets.exceptions import InvalidStatus

from cohelm.errors import ConfigError
from cohelm.live.messages import MAX_MESSAGE_SIZE, Heartbeat
from cohelm.web.page_connections import MAX_PAGES_PER_ADDRESS, CloseCode
from cohelm.web.rate_limits import MAX_HEARTBEAT_RATE, MAX_MESSAGE_RATE
from cohelm.web.server import listening, make_context

FULL = '{"type": "heartbeat", "seq": %d, "sent": 0, "forward": 1, "device": "keys"}'


async def refused(server, **options):
    """The status with which a socket is refused."""
    with pytest.raises(InvalidStatus) as error:
        async with server.ws(**options):
            pass
    return error.value.response.status_code


def still_serves(server):
    with server.http() as client:
        return client.get("/api/health").status_code == 200


def beats(drive):
    return [message for _, message, _ in drive.said if isinstance(message, Heartbeat)]


def test_no_token(closed_server, drive):
    with closed_server.http() as client:
        for path in (
            "/api/me", "/api/limits", "/api/audit", "/api/floor/abc.png", "/api/floor/solids",
        ):  # fmt: skip
            assert client.get(path).status_code == 401, path
    assert asyncio.run(refused(closed_server)) == 401
    assert drive.joined_as == {}


def test_wrong_token(closed_server, drive):
    """The fourth is slowed down, the fifth is not even looked at, be it right."""
    with closed_server.http() as client:
        for _ in range(4):
            answer = client.post("/api/sign-in", json={"token": "wrong"})
            assert answer.status_code == 401
            assert "set-cookie" not in answer.headers
        right = client.post("/api/sign-in", json={"token": closed_server.tokens["driver"]})
        assert right.status_code == 429
        assert int(right.headers["retry-after"]) >= 1
        assert client.get("/api/me").status_code == 401
    headers = {"Cookie": f"cohelm-{closed_server.port}=guessed"}
    assert asyncio.run(refused(closed_server, additional_headers=headers)) == 401
    assert [what for _, what, _ in drive.audit.noted].count("sign_in_rejected") == 4


def test_foreign_origin(open_server, drive):
    for origin in ("http://evil.example", "null", "http://127.0.0.1:1", None):
        assert asyncio.run(refused(open_server, origin=origin)) == 403
    with open_server.http(headers={"Origin": "http://evil.example"}) as client:
        assert client.post("/api/sign-in", json={"token": "x"}).status_code == 403
        assert client.get("/api/limits").status_code == 403
    assert drive.joined_as == {}


def test_wrong_host(open_server, drive):
    """As a page has it whose name was made to lead here."""
    evil = {"Host": "evil.example", "Origin": "http://evil.example"}
    with open_server.http(headers=evil) as client:
        for path in ("/", "/api/health", "/api/me"):
            assert client.get(path).status_code == 421
    headers = {"Host": "evil.example"}
    status = asyncio.run(
        refused(open_server, origin="http://evil.example", additional_headers=headers)
    )
    assert status in {400, 421}  # two hosts, or the other one
    assert drive.joined_as == {}


def test_oversize_messages(open_server, drive):
    async def attack():
        async with open_server.ws() as page:
            await page.send('{"type": "stop", "x": "' + "x" * MAX_MESSAGE_SIZE + '"}')
            return await open_server.closed(page)

    assert asyncio.run(attack()) == 1009
    with open_server.http() as client:
        assert client.post("/api/sign-in", content=b"x" * 100_000).status_code == 413
    assert drive.said == []
    assert still_serves(open_server)


def answers(server, messages):
    """What the server says to each; few at a time, for it does not bear with many."""

    async def attack():
        said = []
        for first in range(0, len(messages), 8):
            async with server.ws() as page:
                for message in messages[first : first + 8]:
                    await page.send(message)
                    said.append(await server.told(page, "rejected"))
        return said

    return asyncio.run(attack())


MALFORMED = [
    "", "null", "[]", "0", "{}", '"stop"', '{"type": "go_faster"}', '{"type": "stop", "now": 1}',
    '{"type": "heartbeat"}', "{" * 5000, "[" * 16_000, '{"type": "stop"', b"\x00\xff",
    b'{"type": "stop"}', '{"type": "set_goal", "place": ""}',
    '{"type": "set_goal", "place": "\\ud800"}',
    '{"type": "set_goal", "wishes": [{"kind": "attract", "points": []}]}',
]  # fmt: skip


def test_malformed_messages(open_server, drive):
    assert {each["code"] for each in answers(open_server, MALFORMED)} == {"malformed"}
    assert drive.said == []


def test_malformed_messages_again_and_again(open_server, drive):
    async def attack():
        async with open_server.ws() as page:
            for _ in range(30):
                await page.send("nonsense")
            return await open_server.closed(page)

    assert asyncio.run(attack()) == CloseCode.MALFORMED
    assert still_serves(open_server)


ECHO = '{"type": "echo", "id": %d}'


@pytest.mark.parametrize(
    ("message", "most"), [(FULL, MAX_HEARTBEAT_RATE), (ECHO, MAX_MESSAGE_RATE)]
)
def test_a_thousand_messages_a_second(open_server, drive, message, most):
    """Those of one second at once, and then as many as the rate lets through while they come."""

    async def attack():
        async with open_server.ws() as page:
            began = time.monotonic()
            for k in range(1000):
                await page.send(message % k)
            return await open_server.closed(page), time.monotonic() - began

    code, taken = asyncio.run(attack())
    assert code == CloseCode.TOO_MANY
    assert len(drive.said) <= most * (1.0 + taken)
    assert still_serves(open_server)


NUMBERS = ("NaN", "Infinity", "-Infinity", "1e308", "1e999", "-2", '"1"', "true", "null")
NUMBERED = (
    '{"type": "heartbeat", "seq": 0, "sent": 0, "forward": %s}',
    '{"type": "heartbeat", "seq": %s, "sent": 0}',
    '{"type": "set_goal", "point": [%s, 1e999]}',
    '{"type": "set_goal", "wishes": [{"kind": "avoid", "points": [[0, 0]], "radius": %s}]}',
)


def test_nan_and_huge_values(open_server, drive):
    messages = [message % number for message in NUMBERED for number in NUMBERS]
    assert {each["code"] for each in answers(open_server, messages)} == {"malformed"}
    assert drive.said == []


def test_fifty_sockets_at_once(open_server, drive):
    """No more than eight from one address come in, and there is room again when they have left."""

    async def attempt(entered, leave):
        try:
            async with open_server.ws() as page:
                await open_server.told(page, "welcome")
                entered.append(page)
                await leave.wait()
        except InvalidStatus as error:
            return error.response.status_code
        return 101

    async def attack():
        entered, leave = [], asyncio.Event()
        tries = [asyncio.create_task(attempt(entered, leave)) for _ in range(50)]
        while sum(task.done() for task in tries) < 50 - MAX_PAGES_PER_ADDRESS:
            await asyncio.sleep(0.01)
        leave.set()
        statuses = await asyncio.gather(*tries)
        return len(entered), statuses

    entered, statuses = asyncio.run(asyncio.wait_for(attack(), 20.0))
    assert entered == MAX_PAGES_PER_ADDRESS
    assert set(statuses) <= {101, 429, 503}
    assert len(drive.joined_as) == MAX_PAGES_PER_ADDRESS
    assert still_serves(open_server)

    async def again():
        for _ in range(50):
            try:
                async with open_server.ws() as page:
                    return await open_server.told(page, "welcome")
            except InvalidStatus:
                await asyncio.sleep(0.1)
        return None

    assert asyncio.run(again())


def test_the_drivers_token_on_the_therapists_limits(closed_server, drive):
    wanted = {"max_speed": 3.0, "max_acceleration": 2.0, "min_distance": 0.0}
    with closed_server.signed_in("driver") as client:
        for answer in (
            client.put("/api/limits", json=wanted),
            client.put("/api/rider", json={}),
            client.get("/api/audit"),
            client.get("/api/sessions"),
            client.get("/api/sessions/20260101-101010.csv"),
            client.delete("/api/sessions"),
        ):
            assert (answer.status_code, answer.json()["code"]) == (403, "therapist_only")
        assert client.get("/api/limits").status_code == 200
    assert drive.limits.max_speed == 0.8


def test_a_cookie_of_another_session_or_server(closed_server, drive):
    with closed_server.signed_in("driver") as client:
        name, text = next(iter(client.cookies.items()))
        client.post("/api/sign-out")
    headers = {"Cookie": f"{name}={text}"}
    with closed_server.http(headers={"Origin": closed_server.origin, **headers}) as client:
        assert client.get("/api/me").status_code == 401
    assert asyncio.run(refused(closed_server, additional_headers=headers)) == 401


def test_a_request_that_never_ends_is_dropped(open_server, monkeypatch):
    monkeypatch.setattr("cohelm.web.guard.BODY_TIMEOUT", 0.2)

    async def attack():
        reader, writer = await asyncio.open_connection("127.0.0.1", open_server.port)
        writer.write(
            f"POST /api/sign-in HTTP/1.1\r\nHost: {open_server.name}\r\n"
            f"Origin: {open_server.origin}\r\nContent-Length: 100\r\n\r\n{{".encode()
        )
        status = await asyncio.wait_for(reader.readline(), 5.0)
        writer.close()
        return status

    assert b" 408 " in asyncio.run(attack())


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.7", "chair.local", "::"])
def test_others_are_not_let_near_without_token_and_tls(drive, tmp_path, host):
    with listening("127.0.0.1", 0) as bound:
        both = {"therapist": "a", "driver": "b"}
        for tokens, tls in ((both, None), ({"therapist": "a"}, tmp_path)):
            with pytest.raises(ConfigError, match="certificate and a driver's token"):
                make_context(drive, {}, bound, host=host, tokens=tokens, tls=tls)


def test_schemathesis_finds_no_fault_of_the_server(open_server):
    """What its strategies make of the API's own description, with the therapist's rights."""
    with open_server.signed_in("therapist") as client:
        schema = schemathesis.openapi.from_dict(client.get("/api/openapi.json").json())
        tried = 0
        for found in schema.get_all_operations():
            operation = found.ok()
            if operation.path == "/api/sign-in":  # it locks itself; see the one below
                continue

            @settings(max_examples=15, suppress_health_check=list(HealthCheck))
            @given(case=operation.as_strategy())
            def law(case):
                nonlocal tried
                tried += 1
                answer = client.request(
                    case.method,
                    case.formatted_path,
                    params=case.query or None,
                    content=json.dumps(case.body).encode() if case.method == "PUT" else None,
                    headers={"Content-Type": "application/json"},
                )
                assert answer.status_code < 500

            law()
    assert tried > 100


@pytest.mark.parametrize("token", ["", "\x00", "x" * 201, "\ud800", "é" * 50, 5, None, [], {}])
def test_tokens_that_are_none(open_server, token):
    with httpx.Client(base_url=open_server.origin) as client:
        answer = client.post(
            "/api/sign-in",
            content=json.dumps({"token": token}),
            headers={"Origin": open_server.origin, "Content-Type": "application/json"},
        )
    assert answer.status_code in {400, 401, 422}
