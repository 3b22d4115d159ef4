"""Who did what: everything, in its order, on one machine and in bounded room."""

import json
import stat
import threading

import pytest

from cohelm.driving import audit as module
from cohelm.driving.audit import Audit
from cohelm.errors import StoreError


@pytest.fixture
def log(tmp_path):
    log = Audit(tmp_path / "data")
    yield log
    log.close()


def whats(log, most=1000):
    return [(entry.who, entry.what) for entry in log.entries(most)]


def test_everything_is_there_and_the_newest_comes_first(log):
    log.note("page 1", "took")
    log.note("therapist", "limits", before={"max_speed": 1.0}, after={"max_speed": 0.5})
    log.note("page 2", "stop")
    assert whats(log) == [("page 2", "stop"), ("therapist", "limits"), ("page 1", "took")]
    assert log.entries()[1].said["after"] == {"max_speed": 0.5}
    assert whats(log, 1) == [("page 2", "stop")]


def test_each_line_is_one_json_object_and_nothing_is_ever_written_over(log):
    log.note("a", "joined")
    log.settle()
    before = log.file.read_bytes()
    log.note("a", "left")
    log.settle()
    assert log.file.read_bytes().startswith(before)
    assert [json.loads(line)["what"] for line in log.file.read_text().splitlines()] == [
        "joined",
        "left",
    ]


def test_a_new_program_goes_on_where_the_last_one_ended(log, tmp_path):
    log.note("a", "started")
    log.close()
    again = Audit(tmp_path / "data")
    again.note("b", "started")
    assert whats(again) == [("b", "started"), ("a", "started")]
    again.close()


def test_only_the_owner_reads_it(log):
    log.note("a", "joined")
    log.settle()
    assert stat.S_IMODE(log.file.stat().st_mode) == 0o600
    assert stat.S_IMODE(log.file.parent.stat().st_mode) == 0o700


def test_it_takes_no_more_room_than_it_may(log, monkeypatch):
    """20,000 entries of some 70 bytes are 1.4 MB; 4 files of 10 kB keep the newest 40 kB."""
    monkeypatch.setattr(module, "LARGEST", 10_000)
    monkeypatch.setattr(module, "FILES", 4)
    for k in range(200):
        for _ in range(10):
            log.note("a", "goal", k=k)
        log.settle()
    files = sorted(log.file.parent.glob("audit*.jsonl"))
    assert len(files) == 4
    assert all(file.stat().st_size <= 10_000 for file in files)
    entries = log.entries(10_000)
    kept = [entry.said["k"] for entry in entries if entry.what == "goal"]
    dropped = sum(entry.said["count"] for entry in entries if entry.what == "dropped")
    assert dropped > 0
    assert len(kept) + dropped <= 2000
    assert kept == sorted(kept, reverse=True)
    assert kept[0] == 199


def test_a_damaged_line_does_not_hide_the_others(log):
    log.note("a", "joined")
    log.settle()
    with log.file.open("ab") as stream:
        stream.write(b'\xff\xfe\n{"at": "half a li')
    log.note("a", "left")
    assert whats(log) == [("a", "left"), ("a", "joined")]


def test_no_entry_of_many_threads_is_lost(log):
    def note(name):
        for _ in range(100):
            log.note(name, "goal")

    threads = [threading.Thread(target=note, args=(f"page {k}",)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(log.entries()) == 800


def test_what_a_full_disk_did_not_take_is_counted_and_said(log, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as broken:
        broken.setattr(module.os, "write", full)
        log.note("a", "took")
        log.settle()
        assert "No space left" in log.trouble
    log.note("a", "stop")
    assert whats(log) == [("a", "stop"), ("chair", "dropped")]
    assert log.entries()[1].said["count"] == 1
    assert not log.trouble


def test_what_json_cannot_say_is_said_as_text(log):
    log.note("a", "refused", why=StoreError("too much"), speed=float("nan"))
    log.note("a", "left")
    assert whats(log) == [("a", "left"), ("a", "refused")]
    assert "too much" in log.entries()[1].said["why"]


def test_a_folder_that_cannot_be_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="file"):
        Audit(tmp_path / "file" / "data")


def test_nobody_flushes_out_what_the_therapist_did(log, monkeypatch):
    """A page that takes and releases the stick for hours leaves a count, not megabytes."""
    monkeypatch.setattr(module, "AT_ONCE", 5.0)
    log.note("therapist 1", "limits", after={"max_speed": 0.5})
    for _ in range(1000):
        log.note("a", "took")
    for _ in range(3):
        log.note("therapist 1", "limits")
    found = [entry.what for entry in log.entries()]
    assert found.count("took") <= 6
    assert found.count("limits") == 4
    dropped = sum(entry.said["count"] for entry in log.entries() if entry.what == "dropped")
    assert dropped + found.count("took") == 1000
