"""What is kept of sessions: whole, private, and gone by one action."""

import csv
import io
import multiprocessing
import os
import re
import stat
import threading
import time
from dataclasses import replace
from html.parser import HTMLParser
from multiprocessing.connection import Connection
from types import SimpleNamespace

import pytest
from PIL import Image

from cohelm.errors import StoreError
from cohelm.evaluation.metrics.measures import RIDE_MEASURES
from cohelm.live.messages import Limits
from cohelm.live.sessions import measuring
from cohelm.live.sessions import store as module
from cohelm.live.sessions.database import FILE
from cohelm.live.sessions.records import LimitsAt, RideBegin, RideSummary, default_folder
from cohelm.live.sessions.ride_log import RideLogWriter, facts_of_log
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Reason
from cohelm.navigation import Navigator
from cohelm.safety import stop
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import World

from .disk import full_disk

LIMITS = Limits(max_speed=0.7, max_acceleration=0.5, min_distance=0.45)


@pytest.fixture(scope="module")
def ride_setup():
    return build_scenario(load_scenario("distracted"), 1)


@pytest.fixture(scope="module")
def ticks(ride_setup):
    """Two seconds of a ride."""
    world, navigator, out, last = (
        World(ride_setup.world, 1),
        Navigator(ride_setup.navigator),
        [],
        None,
    )
    for _ in range(40):
        last = navigator.step(world.observe(), ride_setup.request, last)
        out.append((last, world.truth))
        world.advance(last.decision)
    return out


@pytest.fixture
def here(monkeypatch):
    """Rides are measured in this process, which is quicker for so short ones."""

    class Here(threading.Thread):
        """Thread with an end of the pipe of its own, as a process has."""

        exitcode = 0

        def __init__(self, target, args, daemon):
            *given, sender = args
            own = Connection(os.dup(sender.fileno()), readable=False)
            super().__init__(target=self._answer, args=(target, given, own), daemon=daemon)

        @staticmethod
        def _answer(target, given, sender):
            with sender:
                target(*given, sender)

    here = SimpleNamespace(Process=Here, Pipe=multiprocessing.Pipe)
    monkeypatch.setattr(measuring, "spawn", here)
    monkeypatch.setattr(measuring.os, "nice", lambda _: 19)


@pytest.fixture
def store(tmp_path, here):
    store = SessionStore(tmp_path / "data")
    yield store
    store.close()


def record(ride, session="", **changes):
    fields = {
        "id": ride,
        "session": session or ride.rpartition("-r")[0],
        "started": "2026-01-31T14:25:30+00:00",
        "seed": 3,
        "destination": "Ward 4",
        "outcome": "arrived",
        "duration": 12.5,
        "length": 8.25,
        "modes": {"shared": 10.0, "assisted": 2.5},
        "devices": {"joystick": 4.0},
        "limits": (LimitsAt(time=0.0, limits=LIMITS),),
    }
    return RideSummary(**{**fields, **changes})


def logged(ride, session, file, ride_setup, ticks):
    """The answer of the navigator's process to a ride with these ticks."""
    book = RideLogWriter(lambda: facts_of_log(ride_setup))
    summary = record(ride, outcome="cancelled", duration=0.0).model_dump_json()
    book.begin(RideBegin(ride, file, session.model_dump_json(), summary))
    for tick, truth in ticks:
        book.add(tick, truth)
    book.end(record(ride).model_dump_json())
    book.close()
    return book.finished()


def driven(store, ride_setup, ticks=(), **changes):
    """A ride that is kept, with a log where there are ticks; its id."""
    ride, session, file = store.begin_ride()
    log = logged(ride, session, file, ride_setup, ticks) if ticks else None
    store.keep(record(ride, **changes), log, ride_setup)
    return ride


def test_a_ride_is_measured_and_mapped_in_a_process_aside(tmp_path, ride_setup, ticks):
    store = SessionStore(tmp_path)
    facts = store.begin(ride_setup)
    ride = driven(store, ride_setup, ticks)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert kept.id == ride
    assert not kept.error
    assert kept.measures["path_length"] > 0.0
    assert kept.measures.keys() <= set(RIDE_MEASURES)
    with Image.open(io.BytesIO(store.png(ride))) as picture:
        assert picture.format == "PNG"
        assert max(picture.size) <= 1200
    assert store.png(facts.id) == store.png(ride)
    left = {file.name for file in store.folder.rglob("*") if file.is_file()}
    assert left == {FILE, f"{ride}.mcap"}
    assert not store.error
    store.close()


def test_the_newest_session_comes_first_and_empty_ones_are_not_there(tmp_path, ride_setup, here):
    ids = []
    for _ in range(3):
        store = SessionStore(tmp_path)
        facts = store.begin(ride_setup)
        if len(ids) != 1:
            driven(store, ride_setup)
            driven(store, ride_setup)
        store.close()
        ids.append(facts.id)
    listed = SessionStore(tmp_path).list()
    assert [each.session.id for each in listed] == [ids[2], ids[0]]
    assert [[ride.id for ride in each.rides] for each in listed] == [
        [f"{id_}-r1", f"{id_}-r2"] for id_ in (ids[2], ids[0])
    ]


def test_a_rating_stays_beside_measures_that_come_later(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    ride = driven(store, ride_setup, ticks)
    store.rate(ride, 4)
    store.wait_until_idle()
    store.rate(ride, 5)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert kept.rating == 5
    assert kept.measures


@pytest.mark.parametrize(
    "name", ["20260101-000000-r1", "../settings", "/etc/passwd", "", "a\0b", "x" * 3000]
)
def test_what_is_not_there_is_not_found_wherever_it_points(store, name):
    for ask in (store.summary, store.html, store.csv, store.png):
        with pytest.raises(StoreError, match="there is no"):
            ask(name)
    with pytest.raises(StoreError, match="there is no such ride"):
        store.rate(name, 3)


def test_only_the_owner_reads_it(store, ride_setup, ticks):
    store.begin(ride_setup)
    driven(store, ride_setup, ticks)
    store.wait_until_idle()
    for file in (store.folder, *store.folder.rglob("*")):
        assert stat.S_IMODE(file.stat().st_mode) == (0o700 if file.is_dir() else 0o600), file


def test_one_action_deletes_it_all_but_what_is_not_of_a_session(store, ride_setup, ticks):
    store.begin(ride_setup)
    store.database.set("settings", "x")
    ride = driven(store, ride_setup, ticks, destination="Oncology")
    store.wait_until_idle()
    png = store.png(ride)
    assert store.delete_all() == 1
    assert store.list() == ()
    assert not [*store.folder.rglob("*.mcap")]
    left = (store.folder / FILE).read_bytes()
    assert b"Oncology" not in left  # it is overwritten, too
    assert png[:2000] not in left
    assert store.database.setting("settings") == "x"
    with pytest.raises(StoreError, match="there is no such ride"):
        store.rate(ride, 5)


def test_who_still_measures_while_all_is_deleted_keeps_nothing_of_it(
    store, ride_setup, ticks, monkeypatch
):
    begun, deleted, real = threading.Event(), threading.Event(), module.measure_in_subprocess

    def slowly(*given):
        found = real(*given)
        begun.set()
        assert deleted.wait(30.0)
        return found

    monkeypatch.setattr(module, "measure_in_subprocess", slowly)
    store.begin(ride_setup)
    ride = driven(store, ride_setup, ticks)
    assert begun.wait(30.0)
    assert store.delete_all() == 1
    deleted.set()
    store.wait_until_idle()
    assert store.list() == ()
    with pytest.raises(StoreError, match="no map of"):
        store.png(ride)


def test_what_could_not_be_deleted_is_named_and_is_the_next_time(store, ride_setup, ticks):
    store.begin(ride_setup)
    ride = driven(store, ride_setup, ticks)
    store.wait_until_idle()
    log = store.log_file(ride)
    log.unlink()
    log.mkdir()
    (log / "x").mkdir(mode=0o000)
    with pytest.MonkeyPatch.context() as broken:
        broken.setattr(module.shutil, "rmtree", refuses)
        with pytest.raises(StoreError, match=rf"{ride}\.mcap: cannot be deleted \(Read-only"):
            store.delete_all()
    assert store.list() == ()  # it is deleted for every page
    SessionStore(store.folder).close()  # and a program that starts later goes on with it
    assert not log.exists()


def refuses(_folder):
    raise OSError(30, "Read-only file system")


def test_data_of_older_versions_is_named_and_deleted_with_the_rest(tmp_path, ride_setup):
    old = tmp_path / "20260131-142530"
    old.mkdir()
    (old / "session.json").write_text("{}")
    others = tmp_path / "project"
    others.mkdir()
    store = SessionStore(tmp_path)
    (found,) = store.list()
    assert "older version" in found.session.scene
    assert "older version" in store.html(old.name)
    assert store.unreadable() == 1
    assert store.delete_all() == 1
    assert not old.exists()
    assert others.exists()
    store.close()


def test_a_session_that_was_deleted_is_never_another_one(store, ride_setup):
    """Within the same second, too: somebody may still write of its rides."""
    names = set()
    for _ in range(3):
        names.add(store.begin(ride_setup).id)
        names.add(store.begin_ride()[0])
        store.delete_all()
        names.add(store.begin_ride()[0])
    assert len(names) == 9


def test_a_ride_that_was_going_on_when_all_was_deleted_is_not_kept_and_the_next_one_is(
    store, ride_setup, ticks
):
    first = store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    store.delete_all()
    log = logged(ride, session, file, ride_setup, ticks)  # which knows of no deletion
    store.keep(record(ride), log, ride_setup)
    store.wait_until_idle()
    assert store.list() == ()
    later = driven(store, ride_setup)
    store.wait_until_idle()
    (session,) = store.list()
    assert [each.id for each in session.rides] == [later]
    assert session.session.scene == first.scene
    again = SessionStore(store.folder)
    assert [each.id for found in again.list() for each in found.rides] == [later]
    assert not file.exists()
    again.close()


def test_a_ride_whose_log_is_lost_is_kept_and_says_so(store, ride_setup):
    facts = store.begin(ride_setup)
    driven(store, ride_setup)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert "navigator was lost" in kept.error
    assert not kept.measures
    assert "navigator was lost" in store.html(facts.id)
    with pytest.raises(StoreError, match="no map of"):
        store.png(facts.id)


def test_of_a_navigator_that_was_killed_the_log_is_measured(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    logged(ride, session, file, ride_setup, ticks)  # which nobody hears of
    store.keep(record(ride), None, ride_setup)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert "navigator was lost" in kept.error
    assert kept.measures["path_length"] > 0.0
    assert "path_error" in kept.measures  # the route is in the log as well
    assert store.png(ride)


def test_a_full_disk_is_said_and_a_rating_is_stored_once_there_is_space(store, ride_setup):
    facts = store.begin(ride_setup)
    ride = driven(store, ride_setup)
    store.wait_until_idle()
    with full_disk():
        store.rate(ride, 1)
        store.wait_until_idle()
        assert "cannot be written" in store.error
        store.retry()
        store.wait_until_idle()
        assert store.error
    store.retry()
    store.wait_until_idle()
    assert not store.error
    assert store.summary(facts.id).rides[0].rating == 1


def test_a_record_that_cannot_be_read_hides_no_other_one_and_says_so(store, ride_setup):
    facts = store.begin(ride_setup)
    one, two = driven(store, ride_setup), driven(store, ride_setup)
    store.wait_until_idle()
    store.database.write("UPDATE ride SET summary = '{}' WHERE id = ?", one)
    other, sound = store.summary(facts.id).rides
    assert (other.id, sound.id) == (one, two)
    assert "cannot be read" in other.error
    assert "cannot be read" in store.html(facts.id)


@pytest.mark.parametrize("damage", [b"", b"no database at all, but long enough" * 100])
def test_a_damaged_index_is_named_and_the_rides_are_read_again_without_it(
    store, ride_setup, ticks, damage
):
    store.begin(ride_setup, "rider-00000001")
    ride = driven(store, ride_setup, ticks)
    store.wait_until_idle()
    measures = store.list()[0].rides[0].measures
    file = store.folder / FILE
    file.write_bytes(damage)
    if damage:
        with pytest.raises(StoreError, match=r"cohelm\.sqlite: cannot be read .*move it away"):
            SessionStore(store.folder)
        file.unlink()
    again = SessionStore(store.folder)
    again.wait_until_idle()
    ((kept,),) = [each.rides for each in again.list()]
    assert (kept.id, kept.destination) == (ride, "Ward 4")
    assert kept.measures == measures
    assert (kept.outcome, kept.error) == ("arrived", "")
    assert again.list()[0].session.rider == "rider-00000001"
    again.close()


@pytest.mark.slow
def test_what_takes_too_long_at_the_end_is_measured_at_the_next_start(
    tmp_path, ride_setup, ticks, monkeypatch
):
    """However long it would take, and whether the program ended or was killed."""
    store = SessionStore(tmp_path)
    store.begin(ride_setup)
    rides = [driven(store, ride_setup, ticks) for _ in range(2)]
    monkeypatch.setattr(module, "CLOSE_TIMEOUT", 0.1)
    began = time.monotonic()
    store.close()
    assert time.monotonic() - began < 3.0
    assert not multiprocessing.active_children()
    again = SessionStore(tmp_path)
    assert [ride.measures for each in again.list() for ride in each.rides] == [{}, {}]
    again.wait_until_idle()
    (kept,) = again.list()
    assert [ride.id for ride in kept.rides] == rides
    assert all(ride.measures["path_length"] > 0.0 and not ride.error for ride in kept.rides)
    again.close()


def cut(content):
    return content[: content.rindex(b"zstd", 0, len(content) // 2) + 2000]


def broken(content):
    at = content.rindex(b"zstd", 0, len(content) // 2) + 2000
    return content[:at] + bytes(100) + content[at + 100 :]


@pytest.mark.parametrize("damage", [bytes, cut, broken])
def test_the_log_of_a_killed_program_is_finished_and_measured_at_the_next_start(
    store, ride_setup, ticks, damage
):
    store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    logged(ride, session, file, ride_setup, ticks * 20)
    before = damage(file.read_bytes())
    file.write_bytes(before)
    again = SessionStore(store.folder)
    again.wait_until_idle()
    ((kept,),) = [each.rides for each in again.list()]
    again.close()
    assert (kept.id, kept.destination) == (ride, "Ward 4")
    assert kept.outcome == ("arrived" if damage is bytes else "cancelled")
    assert ("interrupted" in kept.error) == (damage is not bytes)
    assert kept.measures["path_length"] > 0.0
    assert file.read_bytes() == before  # raw data stay as they are


@pytest.mark.parametrize("garbage", [b"", b"garbage" * 500])
def test_a_log_that_cannot_be_read_is_shown_and_kept(store, ride_setup, ticks, garbage, caplog):
    store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    logged(ride, session, file, ride_setup, ticks)
    file.write_bytes(garbage)
    again = SessionStore(store.folder)
    again.wait_until_idle()
    ((kept,),) = [each.rides for each in again.list()]
    assert file.name in kept.error
    assert file.name in caplog.text
    assert again.unreadable() == 1
    assert ride in again.csv(session.id)
    again.close()
    assert file.read_bytes() == garbage
    assert SessionStore(store.folder).list()[0].rides == (kept,)


def test_a_damaged_log_of_a_ride_that_ended_is_measured_and_says_so(store, ride_setup, ticks):
    store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    log = logged(ride, session, file, ride_setup, ticks)
    file.write_bytes(file.read_bytes()[:-20])
    store.keep(record(ride), log, ride_setup)
    store.wait_until_idle()
    ((kept,),) = [each.rides for each in store.list()]
    assert "The log is damaged: is cut off here" in kept.error
    assert kept.measures["path_length"] > 0.0


def test_a_ride_that_a_full_disk_refused_is_stored_once_there_is_space(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    with full_disk():
        ride = driven(store, ride_setup, ticks)
        store.wait_until_idle()
        assert "cannot be written" in store.error
        store.rate(ride, 4)
        store.wait_until_idle()
        store.retry()
        store.wait_until_idle()
        assert store.error
    store.retry()
    store.wait_until_idle()
    assert store.error == ""
    (kept,) = store.summary(facts.id).rides
    assert (kept.id, kept.rating) == (ride, 4)
    assert f"{len(ticks)} ticks of this ride" in kept.error


class _Page(HTMLParser):
    """Everything that a page refers to, and its text."""

    def __init__(self, text):
        super().__init__()
        self.links, self.text, self.tags = [], "", []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for name, value in attrs if name in {"src", "href", "srcset"}]

    def handle_data(self, data):
        self.text += data


def test_the_page_needs_nothing_else_and_says_what_happened(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    tick, truth = ticks[-1]
    held = replace(tick, decision=stop(Reason.BLOCKED))
    driven(store, ride_setup, [*ticks, (held, truth)], rating=4)
    store.wait_until_idle()
    html = store.html(facts.id)
    page = _Page(html)
    assert page.links
    assert all(link.startswith("data:image/png;base64,") for link in page.links)
    assert "script" not in page.tags
    assert not re.search(r"url\(|@import|https?:", html)
    for said in ("Ward 4", "arrived", "4 of 5", "Obstacle in the way. Stopped.", "0.7 m/s"):
        assert said in page.text, said
    assert "prefers-color-scheme:dark" in html
    assert "@media print" in html


@pytest.mark.parametrize(("to", "said"), [("Ward 4", "cancelled after"), ("", "ended after")])
def test_a_ride_that_did_not_arrive_was_left_on_the_way(store, ride_setup, to, said):
    facts = store.begin(ride_setup)
    driven(store, ride_setup, destination=to, outcome="cancelled")
    store.wait_until_idle()
    assert said in store.html(facts.id)


def test_names_are_text_in_page_and_table(store, ride_setup):
    facts = store.begin(ride_setup)
    driven(store, ride_setup, destination='=HYPERLINK("x")<script>alert(1)</script>')
    store.wait_until_idle()
    assert "<script>" not in store.html(facts.id)
    (row,) = csv.DictReader(io.StringIO(store.csv(facts.id)))
    assert row["destination"].startswith("'=HYPERLINK")


def test_the_table_has_a_row_for_each_ride_with_every_measure(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    one = driven(store, ride_setup, ticks)
    driven(store, ride_setup, rating=2)
    store.wait_until_idle()
    rows = list(csv.DictReader(io.StringIO(store.csv(facts.id))))
    assert [row["ride"] for row in rows] == [one, f"{facts.id}-r2"]
    assert set(RIDE_MEASURES) <= rows[0].keys()
    measures = store.summary(facts.id).rides[0].measures
    assert float(rows[0]["path_length"]) == pytest.approx(measures["path_length"], rel=1e-5)
    assert rows[1]["path_length"] == ""
    assert (rows[1]["rating"], rows[1]["limit_max_speed"]) == ("2", "0.7")


def test_a_ride_begins_only_in_a_session(store):
    with pytest.raises(StoreError, match="begin one first"):
        store.begin_ride()


def test_it_lies_where_the_desktop_keeps_data(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "cohelm" / "sessions"
    monkeypatch.setenv("XDG_DATA_HOME", "not/absolute")
    assert default_folder().is_absolute()


def test_a_log_that_appears_after_its_deletion_is_removed(store, ride_setup, ticks):
    store.begin(ride_setup)
    ride, session, file = store.begin_ride()
    store.delete_all()
    log = logged(ride, session, file, ride_setup, ticks)
    assert file.exists()
    store.keep(record(ride), log, ride_setup)
    store.wait_until_idle()
    assert not file.exists()
    assert store.list() == ()
