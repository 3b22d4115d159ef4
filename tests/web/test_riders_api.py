"""Riders over HTTP: for the therapist alone, within bounds, and never by another path."""

import re

import pytest
from tests.web.test_catalogue import CATALOGUE

from cohelm.errors import StoreError
from cohelm.live.control.limits import ChairMoves
from cohelm.live.rider_choice import DeletedRider, RiderList
from cohelm.live.sessions.audit import AuditEvent
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.progress import rider_progress
from cohelm.live.sessions.riders import RiderStore

LIMITS = {"max_speed": 0.5, "max_acceleration": 0.4, "min_distance": 0.8}
DRAFT = {"name": "Ana", "preset": {"limits": LIMITS}}
ID = "rider-0f3a91c2"


class Riders:
    """Riders in a folder, with a chair that is not there."""

    def __init__(self, folder):
        self.store, self.current, self.moves = RiderStore(Database(folder)), "", False

    def list(self):
        riders, damaged = self.store.list()
        return RiderList(riders=riders, damaged=damaged, current=self.current)

    def create(self, draft, who):
        return self.store.create(draft)

    def change(self, rider, draft, who):
        return self.store.change(rider, draft)

    def choose(self, rider, who):
        if self.moves:
            raise ChairMoves("the rider can be changed only while the chair stands")
        self.current = self.store.get(rider).id if rider else ""
        return self.list()

    def delete(self, rider, who):
        self.store.remove(rider)
        return DeletedRider(sessions=2, unreadable=0)

    def progress(self, rider):
        return rider_progress([], self.store.get(rider).goals)

    def export(self, rider, who):
        return self.store.get(rider).name.encode()


@pytest.fixture
def therapist(open_server, drive, tmp_path):
    drive.riders = Riders(tmp_path)
    with open_server.signed_in("therapist") as client:
        yield client


def test_a_rider_from_the_form_to_the_deletion(therapist, drive):
    made = therapist.post("/api/riders", json=DRAFT)
    assert made.status_code == 201
    at = f"/api/riders/{made.json()['id']}"
    assert therapist.put(at, json={**DRAFT, "notes": "left hand"}).json()["notes"] == "left hand"
    assert therapist.post("/api/riders", json={**DRAFT, "name": " ANA "}).status_code == 409
    chosen = therapist.put("/api/riders/current", json={"rider": made.json()["id"]})
    assert chosen.json()["current"] == made.json()["id"]
    assert therapist.get(f"{at}/progress").json()["min_sessions"] == 6
    export = therapist.get(f"{at}.zip")
    assert export.headers["content-type"] == "application/zip"
    assert "Ana" not in export.headers["content-disposition"]
    assert therapist.delete(at).json() == {"sessions": 2, "unreadable": 0}
    assert therapist.get("/api/riders").json()["riders"] == []


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", ""), ("POST", ""), ("PUT", "/current"), ("PUT", f"/{ID}"), ("DELETE", f"/{ID}"),
        ("GET", f"/{ID}/progress"), ("GET", f"/{ID}.zip"),
    ],
)  # fmt: skip
def test_drivers_see_and_change_no_rider(open_server, drive, tmp_path, method, path):
    drive.riders = Riders(tmp_path)
    with open_server.http() as client:
        answer = client.request(
            method, f"/api/riders{path}", json=DRAFT if method != "GET" else None
        )
    assert (answer.status_code, answer.json()["code"]) == (403, "therapist_only")
    assert drive.riders.list().riders == ()


@pytest.mark.parametrize(
    "changes",
    [
        {"name": ""}, {"name": "x" * 10_000}, {"name": 3}, {"notes": "x" * 2001}, {"more": 1},
        {"preset": {"limits": {**LIMITS, "max_speed": 9}}}, {"goals": [{"kind": "words"}]},
        {"preset": {"limits": LIMITS, "mode": "fly"}}, {"id": ID},
    ],
)  # fmt: skip
def test_what_is_no_rider_is_refused(therapist, drive, changes):
    answer = therapist.post("/api/riders", json={**DRAFT, **changes})
    assert answer.status_code == 422
    assert set(answer.json()) == {"code", "text"}
    assert drive.riders.list().riders == ()


def test_refusals_have_a_status_and_words(therapist, drive, monkeypatch):
    assert therapist.put(f"/api/riders/{ID}", json=DRAFT).status_code == 404
    assert therapist.delete("/api/riders/rider-..%2fx").status_code in {404, 405, 422}
    drive.riders.moves = True
    moving = therapist.put("/api/riders/current", json={"rider": ""})
    assert (moving.status_code, moving.json()["code"]) == (409, "chair_moves")

    def full(draft):
        raise StoreError("cannot be written (No space left on device)", file="x")

    monkeypatch.setattr(drive.riders.store, "create", full)
    answer = therapist.post("/api/riders", json=DRAFT)
    assert (answer.status_code, answer.json()["code"]) == (409, "store")
    assert "No space left" in answer.json()["text"]


def test_each_event_of_the_audit_log_has_words():
    english = CATALOGUE.parent
    texts = (english / "therapist.ts").read_text() + (english / "riders.ts").read_text()
    known = set(re.findall(r'"audit\.(\w+)"', texts))
    assert set(AuditEvent.__args__) <= known
