"""What the server answers to those who may ask."""

import asyncio
import threading

import pytest

from cohelm.live.messages import Echo, Notice, PersonInfo
from cohelm.live.sessions.database import Database
from cohelm.web.certificate import own_certificate
from cohelm.web.guard import content_policy
from cohelm.web.page_connections import MAX_QUEUED_MESSAGES, CloseCode


@pytest.fixture
def therapist(open_server):
    with open_server.signed_in("therapist") as client:
        yield client


def test_the_page_and_its_files(open_server):
    with open_server.http() as client:
        page = client.get("/")
        assert page.status_code == 200
        assert page.headers["cache-control"] == "no-cache"
        again = client.get("/", headers={"If-None-Match": page.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
        plain = client.get("/assets/a.js", headers={"Accept-Encoding": "identity"})
        assert plain.text == "1;" * 500
        assert "immutable" in plain.headers["cache-control"]


@pytest.mark.parametrize(
    "path", ["/assets/", "/assets/../../etc/passwd", "/%2e%2e/x", "/api/nothing", "/docs", "/ws"]
)
def test_there_is_nothing_else(open_server, path):
    with open_server.http() as client:
        answer = client.get(path)
    assert answer.status_code == 404
    assert answer.json()["code"] == "http_404"


@pytest.mark.parametrize("path", ["/", "/api/health", "/api/nothing", "/api/audit"])
def test_every_answer_carries_what_keeps_pages_apart(open_server, path):
    with open_server.http() as client:
        headers = client.get(path).headers
    policy = headers["content-security-policy"]
    assert policy == content_policy(open_server.name, tls=False)
    assert "unsafe" not in policy
    assert f"connect-src 'self' ws://{open_server.name};" in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert "server" not in headers
    assert "access-control-allow-origin" not in headers


def test_on_this_machine_driving_needs_no_token_and_the_therapist_does(open_server):
    with open_server.http() as client:
        assert client.get("/api/me").json() == {"role": "driver", "needs_token": False}
        assert client.get("/api/limits").status_code == 200
        assert client.get("/api/audit").status_code == 403
    with open_server.signed_in("therapist") as client:
        assert client.get("/api/me").json()["role"] == "therapist"
        assert client.get("/api/audit").status_code == 200


def test_the_cookie_is_for_the_server_alone(open_server):
    with open_server.http() as client:
        token = open_server.tokens["therapist"]
        cookie = client.post("/api/sign-in", json={"token": token}).headers["set-cookie"]
    assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(cookie.split("; "))


def test_limits_change_and_the_log_says_who(therapist, drive):
    wanted = {"max_speed": 0.5, "max_acceleration": 0.4, "min_distance": 0.6}
    assert therapist.put("/api/limits", json=wanted).json() == wanted
    assert drive.limits.max_speed == 0.5
    assert drive.audit.noted[-1][:2] == ("therapist 1", "limits")


def test_limits_that_would_rise_have_to_wait(therapist, drive):
    drive.moving = True
    wanted = {"max_speed": 1.0, "max_acceleration": 0.4, "min_distance": 0.6}
    answer = therapist.put("/api/limits", json=wanted)
    assert (answer.status_code, answer.json()["code"]) == (409, "limits_loosened")
    assert drive.limits.max_speed == 0.8


def test_a_therapist_allows_edges_while_the_chair_stands(therapist, drive, open_server):
    assert therapist.post("/api/edges").status_code == 204
    assert drive.audit.noted[-1][:2] == ("therapist 1", "edges_allowed")
    drive.moving = True
    assert therapist.post("/api/edges").status_code == 409
    with open_server.http() as driver:
        assert driver.post("/api/edges").status_code == 403


@pytest.mark.parametrize(
    "body",
    [
        "{}", "[]", "", "null", "{", '{"max_speed": 1e999}', "[" * 8000,
        '{"max_speed": NaN, "max_acceleration": 0.4, "min_distance": 0.6}',
        '{"max_speed": 9, "max_acceleration": 0.4, "min_distance": 0.6}',
        '{"max_speed": 0.5, "max_acceleration": 0.4, "min_distance": 0.6, "more": 1}',
        '"\\ud800"',
    ],
)  # fmt: skip
def test_limits_that_are_none_are_refused(therapist, drive, body):
    kind = {"Content-Type": "application/json"}
    answer = therapist.put("/api/limits", content=body, headers=kind)
    assert answer.status_code in {400, 422}
    assert set(answer.json()) == {"code", "text"}
    assert drive.limits.max_speed == 0.8


def test_the_riders_settings_change(therapist, drive):
    answer = therapist.put("/api/rider", json={"dwell": 2.0})
    assert answer.json() == {
        "tremor_filter": 0.0,
        "dead_zone": 0.08,
        "dwell": 2.0,
        "start_at_once": False,
        "switches": None,
    }
    assert drive.rider.dwell == 2.0


def test_sessions_are_deleted_at_once_and_the_log_says_so(therapist, drive):
    assert therapist.get("/api/sessions").json() == []
    assert therapist.get("/api/sessions/20260101-101010.html").status_code == 404
    assert therapist.delete("/api/sessions").json() == {"deleted": 3}
    assert drive.audit.noted[-1] == ("therapist 1", "sessions_deleted", {"sessions": 3})


def test_what_is_learned_is_shown_to_the_therapist_and_forgotten(therapist, drive, tmp_path):
    drive.sessions.database = Database(tmp_path)
    shown = therapist.get("/api/response").json()
    assert (shown["tight_speed"], shown["rides"]["tight_speed"], shown["since"]) == (0.8, 0, "")
    assert therapist.delete("/api/response").json()["since"]
    assert drive.audit.noted[-1] == ("therapist 1", "response_reset", {})


def test_the_floor_is_kept_by_its_name(open_server):
    with open_server.http() as client:
        assert client.get("/api/floor/abc.png").headers["content-type"] == "image/png"
        assert client.get("/api/floor/old.png").status_code == 404


def test_the_floor_s_solids_have_heights(open_server):
    with open_server.http() as client:
        found = client.get("/api/floor/solids").json()
        assert (found["wall_height"], found["solids"][0]["height"]) == (2.5, 0.5)


def test_a_page_is_welcomed_first_and_answered(open_server, drive):
    async def talk():
        async with open_server.ws() as page:
            welcome = await open_server.told(page, "welcome")
            await page.send('{"type": "echo", "id": 3}')
            assert (await open_server.told(page, "echo"))["id"] == 3
            drive.told(Notice(code="a", text="b"), welcome["client"])
            assert (await open_server.told(page, "notice"))["text"] == "b"
        return welcome["client"]

    client = asyncio.run(talk())
    open_server.__exit__()
    assert drive.gone == [client]
    assert drive.joined_as == {client: "driver"}
    assert isinstance(drive.said[0][1], Echo)


def test_what_is_for_one_page_is_not_told_to_others(open_server, drive):
    async def talk():
        async with open_server.ws() as one, open_server.ws() as other:
            client = (await open_server.told(one, "welcome"))["client"]
            drive.told(Notice(code="own", text=""), client)
            drive.told(Notice(code="all", text=""), None)
            assert (await open_server.told(one, "notice"))["code"] == "own"
            assert (await open_server.told(other, "notice"))["code"] == "all"

    asyncio.run(talk())


def test_signing_out_closes_the_sessions_pages(open_server):
    async def talk(client):
        cookie = "; ".join(f"{name}={text}" for name, text in client.cookies.items())
        headers = {"Cookie": cookie}
        async with open_server.ws(additional_headers=headers) as own, open_server.ws() as other:
            assert (await open_server.told(own, "welcome"))["role"] == "therapist"
            await asyncio.to_thread(client.post, "/api/sign-out")
            assert await open_server.closed(own) == CloseCode.SIGNED_OUT
            await other.send('{"type": "echo"}')
            await open_server.told(other, "echo")

    with open_server.signed_in("therapist") as client:
        asyncio.run(talk(client))
        assert client.get("/api/audit").status_code == 403


def test_a_page_that_does_not_read_misses_states_and_gets_the_newest(open_server, drive):
    """Nothing piles up: what is sent ahead of a reader is bounded, far below what was told."""
    person = PersonInfo(
        id=0, x=0.0, y=0.0, vx=0.0, vy=0.0, radius=0.3, axis=0.0, front=1.0, side=1.0, rear=1.0
    )
    told = 3000
    crowd = tuple(person.model_copy(update={"id": k}) for k in range(100))

    async def talk():
        async with open_server.ws(max_queue=1) as page:
            await open_server.told(page, "welcome")
            for seq in range(told):
                drive.told(drive.state(seq, crowd), None)
                await asyncio.sleep(0)
            await asyncio.sleep(0.2)
            seen = [(await open_server.told(page, "state"))["seq"]]
            while seen[-1] != told - 1:
                seen.append((await open_server.told(page, "state"))["seq"])
            return seen

    seen = asyncio.run(asyncio.wait_for(talk(), 30.0))
    assert seen == sorted(set(seen))
    assert len(seen) < told / 2


def test_a_page_that_reads_nothing_at_all_is_closed(open_server, drive):
    long = "x" * 100_000

    async def talk():
        async with open_server.ws(max_queue=1) as page:
            await open_server.told(page, "welcome")
            for _ in range(20 * MAX_QUEUED_MESSAGES):
                drive.told(Notice(code="long", text=long), None)
                await asyncio.sleep(0)
            page.transport.pause_reading()
            async with asyncio.timeout(10.0):
                while not drive.gone:
                    await asyncio.sleep(0.05)
            page.transport.abort()

    asyncio.run(talk())
    assert ("rejected", {"closed": "slow"}) in [(what, said) for _, what, said in drive.audit.noted]


def test_states_from_a_thread_that_does_not_wait(open_server, drive):
    """The chair's thread tells; the newest arrives, whatever the server was busy with."""

    def tell():
        for seq in range(1000):
            drive.told(drive.state(seq), None)

    async def talk():
        async with open_server.ws() as page:
            await open_server.told(page, "welcome")
            thread = threading.Thread(target=tell)
            thread.start()
            while (await open_server.told(page, "state"))["seq"] != 999:
                pass
            thread.join()

    asyncio.run(asyncio.wait_for(talk(), 20.0))


def test_tls_from_a_certificate_of_its_own(served, drive, tmp_path):
    import datetime
    import ssl

    tls = own_certificate(tmp_path, ("127.0.0.1",), datetime.datetime.now(datetime.UTC))
    trusted = ssl.create_default_context(cafile=str(tls.certificate))
    with served(drive, tls=tls) as server:
        with server.http(verify=trusted) as client:
            token = {"token": server.tokens["driver"]}
            answer = client.post("/api/sign-in", json=token)
            cookie = answer.headers["set-cookie"]
            assert cookie.startswith("__Host-cohelm-")
            assert "Secure" in cookie.split("; ")
            assert client.get("/api/me").json()["role"] == "driver"
            assert "wss://" in answer.headers["content-security-policy"]
            held = "; ".join(f"{name}={text}" for name, text in client.cookies.items())

        async def talk():
            headers = {"Cookie": held}
            async with server.ws(ssl=trusted, additional_headers=headers) as page:
                await server.told(page, "welcome")

        asyncio.run(talk())
