"""What is kept of sessions: whole, private, and gone by one action."""

import csv
import errno
import io
import multiprocessing
import os
import re
import stat
import threading
import time
from html.parser import HTMLParser
from multiprocessing.connection import Connection
from types import SimpleNamespace

import pytest
from PIL import Image

from cohelm.errors import StoreError
from cohelm.evaluation.metrics.measures import RIDE_MEASURES
from cohelm.live.messages import Limits
from cohelm.live.sessions import measuring, session_files
from cohelm.live.sessions import store as module
from cohelm.live.sessions.files import write_atomically
from cohelm.live.sessions.records import LimitsAt, RideStop, RideSummary, default_folder
from cohelm.live.sessions.ride_log import RideLogWriter
from cohelm.live.sessions.store import SessionStore
from cohelm.navigation import Navigator
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import World

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
            task, sender = args
            own = Connection(os.dup(sender.fileno()), readable=False)
            super().__init__(target=self._answer, args=(target, task, own), daemon=daemon)

        @staticmethod
        def _answer(target, task, sender):
            with sender:
                target(task, sender)

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


def driven(store, ride_setup, ticks=(), **changes):
    """A ride that is kept, with a log where there are ticks; its id."""
    ride, file = store.begin_ride()
    log = None
    if ticks:
        book = RideLogWriter()
        book.begin(ride, file)
        for tick, truth in ticks:
            book.add(tick, truth)
        log = book.end("arrived")
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
    left = {file.name for file in (store.folder / facts.id).iterdir()}
    assert left == {"session.json", f"{ride}.json", f"{ride}.png", f"{ride}.timeline"}
    assert not store.error
    store.close()


def test_the_newest_session_comes_first_and_empty_ones_are_not_there(tmp_path, ride_setup):
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
    assert len(list(tmp_path.iterdir())) == 2


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


def test_one_action_deletes_it_all_but_not_audit_and_settings(store, ride_setup, ticks):
    store.begin(ride_setup)
    (store.folder / "audit.jsonl").write_text("")
    (store.folder / "settings.json").write_text("")
    driven(store, ride_setup, ticks)
    assert store.delete_all() == 1
    store.wait_until_idle()
    assert {file.name for file in store.folder.iterdir()} == {"audit.jsonl", "settings.json"}
    assert store.list() == ()


def test_who_still_writes_while_all_is_deleted_keeps_nothing_of_it(
    store, ride_setup, ticks, monkeypatch
):
    driven_in = store.begin(ride_setup).id
    ride = driven(store, ride_setup, ticks)
    late, remove = [], session_files.shutil.rmtree

    def slowly(folder):
        """As the process that measures may: it does not know that the ride is deleted."""
        with pytest.raises(StoreError):
            write_atomically(store.folder / driven_in / f"{ride}.timeline", b"{}")
        late.append(folder)
        remove(folder)

    with monkeypatch.context() as slow:
        slow.setattr(session_files.shutil, "rmtree", slowly)
        assert store.delete_all() == 1
        store.wait_until_idle()
    assert late
    assert [*store.folder.iterdir()] == []


def test_what_could_not_be_deleted_is_named_and_is_the_next_time(
    store, ride_setup, ticks, monkeypatch
):
    store.begin(ride_setup)
    ride = driven(store, ride_setup, ticks)
    with monkeypatch.context() as broken:
        broken.setattr(session_files.shutil, "rmtree", refuses)
        with pytest.raises(StoreError, match=r"data/\.deleted-.*cannot be deleted \(Read-only"):
            store.delete_all()
    assert store.list() == ()
    with pytest.raises(StoreError, match="there is no such ride"):
        store.rate(ride, 5)
    assert any(store.folder.rglob("*.json"))
    store.wait_until_idle()
    assert store.delete_all() == 0
    assert [*store.folder.iterdir()] == []
    (store.folder / ".deleted-17-20260131-142530").mkdir()
    SessionStore(store.folder).close()  # a program that was killed meanwhile goes on with it
    assert [*store.folder.iterdir()] == []


def test_files_of_others_stay_in_a_shared_folder(tmp_path):
    home = tmp_path / "home"
    own = home / "20260131-142530"
    for folder in (home / "project", home / ".deleted-photos", own):
        folder.mkdir(parents=True)
    home.chmod(0o755)
    others = [
        home / "project" / ".env", home / "project" / "a.measures.csv",
        home / ".deleted-photos" / "a.jpg", own / ".notes", own / "a.measures.txt",
    ]  # fmt: skip
    riders = home / "riders"
    riders.mkdir()
    left = [own / ".session.json.ab12_xyz", riders / ".rider-1.json.ab12_xyz"]
    for file in [*others, *left]:
        file.write_text("x")
        os.utime(file, (time.time() - 3 * 86_400,) * 2)
    SessionStore(home).close()
    assert all(file.exists() for file in others)
    assert not any(file.exists() for file in left)
    assert stat.S_IMODE(home.stat().st_mode) == 0o755


def test_a_session_of_an_impossible_date_is_listed(tmp_path):
    ride = tmp_path / "20261399-999999" / "20261399-999999-r1.json"
    ride.parent.mkdir()
    ride.write_text("{")
    (found,) = SessionStore(tmp_path).list()
    assert [each.error for each in found.rides] != [""]
    assert found.session.started.startswith("1970")


def test_a_session_that_was_deleted_is_never_another_one(store, ride_setup):
    """Within the same second, too: somebody may still write of its rides."""
    names = set()
    for _ in range(3):
        names.add(store.begin(ride_setup).id)
        names.add(store.begin_ride()[0])
        store.delete_all()
        names.add(store.begin_ride()[0])
    assert len(names) == 9


def refuses(_folder):
    raise OSError(errno.EROFS, "Read-only file system")


def test_a_ride_that_was_going_on_when_all_was_deleted_is_not_kept_and_the_next_one_is(
    store, ride_setup
):
    first = store.begin(ride_setup)
    ride, _ = store.begin_ride()
    store.delete_all()
    store.keep(record(ride), None, ride_setup)
    store.wait_until_idle()
    assert store.list() == ()
    later = driven(store, ride_setup)
    store.wait_until_idle()
    (session,) = store.list()
    assert [each.id for each in session.rides] == [later]
    assert session.session.scene == first.scene


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


def test_of_a_navigator_that_was_killed_the_rows_are_measured(store, ride_setup, ticks):
    facts = store.begin(ride_setup)
    ride, file = store.begin_ride()
    book = RideLogWriter()
    book.begin(ride, file)
    for tick, truth in ticks:
        book.add(tick, truth)
    book.end("cancelled")  # which nobody hears of
    store.keep(record(ride), None, ride_setup)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert "navigator was lost" in kept.error
    assert kept.measures["path_length"] > 0.0
    assert "path_error" not in kept.measures
    assert store.png(ride)
    assert not file.exists()


def test_rows_that_cannot_be_measured_leave_the_ride_and_say_why(
    store, ride_setup, ticks, monkeypatch
):
    facts = store.begin(ride_setup)
    ride, file = store.begin_ride()
    book = RideLogWriter()
    book.begin(ride, file)
    book.add(*ticks[0])
    log = book.end("cancelled")
    file.write_bytes(b"")
    store.keep(record(ride), log, ride_setup)
    store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert "holds no tick" in kept.error
    assert file.name in kept.error
    assert file.exists()


def test_a_full_disk_is_said_and_what_was_there_stays(store, ride_setup, monkeypatch):
    facts = store.begin(ride_setup)
    ride = driven(store, ride_setup)
    store.wait_until_idle()
    before = store.summary(facts.id)
    with monkeypatch.context() as broken:
        broken.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
        store.rate(ride, 1)
        store.wait_until_idle()
    assert "cannot be written" in store.error
    assert store.summary(facts.id) == before
    assert not [f for f in (store.folder / facts.id).iterdir() if f.name.startswith(".")]


def test_a_damaged_ride_hides_no_other_one_and_says_so(store, ride_setup, caplog):
    facts = store.begin(ride_setup)
    one, two = driven(store, ride_setup), driven(store, ride_setup)
    store.wait_until_idle()
    (store.folder / facts.id / f"{one}.json").write_text("{")
    damaged, sound = store.summary(facts.id).rides
    assert (damaged.id, sound.id) == (one, two)
    assert f"{one}.json" in damaged.error
    assert f"{one}.json" in caplog.text
    assert f"{one}.json" in store.html(facts.id)


def test_a_session_whose_file_is_damaged_is_still_shown_with_its_rides(store, ride_setup):
    facts = store.begin(ride_setup)
    ride = driven(store, ride_setup)
    store.wait_until_idle()
    (store.folder / facts.id / "session.json").write_bytes(b"\x00\xff")
    (session,) = store.list()
    assert [each.id for each in session.rides] == [ride]
    assert "cannot be read" in session.session.scene
    assert ride in store.csv(facts.id)


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
    assert not [*tmp_path.glob("*/*.rows"), *tmp_path.glob("*/*.task")]
    again.close()


@pytest.mark.parametrize("garbage", [b"of another time", b"", b"\x80\x05N.", bytes(5000)])
def test_a_task_that_cannot_be_used_deletes_no_raw_data(store, ride_setup, ticks, garbage):
    """Neither now nor at the next start, and it is tried once."""
    facts = store.begin(ride_setup)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "task_of", lambda *_: garbage)
        ride = driven(store, ride_setup, ticks)
        store.wait_until_idle()
    (kept,) = store.summary(facts.id).rides
    assert "not measured" in kept.error
    rows = store.folder / facts.id / f"{ride}.rows"
    before = rows.read_bytes()
    assert f"{ride}.rows" in kept.error
    again = SessionStore(store.folder)
    again.wait_until_idle()
    again.close()
    assert rows.read_bytes() == before
    assert rows.with_suffix(".failed").read_bytes() == garbage


def killed(store, ride_setup, ticks, **changes):
    """A ride whose program was killed: begun, with rows, and never ended."""
    store.begin(ride_setup)
    ride, file = store.begin_ride()
    store.checkpoint(record(ride, outcome="cancelled", **changes), ride_setup)
    store.wait_until_idle()
    book = RideLogWriter()
    book.begin(ride, file)
    for tick, truth in ticks:
        book.add(tick, truth)
    return ride


def test_a_ride_of_a_killed_program_is_finished_and_measured_at_the_next_start(
    store, ride_setup, ticks
):
    ride = killed(store, ride_setup, ticks, duration=1.0, length=0.1)
    again = SessionStore(store.folder)
    again.wait_until_idle()
    (session,) = again.list()
    (kept,) = session.rides
    assert kept.id == ride
    assert kept.destination == "Ward 4"
    assert kept.duration == pytest.approx(ticks[-1][1].time - ticks[0][1].time, abs=0.01)
    assert "interrupted" in kept.error
    assert kept.measures["path_length"] == pytest.approx(kept.length, abs=0.05)
    assert not [*store.folder.glob("*/*.begun"), *store.folder.glob("*/*.rows")]
    again.close()


@pytest.mark.parametrize("suffix", [".begun", ".task", ".rows"])
def test_a_ride_of_a_killed_program_whose_files_are_damaged_is_shown_and_loses_none(
    store, ride_setup, ticks, suffix
):
    ride = killed(store, ride_setup, ticks)
    folder = store.folder / ride.rpartition("-r")[0]
    rows = (folder / f"{ride}.rows").read_bytes()
    (folder / f"{ride}{suffix}").write_bytes(b"garbage")
    again = SessionStore(store.folder)
    again.wait_until_idle()
    ((kept,),) = [session.rides for session in again.list()]
    assert kept.id == ride
    assert kept.error
    if suffix == ".task":
        assert (folder / f"{ride}.rows").read_bytes() == rows
    elif suffix == ".begun":
        assert kept.measures["path_length"] > 0.0
    again.close()


def test_rows_of_a_killed_program_are_never_swept(store, ride_setup, monkeypatch):
    """Even if nothing else of the ride is there, and however old they are."""
    store.begin(ride_setup)
    ride, file = store.begin_ride()
    file.write_bytes(b"rows")
    late = file.stat().st_mtime + 90_000.0
    monkeypatch.setattr(session_files.time, "time", lambda: late)
    again = SessionStore(store.folder)
    again.wait_until_idle()
    ((kept,),) = [session.rides for session in again.list()]
    again.close()
    assert kept.id == ride
    assert file.read_bytes() == b"rows"


def test_a_ride_that_a_full_disk_refused_is_stored_once_there_is_space(
    store, ride_setup, ticks, monkeypatch
):
    facts = store.begin(ride_setup)
    with monkeypatch.context() as broken:
        broken.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
        ride = driven(store, ride_setup, ticks)
        store.wait_until_idle()
        assert "cannot be written" in store.error
        store.retry()
        store.wait_until_idle()
        assert store.error
    store.retry()
    store.wait_until_idle()
    assert store.error == ""
    (kept,) = store.summary(facts.id).rides
    assert kept.id == ride
    assert kept.measures["path_length"] > 0.0


def test_an_error_does_not_end_before_the_disk_takes_something(store, ride_setup, monkeypatch):
    store.begin(ride_setup)
    ride = driven(store, ride_setup)
    store.wait_until_idle()
    with monkeypatch.context() as broken:
        broken.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
        store.rate(ride, 1)
        store.wait_until_idle()
        store.retry()
        store.wait_until_idle()
        assert store.error
    store.retry()
    store.wait_until_idle()
    assert not store.error


def test_a_session_with_nothing_but_rows_is_not_removed_when_the_program_ends(tmp_path, ride_setup):
    store = SessionStore(tmp_path)
    store.begin(ride_setup)
    _, file = store.begin_ride()
    file.write_bytes(b"rows")
    store.close()
    assert file.exists()


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
    driven(store, ride_setup, ticks, rating=4, stops=(
        RideStop(time=3.0, duration=1.5, code="blocked", text="Something stands in the way."),
    ))  # fmt: skip
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


def test_a_session_that_a_full_disk_refused_leaves_no_folder(store, ride_setup, monkeypatch):
    with monkeypatch.context() as broken:
        broken.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
        with pytest.raises(StoreError, match="cannot be written"):
            store.begin(ride_setup)
    assert not [each for each in store.folder.iterdir() if each.is_dir()]
    assert not store.list()


def test_an_empty_folder_of_a_killed_program_is_no_session(tmp_path):
    """Killed between the folder and its record, or by an earlier program on a full disk."""
    (tmp_path / "20260131-142530").mkdir()
    kept = tmp_path / "20260131-142531"
    kept.mkdir()
    (kept / "20260131-142531-r1.rows").write_bytes(b"")
    store = SessionStore(tmp_path)
    store.wait_until_idle()
    assert [session.session.id for session in store.list()] == [kept.name]
    store.close()
