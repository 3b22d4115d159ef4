"""Who did what: everything, in its order, on one machine and in bounded room."""

import stat
import threading
import time

import pytest

from cohelm.errors import StoreError
from cohelm.live.sessions import audit as module
from cohelm.live.sessions.audit import AuditLog
from cohelm.live.sessions.database import FILE, Database

from .disk import full_disk


@pytest.fixture
def log(tmp_path):
    log = AuditLog(tmp_path / "data")
    yield log
    log.close()


def whats(log, most=1000):
    return [(entry.actor, entry.event) for entry in log.entries(most)]


def test_everything_is_there_and_the_newest_comes_first(log):
    log.log_event("page 1", "control_taken")
    log.log_event(
        "therapist", "limits_changed", before={"max_speed": 1.0}, after={"max_speed": 0.5}
    )
    log.log_event("page 2", "stop_pressed")
    assert whats(log) == [
        ("page 2", "stop_pressed"),
        ("therapist", "limits_changed"),
        ("page 1", "control_taken"),
    ]
    assert log.entries()[1].details["after"] == {"max_speed": 0.5}
    assert whats(log, 1) == [("page 2", "stop_pressed")]


def test_a_new_program_goes_on_where_the_last_one_ended(log, tmp_path):
    log.log_event("a", "drive_started")
    log.close()
    again = AuditLog(tmp_path / "data")
    again.log_event("b", "drive_started")
    assert whats(again) == [("b", "drive_started"), ("a", "drive_started")]
    again.close()


def test_only_the_owner_reads_it(log, tmp_path):
    assert stat.S_IMODE((tmp_path / "data" / FILE).stat().st_mode) == 0o600
    assert stat.S_IMODE((tmp_path / "data").stat().st_mode) == 0o700


def test_it_takes_no_more_room_than_it_may(log, monkeypatch):
    monkeypatch.setattr(module, "MAX_ENTRIES", 100)
    for k in range(50):
        for _ in range(10):
            log.log_event("a", "goal_changed", k=k)
        log.wait_until_idle()
    entries = log.entries(10_000)
    assert len(entries) <= 100
    kept = [entry.details["k"] for entry in entries if entry.event == "goal_changed"]
    assert len(kept) > 80
    assert any(entry.event == "entries_dropped" for entry in entries)
    assert kept == sorted(kept, reverse=True)
    assert kept[0] == 49


def test_a_damaged_entry_does_not_hide_the_others(log, tmp_path):
    log.log_event("a", "connected")
    log.wait_until_idle()
    Database(tmp_path / "data").write("INSERT INTO audit (entry) VALUES ('half a li')")
    log.log_event("a", "disconnected")
    assert whats(log) == [("a", "disconnected"), ("a", "connected")]


def test_no_entry_of_many_threads_is_lost(log):
    def log_event(name):
        for _ in range(100):
            log.log_event(name, "goal_changed")

    threads = [threading.Thread(target=log_event, args=(f"page {k}",)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(log.entries()) == 800


def test_what_a_full_disk_did_not_take_is_counted_and_said(log):
    with full_disk():
        log.log_event("a", "control_taken")
        log.wait_until_idle()
        assert "cannot be written" in log.error
    log.log_event("a", "stop_pressed")
    assert whats(log) == [("a", "stop_pressed"), ("chair", "entries_dropped")]
    assert log.entries()[1].details["count"] == 1
    assert not log.error


def test_a_full_disk_is_said_no_longer_once_there_is_space_though_nothing_happens(log, monkeypatch):
    monkeypatch.setattr(module, "RETRY_PERIOD", 0.05)
    with full_disk():
        log.log_event("a", "control_taken")
        log.wait_until_idle()
        time.sleep(0.3)  # attempts that fail
        assert log.error
    end = time.monotonic() + 30.0
    while log.error and time.monotonic() < end:
        time.sleep(0.02)
    assert not log.error
    assert whats(log) == [("chair", "entries_dropped")]
    assert log.entries()[0].details["count"] == 1


def test_what_json_cannot_say_is_said_as_text(log):
    log.log_event("a", "rejected", why=StoreError("too much"), speed=float("nan"))
    log.log_event("a", "disconnected")
    assert whats(log) == [("a", "disconnected"), ("a", "rejected")]
    assert "too much" in log.entries()[1].details["why"]


def test_a_folder_that_cannot_be_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="file"):
        AuditLog(tmp_path / "file" / "data")


def test_nobody_flushes_out_what_the_therapist_did(log, monkeypatch):
    """A page that takes and releases the stick for hours leaves a count, not megabytes."""
    monkeypatch.setattr(module, "BURST", 5.0)
    log.log_event("therapist 1", "limits_changed", after={"max_speed": 0.5})
    for _ in range(1000):
        log.log_event("a", "control_taken")
    for _ in range(3):
        log.log_event("therapist 1", "limits_changed")
    found = [entry.event for entry in log.entries()]
    assert found.count("control_taken") <= 6
    assert found.count("limits_changed") == 4
    dropped = sum(
        entry.details["count"] for entry in log.entries() if entry.event == "entries_dropped"
    )
    assert dropped + found.count("control_taken") == 1000
