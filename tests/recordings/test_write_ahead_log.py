"""Messages of a database that are still in its write-ahead log."""

import shutil
import sqlite3
from contextlib import closing

import pytest

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording

from .bags import ROS2, walk, write


@pytest.fixture
def live(tmp_path):
    """(database, connection) of a recorder that has five messages in its log, and none beside."""
    bag = write(tmp_path / "bag", walk(ROS2), "db3")
    file = bag / "bag.db3"
    (bag / "metadata.yaml").unlink()
    with closing(sqlite3.connect(file, isolation_level=None)) as recorder:
        rows = recorder.execute("SELECT topic_id, timestamp, data FROM messages").fetchall()
        recorder.execute("DELETE FROM messages")
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("PRAGMA wal_autocheckpoint=0")
        for row in rows:
            insert(recorder, row)
        yield file, recorder


def insert(recorder, row):
    recorder.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", row)


def content(folder):
    """Bytes of all files but the index, which SQLite makes from the log."""
    return {f.name: f.read_bytes() for f in sorted(folder.iterdir()) if f.suffix != ".db3-shm"}


def copied(live, folder, *endings):
    """The database as it is after the recorder was killed."""
    folder.mkdir()
    for ending in ("", *endings):
        shutil.copy(f"{live[0]}{ending}", folder)
    return folder


@pytest.mark.parametrize("endings", [("-wal",), ("-wal", "-shm")], ids=" ".join)
@pytest.mark.parametrize("alone", [True, False])
def test_messages_in_the_log_are_read_and_no_file_changes(live, tmp_path, endings, alone):
    folder = copied(live, tmp_path / "killed", *endings)
    before = content(folder)
    folder.chmod(0o555)
    recording = open_recording(folder / "bag.db3" if alone else folder)
    ranges = [frame.observation.scans[0].ranges[2] for frame in recording]
    assert ranges == pytest.approx([2.0, 2.1, 2.2, 2.3, 2.4])
    folder.chmod(0o755)
    assert content(folder) == before
    assert not any("-wal" in text for text in recording.warnings)


def test_a_bag_that_is_still_written_gives_what_is_committed(live):
    file, recorder = live
    assert len(list(open_recording(file))) == 5
    (row,) = recorder.execute("SELECT topic_id, timestamp, data FROM messages LIMIT 1").fetchall()
    insert(recorder, row)
    recording = open_recording(file)
    frames = iter(recording)
    next(frames)
    # The recorder is not held up by a reader.
    insert(recorder, row)
    assert len(list(open_recording(file))) == 7
    recorder.execute("PRAGMA wal_checkpoint(PASSIVE)")
    assert len(list(open_recording(file))) == 7


def test_a_split_bag_has_a_log_beside_its_last_file(live, tmp_path):
    folder = copied(live, tmp_path / "split", "-wal")
    for ending in ("", "-wal"):
        (folder / f"bag.db3{ending}").rename(folder / f"bag_10.db3{ending}")
    shutil.copy(write(tmp_path / "first", walk(ROS2), "db3") / "first.db3", folder / "bag_9.db3")
    assert len(list(open_recording(folder))) == 10


def test_the_log_of_a_database_behind_a_link_is_read(live, tmp_path):
    folder = copied(live, tmp_path / "killed", "-wal")
    (tmp_path / "link.db3").symlink_to(folder / "bag.db3")
    assert len(list(open_recording(tmp_path / "link.db3"))) == 5


def cut(log):
    return log[:-100]


def flipped(log):
    """One bit of the page before the last one."""
    at = len(log) - 6000
    return log[:at] + bytes([log[at] ^ 1]) + log[at + 1 :]


@pytest.mark.parametrize("damage", [cut, flipped])
def test_pages_of_the_log_that_are_damaged_are_counted(live, tmp_path, damage):
    folder = copied(live, tmp_path / "killed", "-wal")
    log = folder / "bag.db3-wal"
    log.write_bytes(damage(log.read_bytes()))
    recording = open_recording(folder)
    # Each message is one commit; the damage lies in the last one.
    assert len(list(recording)) == 4
    (text,) = [text for text in recording.warnings if "-wal" in text]
    assert "pages at its end are damaged or not committed" in text


def test_a_log_of_which_nothing_is_sound_is_said(live, tmp_path):
    folder = copied(live, tmp_path / "killed", "-wal")
    log = folder / "bag.db3-wal"
    log.write_bytes(bytes(32) + log.read_bytes()[32:])
    with pytest.raises(RecordingError, match=r"no messages.*bag\.db3-wal: \d+ pages"):
        open_recording(folder)


def test_a_transaction_without_its_commit_is_said(live):
    file, recorder = live
    recorder.execute("PRAGMA cache_size=1")
    recorder.execute("BEGIN")
    for k in range(300):  # more than the cache holds: it spills into the log
        insert(recorder, (1, k, bytes(4000)))
    recording = open_recording(file)
    assert len(list(recording)) == 5
    assert any("-wal" in text and "not committed" in text for text in recording.warnings)
    recorder.execute("ROLLBACK")
